//! Verifies the integrity of the database, all recordings, and the audit log.

use std::collections::BTreeSet;

use anyhow::Context;
use model::people::directory::AccountState;
use platform::config::Config;
use platform::recording_store::{RecordingStore, StoreError};
use store::people::directory;
use store::recordings::sessions;
use store::recordings::sessions::RecordingFile;
use store::scoring::{grades, scores};
use store::{Connection, Database, audit};

use crate::audit::audit_checkpoints::AuditHead;
use crate::privacy::erasure_store::ErasureStore;
use crate::privacy::erasures::Erasure;

/// Result of a verification.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct VerificationReport {
    /// Number of recordings whose bytes were verified.
    pub recordings: usize,
    /// Number of rows in the audit log.
    pub audit_rows: usize,
    /// Hash of the last row of the audit log, hexadecimal.
    pub audit_head: String,
    /// Findings, each naming the damaged place.
    pub findings: Vec<String>,
}

/// Verifies everything; blocks while it reads the recordings.
///
/// # Errors
/// Fails if the database cannot be read at all, or the recording store does not respond.
pub async fn everything(db: &Database, store: &RecordingStore) -> anyhow::Result<VerificationReport> {
    let recordings = sessions::list_recordings(db.reader()).await?;
    let mut report = check_all(db, store, &recordings).await?;
    report.findings.extend(unnamed(store, &recordings).await?);
    Ok(report)
}

/// Verifies a copy of a database made while the service was running: newer recordings are ignored,
/// and recordings erased since may be missing. Blocks while it reads the recordings.
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

/// Checks that the audit log still contains the row with hash `head`, which was its last one when a
/// backup or `verify` reported it. A log that has been truncated or rewritten since does not.
///
/// # Errors
/// Fails if the database cannot be read at all.
pub async fn cut_tail(db: &Database, head: &str) -> anyhow::Result<Option<String>> {
    let finding =
        || format!("audit log: no row has the hash {head}: the log was truncated or rebuilt since it ended there");
    Ok((!audit::holds_hash(db.reader(), head).await?).then(finding))
}

/// Checks that the audit log still contains the row described by a signed checkpoint.
///
/// # Errors
/// Fails if the database cannot be read at all.
pub async fn strayed_from(
    db: &Database,
    AuditHead { rows, head, made_at, .. }: &AuditHead,
) -> anyhow::Result<Option<String>> {
    let finding = || {
        format!(
            "audit log: row {rows} does not have the hash {head} of the checkpoint of {made_at}: the log was truncated or rebuilt since"
        )
    };
    Ok((*rows > 0 && !audit::holds_hash_at(db.reader(), *rows, head).await?).then(finding))
}

/// Finds erased people who are in the database: it was put in place without `web-admin restore`.
///
/// # Errors
/// Fails if the database cannot be read.
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
                "person {person_id}: erased at {at}, but present again; start the service to erase them"
            ));
        }
    }
    Ok(findings)
}

/// Refuses to create a new database where recordings exist: the database that belongs to them is
/// lost, or a restore was interrupted.
///
/// # Errors
/// Fails in that case, with advice.
pub async fn refuse_lost_database(config: &Config) -> anyhow::Result<()> {
    let staging = config.restoring_dir();
    anyhow::ensure!(
        !staging.exists(),
        "{}: a restore was interrupted; run it again, or delete this folder",
        staging.display()
    );
    let there = Database::is_there(&config.database).await.context("cannot open the database")?;
    let store = RecordingStore::open(config)?;
    if there || store.list().await.with_context(|| store.place())?.is_empty() {
        return Ok(());
    }
    anyhow::bail!(
        "{}: no database, but {} contains recordings; restore a backup, or choose an empty place for recordings",
        config.database,
        store.place()
    )
}

/// Finds scores that differ from those in the audit log, and grades that differ from their score.
/// Attempts that are missing in the log were generated by `web-admin bench` and are not checked.
///
/// # Errors
/// Fails if the database cannot be read.
pub async fn contradictions(reader: &mut Connection) -> anyhow::Result<Vec<String>> {
    let (told, kept) = (audit::list_told_scores(&mut *reader).await?, scores::count_added_scores(&mut *reader).await?);
    let mut findings: Vec<String> = told
        .iter()
        .filter(|(session, told)| !is_same(told, kept.get(*session).map_or(&[][..], Vec::as_slice)))
        .map(|(session, told)| {
            let kept = kept.get(session).map_or(&[][..], Vec::as_slice);
            format!("scores of session {session}: {kept:?}; the audit log contains {told:?}")
        })
        .collect();
    let strayed = grades::list_strayed_grades(reader).await?;
    findings.extend(strayed.iter().map(|session| format!("grade of session {session}: does not match its score")));
    Ok(findings)
}

/// Returns whether two lists contain the same scores in the same order, up to the precision of
/// their text form.
fn is_same(told: &[f64], kept: &[f64]) -> bool {
    told.len() == kept.len() && told.iter().zip(kept).all(|(told, kept)| (told - kept).abs() < 1e-9)
}

/// Finds recordings without a row, which a crash during an upload or a database with lost rows
/// leaves behind.
///
/// # Errors
/// Fails if the folder cannot be read, or the bucket does not respond.
pub async fn unnamed(store: &RecordingStore, named: &[RecordingFile]) -> Result<Vec<String>, StoreError> {
    let named: BTreeSet<&str> = named.iter().map(|recording| &*recording.recording_path).collect();
    let found = store.list().await?;
    let lost = found.iter().filter(|path| !named.contains(path.as_str()));
    Ok(lost.map(|path| format!("{path}: no attempt refers to this recording; upload it to add it")).collect())
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

/// Returns the problem with a recording's file, if any.
async fn check_file(store: &RecordingStore, recording: &RecordingFile) -> Option<String> {
    let RecordingFile { id, recording_path, recording_sha256, recording_size } = recording;
    match store.hash(recording_path).await {
        Err(error) => Some(format!("recording of session {id}: {recording_path}: {error}")),
        Ok((_, size)) if i64::try_from(size) != Ok(*recording_size) => {
            Some(format!("recording of session {id}: {recording_path}: {size} bytes; {recording_size} were stored"))
        }
        Ok((sha256, _)) if sha256 != *recording_sha256 => {
            Some(format!("recording of session {id}: {recording_path}: the bytes do not match the stored hash"))
        }
        Ok(_) => None,
    }
}
