//! Restoring a backup.

use std::path::{Path, PathBuf};

use super::{DATABASE, FORMAT, MANIFEST, Manifest, RECORDINGS, Refused, Scratch, archive};
use crate::config::Config;
use crate::recordings::hash_file;
use crate::storage::Database;
use crate::verification::{self, Report};

/// Restores a backup into an empty place: unpacked beside it, checked whole, and moved there last.
///
/// # Errors
/// When the file is no backup or a damaged one, or something is in the place already; nothing is changed then.
pub async fn restore(config: &Config, from: &Path) -> Result<Report, Refused> {
    let database = Database::file_of(&config.database_url)?;
    refuse_occupied(&database, &config.recordings_dir)?;
    // Beside the recordings, so that moving them there is a rename within one file system.
    let staging = Scratch(config.recordings_dir.with_extension("restoring"));
    if staging.0.exists() {
        let words = "is left from a restore that was stopped; remove it";
        return Err(Refused::Input(format!("{}: {words}", staging.0.display())));
    }
    std::fs::create_dir_all(staging.0.join(RECORDINGS))?;
    let refused = |error: anyhow::Error| Refused::Input(format!("{}: {error:#}", from.display()));
    archive::unpack(from, &staging.0).map_err(refused)?;
    check_manifest(&staging.0).map_err(refused)?;
    let report = verified(&staging.0).await?;
    if let Some(first) = report.findings.first() {
        let more = report.findings.len() - 1;
        return Err(Refused::Input(format!("{}: damaged: {first} ({more} more findings)", from.display())));
    }
    put(&staging.0, &database, &config.recordings_dir)?;
    Ok(report)
}

fn refuse_occupied(database: &Path, recordings: &Path) -> Result<(), Refused> {
    if database.exists() {
        let words = "exists; a backup is restored into an empty place, never over data";
        return Err(Refused::Input(format!("{}: {words}", database.display())));
    }
    let holds_something = std::fs::read_dir(recordings).is_ok_and(|mut entries| entries.next().is_some());
    if holds_something {
        return Err(Refused::Input(format!("{}: is not empty; restore into an empty folder", recordings.display())));
    }
    Ok(())
}

fn check_manifest(folder: &Path) -> anyhow::Result<()> {
    let text = std::fs::read(folder.join(MANIFEST)).map_err(|_| anyhow::anyhow!("no backup: {MANIFEST} is missing"))?;
    let manifest: Manifest = serde_json::from_slice(&text)?;
    anyhow::ensure!(manifest.format == FORMAT, "{MANIFEST}: format {}; allowed is {FORMAT}", manifest.format);
    let (sha256, _) = hash_file(&folder.join(DATABASE))?;
    anyhow::ensure!(sha256 == manifest.database_sha256, "{DATABASE}: its bytes are not those that were stored");
    Ok(())
}

async fn verified(folder: &Path) -> Result<Report, Refused> {
    let db = Database::open_existing(&format!("sqlite://{}", folder.join(DATABASE).display())).await?;
    let report = verification::everything(&db, &folder.join(RECORDINGS)).await;
    db.close().await;
    Ok(report?)
}

/// The database goes last: a restore that is stopped before leaves no service that could start.
fn put(staging: &Path, database: &Path, recordings: &Path) -> Result<(), Refused> {
    let parents = [database.parent(), recordings.parent()].into_iter().flatten();
    for folder in parents.filter(|folder| !folder.as_os_str().is_empty()) {
        std::fs::create_dir_all(folder)?;
    }
    if recordings.exists() {
        std::fs::remove_dir(recordings)?;
    }
    std::fs::rename(staging.join(RECORDINGS), recordings)?;
    let unpacked: PathBuf = staging.join(DATABASE);
    if std::fs::rename(&unpacked, database).is_err() {
        // Another file system: the copy is complete before it takes the name.
        let part = database.with_extension("part");
        std::fs::copy(&unpacked, &part)?;
        std::fs::File::open(&part)?.sync_all()?;
        std::fs::rename(&part, database)?;
    }
    for folder in [database.parent(), recordings.parent()].into_iter().flatten() {
        let folder = if folder.as_os_str().is_empty() { Path::new(".") } else { folder };
        std::fs::File::open(folder)?.sync_all()?;
    }
    Ok(())
}
