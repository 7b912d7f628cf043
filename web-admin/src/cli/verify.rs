//! `web-admin verify`: is everything still what was written?

use std::path::Path;

use anyhow::Context;

use super::{Failure, Storage, say};
use crate::recordings::hash_file;
use crate::storage::Database;
use crate::storage::audit;
use crate::storage::sessions::{self, RecordingFile};

pub(super) async fn run(storage: &Storage) -> Result<(), Failure> {
    let config = storage.config()?;
    let db = Database::open_existing(&config.database_url).await.context("cannot open the database")?;
    let mut findings = db.integrity().await?;
    let recordings = sessions::recordings(db.reader()).await?;
    findings.extend(check_files(&config.recordings_dir, &recordings));
    let chain = audit::check(db.reader()).await?;
    findings.extend(chain.findings);
    db.close().await;
    findings.iter().for_each(say);
    let counts = format!("{} recordings and {} audit rows checked", recordings.len(), chain.rows);
    say(format_args!("{counts}, {} findings; the audit log ends in {}", findings.len(), chain.head));
    if findings.is_empty() { Ok(()) } else { Err(Failure::Found) }
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
