//! Restoring a backup.

use std::path::{Path, PathBuf};

use anyhow::Context;
use platform::clock::Clock;
use platform::config::Config;
use platform::fail_points::FailPoint;
use platform::files::hash_file;
use platform::recording_store::{Bucket, RecordingStore};
use platform::sealing;
use store::{Database, DatabaseAddress};

use super::{DATABASE, FORMAT, KNOWN, MANIFEST, Manifest, RECORDINGS, RestoreRefused, Scratch, archive, passphrase};
use crate::operations::key_files::KEYS;
use crate::operations::verification;
use crate::operations::verification::VerificationReport;
use crate::privacy::erasing;
use crate::privacy::erasure_store::ErasureStore;
use crate::privacy::erasures::{ERASURES_FILE, Erasure, ErasureList};
use crate::service::Service;

/// Marker written into the unpacked backup once it has been verified: from then on the restore can
/// be resumed.
const WHOLE: &str = "whole.json";

/// Result of a restore.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct RestoreSummary {
    /// Report of the verification.
    pub report: VerificationReport,
    /// Number of people erased again, because they had been erased after the backup was made.
    pub erased_again: usize,
    /// Outcome for the keys.
    pub keys: KeysRestored,
}

/// Outcome of a restore for the keys ([`KEYS`]).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum KeysRestored {
    /// The backup contains no key.
    NotInIt,
    /// No passphrase was given, so the keys stay sealed in the archive.
    StaySealed,
    /// The keys are in place.
    Restored,
}

/// Options of a restore.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct RestoreRequest {
    /// Additional erasures, recorded outside the backup.
    pub erasures: Vec<Erasure>,
    /// Passphrase with which the keys are sealed.
    pub passphrase: Option<String>,
}

/// Restores a backup into an empty place: unpacks it next to the target, verifies it, and moves it
/// there last. An interrupted restore is resumed if it had been verified, and started over
/// otherwise. The caller holds the data folder's lock.
///
/// At the end, the erasures from the backup's own list, from the request and from a list that
/// already exists at the target are carried out. If the restore is interrupted before that, `serve`
/// carries them out before it accepts requests.
///
///
/// # Errors
/// Fails if the file is not a backup or is damaged, or if the target is not empty; nothing is
/// changed then.
pub async fn restore(config: &Config, from: &Path, wanted: &RestoreRequest) -> Result<RestoreSummary, RestoreRefused> {
    let database = config.database.file()?;
    let staging = config.restoring_dir();
    let refused = |error: anyhow::Error| RestoreRefused::Input(format!("{}: {error:#}", from.display()));
    let manifest = archive::manifest(from).map_err(refused)?;
    let is_unpacked = unpacked(&staging).as_ref() == Some(&manifest);
    // The database moves last: a restore killed after that only has to clean up.
    if !is_unpacked || staging.join(DATABASE).exists() {
        refuse_database(&database)?;
    }
    let (mut report, mut scratch) = (None, None);
    if !is_unpacked {
        refuse_recordings(config).await?;
        scratch = Some(Scratch(staging.clone()));
        report = Some(unpack(from, &staging, &manifest).await?);
    }
    FailPoint::RestoreUnpacked.hit();
    let own = ErasureList::at(&staging.join(ERASURES_FILE)).read().map_err(|error| refused(error.into()))?;
    let keys = restore_keys(config, &staging, wanted.passphrase.as_deref()).map_err(refused)?;
    // From here on an interrupted restore is resumed, even by another process.
    std::mem::forget(scratch);
    // The list must be in place before the database, so that no service starts without it.
    let list = ErasureStore::of(config, &RecordingStore::open(config)?);
    list.merge(&[own, wanted.erasures.clone()].concat()).await?;
    put(&staging, &database, config).await?;
    drop(Scratch(staging));
    let erased_again = catch_up(config).await?;
    let report = match report {
        Some(report) if erased_again == 0 => report,
        // A previous process had verified this backup; the report needs the numbers again.
        _ => verified(&database, &RecordingStore::open(config)?).await?,
    };
    Ok(RestoreSummary { report, erased_again, keys })
}

/// Opens the keys and puts them in place, unless other keys are there.
fn restore_keys(config: &Config, staging: &Path, passphrase: Option<&str>) -> anyhow::Result<KeysRestored> {
    let sealed: Vec<_> = KEYS.into_iter().filter(|key| staging.join(key.sealed).exists()).collect();
    let Some(passphrase) = passphrase else {
        return Ok(if sealed.is_empty() { KeysRestored::NotInIt } else { KeysRestored::StaySealed });
    };
    anyhow::ensure!(!sealed.is_empty(), "the backup contains no key; restore without --passphrase-file");
    for key in sealed {
        let plain = passphrase::open(&std::fs::read(staging.join(key.sealed))?, passphrase).context(key.sealed)?;
        sealing::restore_file_key(&config.keys_dir.join(key.name), std::str::from_utf8(&plain)?)?;
    }
    Ok(KeysRestored::Restored)
}

/// Erases everyone who was erased after the backup was made.
async fn catch_up(config: &Config) -> Result<usize, RestoreRefused> {
    if ErasureStore::of(config, &RecordingStore::open(config)?).read().await?.is_empty() {
        return Ok(0);
    }
    let state = Service::open(config.clone(), Clock::system()).await?;
    let again = erasing::catch_up(&state).await;
    state.db.close().await;
    Ok(again?)
}

/// Returns the manifest of the backup that has been completely unpacked and verified, if any.
fn unpacked(staging: &Path) -> Option<Manifest> {
    serde_json::from_slice(&std::fs::read(staging.join(WHOLE)).ok()?).ok()
}

/// Unpacks a backup into its own folder, verifies it, and writes the marker file.
async fn unpack(from: &Path, staging: &Path, manifest: &Manifest) -> Result<VerificationReport, RestoreRefused> {
    if staging.exists() {
        std::fs::remove_dir_all(staging)?;
    }
    std::fs::create_dir_all(staging.join(RECORDINGS))?;
    let refused = |error: anyhow::Error| RestoreRefused::Input(format!("{}: {error:#}", from.display()));
    archive::unpack(from, staging).map_err(refused)?;
    check_manifest(staging, manifest).map_err(refused)?;
    let report = verified(&staging.join(DATABASE), &RecordingStore::Folder(staging.join(RECORDINGS))).await?;
    if let Some(first) = report.findings.first() {
        let more = report.findings.len() - 1;
        return Err(RestoreRefused::Input(format!("{}: damaged: {first} ({more} more findings)", from.display())));
    }
    let whole = staging.join(WHOLE);
    std::fs::write(&whole, serde_json::to_vec(manifest)?)?;
    std::fs::File::open(&whole)?.sync_all()?;
    std::fs::File::open(staging)?.sync_all()?;
    Ok(report)
}

fn refuse_database(database: &Path) -> Result<(), RestoreRefused> {
    // SQLite would replay a leftover log or journal of another database into this one.
    for suffix in ["", "-wal", "-shm", "-journal"] {
        let mut file = database.as_os_str().to_owned();
        file.push(suffix);
        let file = PathBuf::from(file);
        if file.exists() {
            let words = "already exists; restore a backup only into an empty place, never over data";
            return Err(RestoreRefused::Input(format!("{}: {words}", file.display())));
        }
    }
    Ok(())
}

async fn refuse_recordings(config: &Config) -> Result<(), RestoreRefused> {
    let store = RecordingStore::open(config)?;
    let (holds_something, what) = match &store {
        RecordingStore::Folder(folder) => {
            (std::fs::read_dir(folder).is_ok_and(|mut entries| entries.next().is_some()), "an empty folder")
        }
        RecordingStore::Bucket(_) => {
            (!store.list().await.with_context(|| store.place())?.is_empty(), "an empty part of a bucket")
        }
    };
    if holds_something {
        return Err(RestoreRefused::Input(format!("{}: not empty; restore into {what}", store.place())));
    }
    Ok(())
}

fn check_manifest(folder: &Path, manifest: &Manifest) -> anyhow::Result<()> {
    anyhow::ensure!(KNOWN.contains(&manifest.format), "{MANIFEST}: format {}; allowed: 1 to {FORMAT}", manifest.format);
    let (sha256, _) = hash_file(&folder.join(DATABASE))?;
    anyhow::ensure!(sha256 == manifest.database_sha256, "{DATABASE}: the bytes do not match the stored hash");
    for (name, expected) in &manifest.files {
        let (sha256, _) = hash_file(&folder.join(name)).with_context(|| name.clone())?;
        anyhow::ensure!(sha256 == *expected, "{name}: the bytes do not match the stored hash");
    }
    Ok(())
}

/// Migrates a database that an earlier version may have written, and verifies it.
async fn verified(database: &Path, recordings: &RecordingStore) -> Result<VerificationReport, RestoreRefused> {
    let db = Database::open_existing(&DatabaseAddress::of_file(database)).await?;
    db.migrate().await.map_err(anyhow::Error::from)?;
    let report = verification::everything(&db, recordings).await;
    db.close().await;
    Ok(report?)
}

/// Uploads the recordings of a backup to a bucket and verifies each there. Safe to repeat.
async fn send_recordings(bucket: &Bucket, unpacked: &Path) -> Result<(), RestoreRefused> {
    let staged = RecordingStore::Folder(unpacked.to_owned());
    let recordings = staged.list().await?;
    let bar = indicatif::ProgressBar::new(recordings.len() as u64);
    for recording in recordings {
        let (sha256, _) = staged.hash(&recording).await?;
        bucket.keep_recording(&unpacked.join(&recording), &recording, &sha256).await?;
        bar.inc(1);
    }
    bar.finish_and_clear();
    std::fs::remove_dir_all(unpacked)?;
    Ok(())
}

/// Moves the unpacked backup to its place, the database last: without it no service can start, and
/// an interrupted restore can be resumed.
async fn put(staging: &Path, database: &Path, config: &Config) -> Result<(), RestoreRefused> {
    let recordings = &config.recordings_dir;
    let parents = [database.parent(), recordings.parent()].into_iter().flatten();
    for folder in parents.filter(|folder| !folder.as_os_str().is_empty()) {
        std::fs::create_dir_all(folder)?;
    }
    let unpacked = staging.join(RECORDINGS);
    match RecordingStore::open(config)? {
        _ if !unpacked.exists() => {}
        RecordingStore::Bucket(bucket) => send_recordings(&bucket, &unpacked).await?,
        RecordingStore::Folder(folder) => {
            if folder.exists() {
                std::fs::remove_dir(&folder)?;
            }
            std::fs::rename(&unpacked, folder)?;
        }
    }
    FailPoint::RestoreMoving.hit();
    let unpacked: PathBuf = staging.join(DATABASE);
    if unpacked.exists() && std::fs::rename(&unpacked, database).is_err() {
        // Another file system: copy the file completely before renaming it.
        let part = database.with_extension("part");
        std::fs::copy(&unpacked, &part)?;
        std::fs::File::open(&part)?.sync_all()?;
        std::fs::rename(&part, database)?;
    }
    FailPoint::RestoreMoved.hit();
    for folder in [database.parent(), recordings.parent()].into_iter().flatten() {
        let folder = if folder.as_os_str().is_empty() { Path::new(".") } else { folder };
        std::fs::File::open(folder)?.sync_all()?;
    }
    Ok(())
}
