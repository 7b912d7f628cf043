//! Is everything still what was written: the database, every recording, the audit log.

use std::collections::BTreeSet;

use anyhow::Context;
use model::directory::AccountState;
use store::sessions::{self, RecordingFile};
use store::{Connection, Database, audit, directory, grades, scores};

use crate::anchoring::AuditHead;
use crate::config::Config;
use crate::erasure_store::ErasureStore;
use crate::erasures::Erasure;
use crate::recording_store::{RecordingStore, StoreError};

/// What was looked at, and what is wrong with it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct VerificationReport {
    /// Recordings whose bytes were read.
    pub recordings: usize,
    /// Rows of the audit log.
    pub audit_rows: usize,
    /// Hash of the audit log's last row, in hexadecimal.
    pub audit_head: String,
    /// What is wrong, each in words that name the place.
    pub findings: Vec<String>,
}

/// Checks everything; blocks while it reads the recordings.
///
/// # Errors
/// When the database cannot be read at all, or the store of the recordings does not answer.
pub async fn everything(db: &Database, store: &RecordingStore) -> anyhow::Result<VerificationReport> {
    let recordings = sessions::list_recordings(db.reader()).await?;
    let mut report = check_all(db, store, &recordings).await?;
    report.findings.extend(unnamed(store, &recordings).await?);
    Ok(report)
}

/// Checks a copy of a database that was made while others went on: recordings that came since are none of its own, and those that were
/// erased since need not be there. Blocks while it reads the recordings.
///
/// # Errors
/// As [`everything`].
pub async fn copy(
    copy: &Database,
    served: Option<&Database>,
    store: &RecordingStore,
) -> anyhow::Result<VerificationReport> {
    let mut recordings = sessions::list_recordings(copy.reader()).await?;
    if let Some(served) = served {
        let kept: BTreeSet<_> = sessions::list_recordings(served.reader()).await?.into_iter().map(|r| r.id).collect();
        recordings.retain(|recording| kept.contains(&recording.id));
    }
    check_all(copy, store, &recordings).await
}

async fn check_all(
    db: &Database,
    store: &RecordingStore,
    recordings: &[RecordingFile],
) -> anyhow::Result<VerificationReport> {
    let mut findings = db.integrity().await?;
    store.check().await.with_context(|| store.place())?;
    findings.extend(check_files(store, recordings).await);
    findings.extend(db.lost_triggers().await?);
    let chain = audit::check_audit_chain(db.reader()).await?;
    findings.extend(chain.findings);
    findings.extend(contradictions(&mut *db.reader().acquire().await?).await?);
    Ok(VerificationReport { recordings: recordings.len(), audit_rows: chain.rows, audit_head: chain.head, findings })
}

/// Checks that the audit log still holds a row by whose hash it once ended, as a backup or `verify` has told it: a log that was
/// cut since, or made anew, does not.
///
/// # Errors
/// When the database cannot be read at all.
pub async fn cut_tail(db: &Database, head: &str) -> anyhow::Result<Option<String>> {
    let finding =
        || format!("audit log: no row has the hash {head}: the log was cut or made anew since that was its end");
    Ok((!audit::holds_hash(db.reader(), head).await?).then(finding))
}

/// Checks that the audit log still holds what a signed statement says of its end.
///
/// # Errors
/// When the database cannot be read at all.
pub async fn strayed_from(
    db: &Database,
    AuditHead { rows, head, made_at, .. }: &AuditHead,
) -> anyhow::Result<Option<String>> {
    let finding = || {
        format!(
            "audit log: row {rows} has not the hash {head} that was stated at {made_at}: the log was cut or made anew since"
        )
    };
    Ok((*rows > 0 && !audit::holds_hash_at(db.reader(), *rows, head).await?).then(finding))
}

/// People who were erased and are here all the same: a database that was put in its place without `web-admin restore` brings them back.
///
/// # Errors
/// When the database cannot be read.
pub async fn unerased(db: &Database, list: &ErasureStore) -> anyhow::Result<Vec<String>> {
    let erasures = match list.read().await {
        Ok(erasures) => erasures,
        Err(unreadable) => return Ok(vec![format!("list of erasures: {unreadable:#}")]),
    };
    let mut findings = Vec::new();
    for Erasure { at, school_id, person_id, .. } in erasures {
        let known = directory::find_directory_entry(db.reader(), school_id, person_id).await?;
        if known.is_some_and(|person| person.state != AccountState::Erased) {
            findings.push(format!(
                "person {person_id}: was erased at {at} and is here again; start the service, which erases them"
            ));
        }
    }
    Ok(findings)
}

/// Refuses to make a new database beside recordings: the one that names them is lost, or a restore was stopped in its midst.
///
/// # Errors
/// When there are recordings and no database, with what to do.
pub async fn refuse_lost_database(config: &Config) -> anyhow::Result<()> {
    let staging = config.restoring_dir();
    anyhow::ensure!(
        !staging.exists(),
        "{}: a restore was stopped in its midst; run it again, or remove this folder",
        staging.display()
    );
    let there = Database::is_there(&config.database).await.context("cannot open the database")?;
    let store = RecordingStore::open(config)?;
    if there || store.list().await.with_context(|| store.place())?.is_empty() {
        return Ok(());
    }
    anyhow::bail!(
        "{}: there is no database, but {} holds recordings; restore a backup, or name an empty place for recordings",
        config.database,
        store.place()
    )
}

/// Scores that are not those that the audit log tells of, each in words; and grades that are not their score. Attempts that the log
/// does not name at all were made by `web-admin bench`.
///
/// # Errors
/// When the database cannot be read.
pub async fn contradictions(reader: &mut Connection) -> anyhow::Result<Vec<String>> {
    let (told, kept) = (audit::list_told_scores(&mut *reader).await?, scores::count_added_scores(&mut *reader).await?);
    let mut findings: Vec<String> = told
        .iter()
        .filter(|(session, told)| !is_same(told, kept.get(*session).map_or(&[][..], Vec::as_slice)))
        .map(|(session, told)| {
            let kept = kept.get(session).map_or(&[][..], Vec::as_slice);
            format!("scores of session {session}: {kept:?}; the audit log tells of {told:?}")
        })
        .collect();
    let strayed = grades::list_strayed_grades(reader).await?;
    findings.extend(strayed.iter().map(|session| format!("grade of session {session}: it is not that of its score")));
    Ok(findings)
}

/// Whether two lists hold the same scores in the same order, as far as text can tell.
fn is_same(told: &[f64], kept: &[f64]) -> bool {
    told.len() == kept.len() && told.iter().zip(kept).all(|(told, kept)| (told - kept).abs() < 1e-9)
}

/// Recordings that no row names, each in words. A crash between the two leaves one, and so does a database that has lost rows.
///
/// # Errors
/// When the folder cannot be read, or the bucket does not answer.
pub async fn unnamed(store: &RecordingStore, named: &[RecordingFile]) -> Result<Vec<String>, StoreError> {
    let named: BTreeSet<&str> = named.iter().map(|recording| &*recording.recording_path).collect();
    let found = store.list().await?;
    let lost = found.iter().filter(|path| !named.contains(path.as_str()));
    Ok(lost.map(|path| format!("{path}: no attempt names this recording; upload it to take it in")).collect())
}

async fn check_files(store: &RecordingStore, recordings: &[RecordingFile]) -> Vec<String> {
    let bar = indicatif::ProgressBar::new(recordings.len() as u64);
    let mut findings = Vec::new();
    for recording in recordings {
        bar.inc(1);
        findings.extend(check_file(store, recording).await);
    }
    bar.finish_and_clear();
    findings
}

/// What is wrong with a recording's file, if anything is.
async fn check_file(store: &RecordingStore, recording: &RecordingFile) -> Option<String> {
    let RecordingFile { id, recording_path, recording_sha256, recording_size } = recording;
    match store.hash(recording_path).await {
        Err(error) => Some(format!("recording of session {id}: {recording_path}: {error}")),
        Ok((_, size)) if i64::try_from(size) != Ok(*recording_size) => {
            Some(format!("recording of session {id}: {recording_path}: {size} bytes; {recording_size} were stored"))
        }
        Ok((sha256, _)) if sha256 != *recording_sha256 => {
            Some(format!("recording of session {id}: {recording_path}: its bytes are not those that were stored"))
        }
        Ok(_) => None,
    }
}
