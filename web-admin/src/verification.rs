//! Is everything still what was written: the database, every recording, the audit log.

use std::path::Path;

use anyhow::Context;

use crate::config::Config;
use crate::recordings::hash_file;
use crate::storage::Database;
use crate::storage::audit;
use crate::storage::sessions::{self, RecordingFile};

/// What was looked at, and what is wrong with it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Report {
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
/// When the database cannot be read at all.
pub async fn everything(db: &Database, recordings_dir: &Path) -> anyhow::Result<Report> {
    let mut findings = db.integrity().await?;
    let recordings = sessions::recordings(db.reader()).await?;
    findings.extend(check_files(recordings_dir, &recordings));
    let chain = audit::check(db.reader()).await?;
    findings.extend(chain.findings);
    Ok(Report { recordings: recordings.len(), audit_rows: chain.rows, audit_head: chain.head, findings })
}

/// Refuses a database whose pages or audit log are damaged, before anything is written to it. One that is not there
/// yet is fine.
///
/// # Errors
/// When it is damaged, in one line that says how and what to do.
pub async fn refuse_damage(config: &Config) -> anyhow::Result<()> {
    const ADVICE: &str = "the database is damaged and is not served; restore a backup with web-admin restore";
    let Some(db) = Database::open_if_there(&config.database_url).await.context(ADVICE)? else { return Ok(()) };
    let damage = damage(&db).await.context(ADVICE);
    db.close().await;
    match &damage?[..] {
        [] => Ok(()),
        [first, rest @ ..] => anyhow::bail!("{ADVICE}: {first} ({} more findings)", rest.len()),
    }
}

async fn damage(db: &Database) -> anyhow::Result<Vec<String>> {
    let mut findings = db.damaged_pages().await?;
    if findings.is_empty() && audit::is_kept(db.reader()).await? {
        findings.extend(audit::check(db.reader()).await?.findings);
    }
    Ok(findings)
}

fn check_files(folder: &Path, recordings: &[RecordingFile]) -> Vec<String> {
    let bar = indicatif::ProgressBar::new(recordings.len() as u64);
    let findings = recordings.iter().filter_map(|recording| {
        bar.inc(1);
        check_file(folder, recording)
    });
    let findings = findings.collect();
    bar.finish_and_clear();
    findings
}

/// What is wrong with a recording's file, if anything is.
fn check_file(folder: &Path, recording: &RecordingFile) -> Option<String> {
    let RecordingFile { id, recording_path, recording_sha256, recording_size } = recording;
    match hash_file(&folder.join(recording_path)) {
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
