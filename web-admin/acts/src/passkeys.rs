//! Passkeys (WebAuthn) as a second factor: made, asked for a signature, renamed and removed. What was asked is kept here and good
//! once; everything is in the audit log.

use std::net::IpAddr;

use model::ids::{CeremonyId, PasskeyId};
use model::passkey::PasskeyQuestion;
use model::{CurrentPerson, PersonKey};
use serde_json::json;
use store::audit::AuditEntry;
use store::passkeys::{KeptPasskey, NewPasskey, PasskeySignature};
use store::{passkeys, people, second_factors};
use webauthn_rs::prelude::{Passkey, PasskeyAuthentication, PasskeyRegistration};

use crate::ceremonies::{self, PasskeyChallenge};
use crate::error::Error;
use crate::passkey_site::{AnswerRefused, PasskeyOwner, Site};
use crate::second_factor;
use crate::second_factor::{Enrolled, SignInProof};
use crate::service::Service;
use crate::tokens::checked_name;

/// Most passkeys that somebody has.
pub const MOST: usize = 20;

/// What a browser has brought.
#[derive(Clone, Copy, Debug)]
pub struct PasskeyAnswer<'a> {
    /// Which question the session holds.
    pub question: Option<CeremonyId>,
    /// The answer, in JSON.
    pub json: &'a str,
    /// From which network address.
    pub from: IpAddr,
}

/// What came of an answer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PasskeyCheck {
    /// A passkey has signed.
    Proved(SignInProof),
    /// Nothing was asked, it is too late, or it was answered before.
    Late,
    /// The answer is refused.
    Refused(AnswerRefused),
}

/// What somebody is told where passkeys cannot be used.
#[must_use]
pub fn no_site() -> Error {
    let why =
        tr!("there are no passkeys here: browsers have them only for https and a host that has a name, or localhost");
    Error::Conflict(why.to_owned())
}

/// Asks somebody's passkeys for a signature. None where they have none, or the service has no site.
///
/// # Errors
/// When the question cannot be made, or the database fails.
pub async fn ask(state: &Service, key: PersonKey) -> Result<Option<PasskeyQuestion>, Error> {
    let Some(site) = state.passkeys.site() else { return Ok(None) };
    let known = passkeys::list_passkeys(state.db.reader(), key).await?;
    if known.is_empty() {
        return Ok(None);
    }
    let known: Vec<Passkey> = known.into_iter().map(|kept| kept.public_key.0).collect();
    let (options, asked) = site.ask_to_sign(&known)?;
    let id = ceremonies::begin(state, key.person_id, PasskeyChallenge::ToSign(Box::new(asked))).await?;
    Ok(Some(PasskeyQuestion { id, options, origin: site.origin().to_owned() }))
}

/// Whether a passkey has signed what was asked. Each question is good once, and each try is counted.
///
/// # Errors
/// When there were too many tries, or the database fails.
pub async fn check(state: &Service, key: PersonKey, answer: PasskeyAnswer<'_>) -> Result<PasskeyCheck, Error> {
    second_factor::take_try(state, key, answer.from).await?;
    let site = state.passkeys.site().ok_or_else(no_site)?;
    let signed = match take(state, key, answer.question).await? {
        Some(PasskeyChallenge::ToSign(asked)) => signed(state, key, site, &asked, answer.json).await?,
        _ => PasskeyCheck::Late,
    };
    match signed {
        PasskeyCheck::Proved(_) => {}
        PasskeyCheck::Late => second_factor::note(state, key, "second_factor.refused").await?,
        PasskeyCheck::Refused(why) => {
            tracing::warn!(from = %answer.from, person = %key.person_id, ?why, "an answer of a passkey is refused");
            let action = match why {
                AnswerRefused::Wrong => "second_factor.refused",
                AnswerRefused::Copied => "passkey.counted_backwards",
            };
            second_factor::note(state, key, action).await?;
        }
    }
    Ok(signed)
}

async fn take(
    state: &Service,
    key: PersonKey,
    question: Option<CeremonyId>,
) -> Result<Option<PasskeyChallenge>, Error> {
    let Some(question) = question else { return Ok(None) };
    ceremonies::take(state, question, key.person_id).await
}

async fn signed(
    state: &Service,
    key: PersonKey,
    site: &Site,
    asked: &PasskeyAuthentication,
    json: &str,
) -> Result<PasskeyCheck, Error> {
    let result = match site.signed(json, asked) {
        Ok(result) => result,
        Err(why) => return Ok(PasskeyCheck::Refused(why)),
    };
    let mut tx = state.db.write().await?;
    let kept = passkeys::list_passkeys(&mut *tx, key).await?;
    // It may have been removed since it was asked.
    let Some(kept) = kept.into_iter().find(|kept| kept.public_key.cred_id() == result.cred_id()) else {
        return Ok(PasskeyCheck::Refused(AnswerRefused::Wrong));
    };
    let mut public_key = kept.public_key.0;
    public_key.update_credential(&result);
    let signature = PasskeySignature { public_key: &public_key, count: result.counter(), at: state.clock.now() };
    // By what is kept now: two questions may have been asked at one count.
    if !passkeys::take_signature(&mut tx, key, kept.id, signature).await? {
        return Ok(PasskeyCheck::Refused(AnswerRefused::Copied));
    }
    tx.commit().await?;
    Ok(PasskeyCheck::Proved(SignInProof::Passkey))
}

/// Asks somebody's browser for a new passkey.
///
/// # Errors
/// When the name is not allowed, there are too many, the service has no site, or the database fails.
pub async fn ask_to_make(state: &Service, person: &CurrentPerson, name: &str) -> Result<PasskeyQuestion, Error> {
    let site = state.passkeys.site().ok_or_else(no_site)?;
    let name = checked_name(name)?;
    let (reader, key) = (state.db.reader(), PersonKey::from(person));
    let known = passkeys::list_passkeys(reader, key).await?;
    if known.len() >= MOST {
        let why = tr!("there are {most} passkeys, the most allowed: remove one that is not used", most = MOST);
        return Err(Error::Unprocessable(why));
    }
    let account = people::find_person(reader, person.id).await?.ok_or(Error::NotFound)?;
    let owner = PasskeyOwner { id: person.id, email: &account.email, name: &person.display_name };
    let known = known.iter().map(|kept| kept.public_key.cred_id().clone()).collect();
    let (options, asked) = site.ask_to_make(owner, known)?;
    let asked = PasskeyChallenge::ToMake { name, state: Box::new(asked) };
    let id = ceremonies::begin(state, person.id, asked).await?;
    Ok(PasskeyQuestion { id, options, origin: site.origin().to_owned() })
}

/// Keeps the passkey that was made; the first second factor comes with recovery codes and ends every other sign-in. None where
/// the answer is refused, late, or was given before.
///
/// # Errors
/// When the passkey is somebody's already, or the database fails.
pub async fn make(
    state: &Service,
    person: &CurrentPerson,
    answer: PasskeyAnswer<'_>,
) -> Result<Option<Enrolled>, Error> {
    let key = PersonKey::from(person);
    let site = state.passkeys.site().ok_or_else(no_site)?;
    let made = match take(state, key, answer.question).await? {
        Some(PasskeyChallenge::ToMake { name, state }) => read_made(site, answer.json, &state).map(|made| (name, made)),
        _ => None,
    };
    let Some((name, made)) = made else {
        second_factor::note(state, key, "passkey.refused").await?;
        return Ok(None);
    };
    let first = !second_factors::is_second_factor_on(state.db.reader(), key).await?;
    let codes = if first { Some(second_factor::make_codes(state, key).await?) } else { None };
    let now = state.clock.now();
    let mut tx = state.db.write().await?;
    let new = NewPasskey { id: PasskeyId::random(), name: &name, public_key: &made, made_at: now };
    if !passkeys::add_passkey(&mut tx, key, new).await? {
        return Err(Error::Conflict(tr!("this passkey is known here already: make another").to_owned()));
    }
    let details = json!({ "passkey": new.id, "first": first });
    AuditEntry::by(person, "passkey.added", person.id).with(details).append(&mut tx, now).await?;
    let enrolled = match codes {
        Some((codes, hashes)) => {
            second_factors::put_recovery_codes(&mut tx, key, &hashes).await?;
            people::end_sign_ins(&mut tx, key.person_id).await?;
            Enrolled::First(codes)
        }
        None => Enrolled::Another,
    };
    tx.commit().await?;
    Ok(Some(enrolled))
}

fn read_made(site: &Site, json: &str, state: &PasskeyRegistration) -> Option<Passkey> {
    site.made(json, state).ok()
}

/// One of somebody's passkeys.
///
/// # Errors
/// When there is none by this id, or the database fails.
pub async fn find(state: &Service, person: &CurrentPerson, id: PasskeyId) -> Result<KeptPasskey, Error> {
    passkeys::find_passkey(state.db.reader(), person.into(), id).await?.ok_or(Error::NotFound)
}

/// Gives one's passkey another name.
///
/// # Errors
/// When there is none by this id, the name is not allowed, or the database fails.
pub async fn rename(state: &Service, person: &CurrentPerson, id: PasskeyId, name: &str) -> Result<(), Error> {
    let name = checked_name(name)?;
    let mut tx = state.db.write().await?;
    if !passkeys::rename_passkey(&mut tx, person.into(), id, &name).await? {
        return Err(Error::NotFound);
    }
    let details = json!({ "passkey": id });
    AuditEntry::by(person, "passkey.renamed", person.id).with(details).append(&mut tx, state.clock.now()).await?;
    Ok(tx.commit().await?)
}

/// Removes one's passkey; with the last second factor the recovery codes go, and a mail tells.
///
/// # Errors
/// When there is none by this id, or the database fails.
pub async fn remove(state: &Service, person: &CurrentPerson, id: PasskeyId) -> Result<(), Error> {
    let key = PersonKey::from(person);
    let mut tx = state.db.write().await?;
    if !passkeys::remove_passkey(&mut tx, key, id).await? {
        return Err(Error::NotFound);
    }
    let details = json!({ "passkey": id });
    AuditEntry::by(person, "passkey.removed", person.id).with(details).append(&mut tx, state.clock.now()).await?;
    second_factor::end_if_last(&mut tx, person, state.clock.now()).await?;
    tx.commit().await?;
    state.mails.notify_one();
    Ok(())
}
