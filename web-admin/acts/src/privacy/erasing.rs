//! Erases a person: removes all identifying data for good, from the database and from backups
//! restored later.

use std::sync::atomic::Ordering;

use model::ids::SchoolId;
use model::people::directory::{AccountState, DirectoryEntry};
use model::{CurrentPerson, PersonKey};
use serde_json::{Value, json};
use store::Connection;
use store::audit::{Actor, AuditEntry};
use store::auth::{second_factors, tokens};
use store::operations::schools;
use store::people::directory;
use store::privacy::texts::{ErasedRecording, TextOwner, TextSide};
use store::privacy::{retention, texts};
use store::scoring::exam_files;
use store::training::{badges, learning_records, outcomes};

use crate::error::Error;
use crate::privacy::erasure_store::ErasureStore;
use crate::privacy::erasures::{Erasure, ErasureScope};
use crate::service::Service;

/// Actor of an erasure, and details for the audit log.
#[derive(Clone, Debug)]
pub struct Eraser {
    /// Actor.
    pub actor: Actor,
    /// Reason, if it does not follow from the actor.
    pub why: Option<Value>,
}

impl Eraser {
    /// Returns a signed-in person as the actor.
    #[must_use]
    pub fn person(person: &CurrentPerson) -> Self {
        Self { actor: Actor::Person(person.id), why: None }
    }
}

/// Returns the scope of an erasure: texts as requested, recordings if the school's policy erases
/// them.
pub async fn wish_of_school(
    state: &Service,
    school: SchoolId,
    written: bool,
    about: bool,
) -> Result<ErasureScope, Error> {
    let recordings = schools::erases_recordings(state.db.reader(), school).await?;
    Ok(ErasureScope { written, about, recordings })
}

/// Removes all identifying data of a person for good. Attempts and scores stay, under the
/// pseudonym.
///
/// # Errors
/// Returns [`Error::Conflict`] if the person is on legal hold. Fails if the erasure list, the mail
/// folder or the database cannot be written; the database is unchanged then.
pub async fn erase(
    state: &Service,
    by: Eraser,
    person: &DirectoryEntry,
    school_id: SchoolId,
    wish: ErasureScope,
) -> Result<(), Error> {
    let erasure =
        Erasure { at: state.clock.now(), school_id, person_id: person.id, pseudonym: person.pseudonym.clone(), wish };
    let list = ErasureStore::of(&state.config, &state.recordings);
    // Before the write lock is taken: an unresponsive bucket must not block other writers.
    list.check().await?;
    let mut tx = state.db.write().await?;
    if retention::find_hold_time(&mut *tx, school_id, person.id).await?.is_some() {
        return Err(Error::Conflict(tr!("this person is on legal hold: end the hold first").to_owned()));
    }
    let (gone, mut told) = take_away(&mut tx, state, person, &erasure).await?;
    if let Some(why) = by.why {
        told["why"] = why;
    }
    AuditEntry::new(school_id, by.actor, "person.erased", person.id).with(told).append(&mut tx, erasure.at).await?;
    // Before the commit, so that no committed erasure is ever missing from the list.
    let done = match list.add(&erasure).await {
        Ok(()) => tx.commit().await.map_err(Error::from),
        Err(error) => {
            drop(tx);
            Err(error.into())
        }
    };
    if let Err(error) = done {
        // A database that went away may have committed: then the list must name the person, and the next start completes the erasure.
        if !matches!(error, Error::DatabaseUnavailable(_)) {
            take_back(&list, &erasure).await;
        }
        return Err(error);
    }
    // The write-ahead log still contains the erased data until it is truncated.
    state.db.fold_log().await?;
    remove(state, gone).await
}

/// Removes a failed erasure from the list.
async fn take_back(list: &ErasureStore, erasure: &Erasure) {
    if let Err(cause) = list.take_back(erasure).await {
        let person = erasure.person_id;
        tracing::error!(%cause, %person, "erasure failed; if it is on the list, the next start carries it out");
    }
}

/// Removes data from the database, and stored mails. Returns the recordings to delete after the
/// commit, and the details for the audit log.
async fn take_away(
    tx: &mut Connection,
    state: &Service,
    person: &DirectoryEntry,
    erasure: &Erasure,
) -> Result<(Vec<ErasedRecording>, Value), Error> {
    let whose = TextOwner { school_id: erasure.school_id, person_id: person.id, until: erasure.at };
    let mut told = json!({});
    if person.state != AccountState::Erased {
        let key = PersonKey { school_id: erasure.school_id, person_id: person.id };
        tokens::revoke_all_tokens(tx, person.id, erasure.at).await?;
        tokens::forget_names(tx, key).await?;
        second_factors::remove_second_factor(tx, key).await?;
        let letters = directory::list_letters_to(&mut *tx, person, erasure.school_id).await?;
        retention::forget_warning(tx, person.id).await?;
        outcomes::forget_notes(tx, key).await?;
        let frozen = exam_files::empty_exam_files(tx, key).await?;
        if frozen > 0 {
            told["exam_files"] = frozen.into();
        }
        directory::erase_person(tx, person, erasure.school_id, erasure.at).await?;
        learning_records::withdraw_consents(tx, key, erasure.at).await?;
        let sent = learning_records::mark_erased(tx, key).await?;
        if sent > 0 {
            told["statements_sent"] = sent.into();
        }
        let revoked = badges::revoke_badges_of(tx, key, erasure.at).await?;
        if revoked > 0 {
            told["badges_revoked"] = revoked.into();
        }
        // Before the commit: if the mails cannot be deleted, the erasure fails and their record is
        // kept.
        state.mailer.forget(&letters).await?;
    }
    for (wished, side, word) in [
        (erasure.wish.written, TextSide::Written, "texts_written"),
        (erasure.wish.about, TextSide::About, "texts_about"),
    ] {
        if wished {
            told[word] = texts::redact_texts(tx, whose, side).await?.into();
        }
    }
    let mut gone = Vec::new();
    if erasure.wish.recordings {
        gone = texts::recordings(tx, whose).await?;
        texts::note_erased_recordings(tx, whose).await?;
        told["recordings"] = gone.len().into();
    }
    Ok((gone, told))
}

/// Deletes recordings and the files derived from them. If the store is unavailable, [`remove_left`]
/// deletes the rest later.
async fn remove(state: &Service, gone: Vec<ErasedRecording>) -> Result<(), Error> {
    let removed = state.recordings.remove(&state.config, gone).await;
    state.erased_left.fetch_or(removed.is_err(), Ordering::Relaxed);
    Ok(removed?)
}

/// Deletes the remaining recordings of erased people, after the store was unavailable.
///
/// # Errors
/// Fails if the store is still unavailable.
pub async fn remove_left(state: &Service) -> Result<(), Error> {
    if !state.erased_left.load(Ordering::Relaxed) {
        return Ok(());
    }
    // Reset the flag before listing, so that a failure in the meantime sets it again.
    state.erased_left.store(false, Ordering::Relaxed);
    remove(state, texts::all_erased(state.db.reader()).await?).await
}

/// Carries out every erasure of the list that is missing from the database, because a backup was
/// restored or the service ended between the two writes. Returns the number of people erased again.
///
/// # Errors
/// Fails if the list cannot be read, or the database or the disk fails.
pub async fn catch_up(state: &Service) -> anyhow::Result<usize> {
    let mut again = 0;
    for erasure in ErasureStore::of(&state.config, &state.recordings).read().await? {
        if !is_outstanding(state, &erasure).await? {
            continue;
        }
        let mut tx = state.db.write().await?;
        // Read within the transaction: another replica that starts may have done it already.
        let found = directory::find_anybody(&mut *tx, erasure.school_id, erasure.person_id).await?;
        let Some(person) = found else { continue };
        let (_, mut told) = take_away(&mut tx, state, &person, &erasure).await.map_err(anyhow::Error::new)?;
        told["again"] = true.into();
        told["first"] = json!(erasure.at);
        AuditEntry::new(erasure.school_id, Actor::CommandLine, "person.erased", person.id)
            .with(told)
            .append(&mut tx, state.clock.now())
            .await?;
        tx.commit().await?;
        again += 1;
    }
    // Includes recordings left by a service that was killed right after its commit.
    remove(state, texts::all_erased(state.db.reader()).await?).await.map_err(anyhow::Error::new)?;
    Ok(again)
}

/// Returns whether an erasure still has data to remove.
async fn is_outstanding(state: &Service, erasure: &Erasure) -> store::Result<bool> {
    let Erasure { at, school_id, person_id, wish, .. } = erasure;
    let reader = state.db.reader();
    let Some(person) = directory::find_anybody(reader, *school_id, *person_id).await? else { return Ok(false) };
    if person.state != AccountState::Erased {
        return Ok(true);
    }
    let whose = TextOwner { school_id: *school_id, person_id: *person_id, until: *at };
    let mut left = 0;
    if wish.written || wish.about {
        let texts = texts::count_texts(reader, whose).await?;
        left += if wish.written { texts.written } else { 0 };
        left += if wish.about { texts.about } else { 0 };
    }
    let mut connection = reader.acquire().await?;
    let kept = if wish.recordings { texts::recordings(&mut connection, whose).await? } else { Vec::new() };
    Ok(left > 0 || !kept.is_empty())
}
