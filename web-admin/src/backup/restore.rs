//! Restoring a backup.

use std::path::{Path, PathBuf};

use super::{DATABASE, FORMAT, MANIFEST, Manifest, RECORDINGS, Refused, Scratch, archive};
use crate::config::Config;
use crate::killpoints::KillPoint;
use crate::recordings::hash_file;
use crate::storage::Database;
use crate::verification::{self, Report};

/// Written into the unpacked backup when it was found whole: from then on only its parts are to be moved.
const WHOLE: &str = "whole.json";

/// Restores a backup into an empty place: unpacked beside it, checked whole, and moved there last. What a restore that was
/// stopped has left is gone on with, or done over. Whoever calls holds the place's lock.
///
/// # Errors
/// When the file is no backup or a damaged one, or something is in the place already; nothing is changed then.
pub async fn restore(config: &Config, from: &Path) -> Result<Report, Refused> {
    let database = Database::file_of(&config.database_url)?;
    let staging = staging(config);
    let refused = |error: anyhow::Error| Refused::Input(format!("{}: {error:#}", from.display()));
    let manifest = archive::manifest(from).map_err(refused)?;
    let is_unpacked = unpacked(&staging).as_ref() == Some(&manifest);
    // The database moves last: one that was killed after that has only to tidy up.
    if !is_unpacked || staging.join(DATABASE).exists() {
        refuse_database(&database)?;
    }
    let mut report = None;
    if !is_unpacked {
        refuse_recordings(&config.recordings_dir)?;
        let scratch = Scratch(staging.clone());
        report = Some(unpack(from, &scratch.0, &manifest).await?);
        // From here on it is gone on with, also by another process.
        std::mem::forget(scratch);
    }
    KillPoint::RestoreUnpacked.pass();
    put(&staging, &database, &config.recordings_dir)?;
    drop(Scratch(staging));
    match report {
        Some(report) => Ok(report),
        // What another process has unpacked was checked by it, and is read once more.
        None => verified(&database, &config.recordings_dir).await,
    }
}

/// Where a backup is unpacked before its parts are moved to their places: beside the recordings, so that moving them is a
/// rename within one file system.
pub fn staging(config: &Config) -> PathBuf {
    config.recordings_dir.with_extension("restoring")
}

/// Of which backup everything has been unpacked and checked, if so.
fn unpacked(staging: &Path) -> Option<Manifest> {
    serde_json::from_slice(&std::fs::read(staging.join(WHOLE)).ok()?).ok()
}

/// Unpacks a backup into a folder of its own, checks it whole, and says so there.
async fn unpack(from: &Path, staging: &Path, manifest: &Manifest) -> Result<Report, Refused> {
    if staging.exists() {
        std::fs::remove_dir_all(staging)?;
    }
    std::fs::create_dir_all(staging.join(RECORDINGS))?;
    let refused = |error: anyhow::Error| Refused::Input(format!("{}: {error:#}", from.display()));
    archive::unpack(from, staging).map_err(refused)?;
    check_manifest(staging, manifest).map_err(refused)?;
    let report = verified(&staging.join(DATABASE), &staging.join(RECORDINGS)).await?;
    if let Some(first) = report.findings.first() {
        let more = report.findings.len() - 1;
        return Err(Refused::Input(format!("{}: damaged: {first} ({more} more findings)", from.display())));
    }
    let whole = staging.join(WHOLE);
    std::fs::write(&whole, serde_json::to_vec(manifest)?)?;
    std::fs::File::open(&whole)?.sync_all()?;
    std::fs::File::open(staging)?.sync_all()?;
    Ok(report)
}

fn refuse_database(database: &Path) -> Result<(), Refused> {
    // A log without its database belongs to another one, and would be read into this.
    for suffix in ["", "-wal", "-shm", "-journal"] {
        let mut file = database.as_os_str().to_owned();
        file.push(suffix);
        let file = PathBuf::from(file);
        if file.exists() {
            let words = "exists; a backup is restored into an empty place, never over data";
            return Err(Refused::Input(format!("{}: {words}", file.display())));
        }
    }
    Ok(())
}

fn refuse_recordings(recordings: &Path) -> Result<(), Refused> {
    let holds_something = std::fs::read_dir(recordings).is_ok_and(|mut entries| entries.next().is_some());
    if holds_something {
        return Err(Refused::Input(format!("{}: is not empty; restore into an empty folder", recordings.display())));
    }
    Ok(())
}

fn check_manifest(folder: &Path, manifest: &Manifest) -> anyhow::Result<()> {
    anyhow::ensure!(manifest.format == FORMAT, "{MANIFEST}: format {}; allowed is {FORMAT}", manifest.format);
    let (sha256, _) = hash_file(&folder.join(DATABASE))?;
    anyhow::ensure!(sha256 == manifest.database_sha256, "{DATABASE}: its bytes are not those that were stored");
    Ok(())
}

async fn verified(database: &Path, recordings: &Path) -> Result<Report, Refused> {
    let db = Database::open_existing(&format!("sqlite://{}", database.display())).await?;
    let report = verification::everything(&db, recordings).await;
    db.close().await;
    Ok(report?)
}

/// The database goes last: a restore that is stopped before leaves no service that could start, and is gone on with.
fn put(staging: &Path, database: &Path, recordings: &Path) -> Result<(), Refused> {
    let parents = [database.parent(), recordings.parent()].into_iter().flatten();
    for folder in parents.filter(|folder| !folder.as_os_str().is_empty()) {
        std::fs::create_dir_all(folder)?;
    }
    if staging.join(RECORDINGS).exists() {
        if recordings.exists() {
            std::fs::remove_dir(recordings)?;
        }
        std::fs::rename(staging.join(RECORDINGS), recordings)?;
    }
    KillPoint::RestoreMoving.pass();
    let unpacked: PathBuf = staging.join(DATABASE);
    if unpacked.exists() && std::fs::rename(&unpacked, database).is_err() {
        // Another file system: the copy is complete before it takes the name.
        let part = database.with_extension("part");
        std::fs::copy(&unpacked, &part)?;
        std::fs::File::open(&part)?.sync_all()?;
        std::fs::rename(&part, database)?;
    }
    KillPoint::RestoreMoved.pass();
    for folder in [database.parent(), recordings.parent()].into_iter().flatten() {
        let folder = if folder.as_os_str().is_empty() { Path::new(".") } else { folder };
        std::fs::File::open(folder)?.sync_all()?;
    }
    Ok(())
}
