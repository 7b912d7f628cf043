//! Making a backup.

use std::collections::BTreeMap;
use std::fs::{File, OpenOptions};
use std::os::unix::fs::OpenOptionsExt;
use std::path::{Path, PathBuf};

use anyhow::{Context, ensure};
use data_encoding::HEXLOWER;
use model::{Moment, count_i64};
use platform::config::Config;
use platform::fail_points::FailPoint;
use platform::files::{hash_file, remove_if_there};
use platform::recording_store::RecordingStore;
use sha2::{Digest, Sha256};
use store::operations::backups;
use store::operations::backups::NotedBackup;
use store::recordings::sessions::RecordingFile;
use store::recordings::{parse_attempts, sessions, uploads};
use store::{Database, DatabaseAddress, audit};

use super::archive::{self, Sources};
use super::{FORMAT, Manifest, Scratch, passphrase};
use crate::operations::key_files::KEYS;
use crate::operations::verification::VerificationReport;
use crate::privacy::erasure_store::ErasureStore;
use crate::privacy::erasures::ERASURES_FILE;

/// Makes a backup, reads it back to check it, and only then renames it to its final name. The keys
/// are included only if there is a passphrase to seal them with.
///
/// # Errors
/// Fails if the database or a recording is damaged, or a file cannot be written. No file is left
/// under the final name then.
pub async fn make(
    config: &Config,
    to: &Path,
    passphrase: Option<&str>,
    now: Moment,
) -> anyhow::Result<VerificationReport> {
    let made = make_file(config, to, passphrase, now).await;
    let noted = NotedBackup {
        made_at: now,
        file_name: to.file_name().unwrap_or_default().to_string_lossy().into_owned(),
        bytes: made
            .as_ref()
            .ok()
            .and_then(|_| std::fs::metadata(to).ok())
            .and_then(|file| i64::try_from(file.len()).ok()),
        recordings: made.as_ref().ok().map(|report| count_i64(report.recordings)),
        keys_sealed: passphrase.is_some(),
        error: made.as_ref().err().map(|error| format!("{error:#}")),
    };
    // The backup is valid even if it cannot be recorded.
    if let Err(error) = note(config, &noted).await {
        tracing::warn!("backup not recorded in the database, so its page does not show it: {error:#}");
    }
    made
}

/// Records the result of the backup in the database. A database with pending migrations is skipped:
/// its table may not exist yet.
async fn note(config: &Config, noted: &NotedBackup) -> anyhow::Result<()> {
    let db = Database::open_existing(&config.database).await?;
    if db.count_missing_migrations().await? == 0 {
        let mut tx = db.write().await?;
        backups::note_backup(&mut tx, noted).await?;
        tx.commit().await?;
    }
    db.close().await;
    Ok(())
}

async fn make_file(
    config: &Config,
    to: &Path,
    passphrase: Option<&str>,
    now: Moment,
) -> anyhow::Result<VerificationReport> {
    config.database.file()?;
    let (copy, part) = (Scratch(beside(to, "database")), Scratch(beside(to, "part")));
    // A backup contains every password hash, so only its owner may ever read it.
    let file = OpenOptions::new().write(true).create(true).truncate(false).mode(0o600).open(&part.0);
    let file = file.with_context(|| part.0.display().to_string())?;
    if file.try_lock().is_err() {
        // Both files belong to the other backup: do not delete them on drop.
        std::mem::forget((copy, part));
        anyhow::bail!("{}: another backup is being written there", to.display());
    }
    // Discard the content left by an interrupted backup.
    file.set_len(0)?;
    remove_if_there(&copy.0)?;
    let source = Database::open_existing(&config.database).await.context("cannot open the database")?;
    source.copy_to(&copy.0).await.context("cannot copy the database")?;
    source.close().await;
    FailPoint::BackupCopied.hit();
    let (recordings, report) = settle(&copy.0).await?;
    let (database_sha256, _) = hash_file(&copy.0)?;
    let program_version = env!("CARGO_PKG_VERSION").to_owned();
    // Read the erasure list after copying the database, so that it covers every erasure in the
    // copy.
    let store = RecordingStore::open(config)?;
    let small = small_files(config, &store, passphrase).await?;
    let files = small.iter().map(|(name, bytes)| (name.clone(), HEXLOWER.encode(&Sha256::digest(bytes)))).collect();
    let manifest = Manifest { format: FORMAT, made_at: now.to_string(), program_version, database_sha256, files };
    make_passing_folder(config)?;
    let sources = Sources { database: &copy.0, small: &small, store: &store };
    archive::write(file, &manifest, &sources, &recordings).await?;
    archive::check(&part.0, &manifest, &recordings).context("verification of the backup failed")?;
    // Remove the temporary copy before the archive gets its final name.
    drop(copy);
    FailPoint::BackupWritten.hit();
    std::fs::rename(&part.0, to)?;
    FailPoint::BackupNamed.hit();
    File::open(to.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new(".")))?.sync_all()?;
    Ok(report)
}

/// Creates the folder through which recordings are fetched from a bucket. Each is deleted once it
/// is in the archive.
fn make_passing_folder(config: &Config) -> std::io::Result<()> {
    match config.bucket {
        Some(_) => std::fs::create_dir_all(config.uploads_dir()),
        None => Ok(()),
    }
}

/// Collects the small files of a service that exist.
async fn small_files(
    config: &Config,
    store: &RecordingStore,
    passphrase: Option<&str>,
) -> anyhow::Result<BTreeMap<String, Vec<u8>>> {
    let erasures = ErasureStore::of(config, store).copy().await?;
    let mut small = BTreeMap::from([(ERASURES_FILE.to_owned(), erasures)]);
    for key in KEYS {
        let path = config.keys_dir.join(key.name);
        if let Some(passphrase) = passphrase.filter(|_| path.exists()) {
            let plain = std::fs::read(&path).context(key.name)?;
            small.insert(key.sealed.to_owned(), passphrase::seal(&plain, passphrase)?);
        }
    }
    small.retain(|_, bytes| !bytes.is_empty());
    Ok(small)
}

fn beside(to: &Path, suffix: &str) -> PathBuf {
    let mut name = to.as_os_str().to_owned();
    name.push(".");
    name.push(suffix);
    PathBuf::from(name)
}

/// Migrates the copy if an earlier version has written it, drops unfinished uploads, checks its
/// integrity and lists its recordings.
async fn settle(copy: &Path) -> anyhow::Result<(Vec<RecordingFile>, VerificationReport)> {
    let db = Database::open_existing(&DatabaseAddress::of_file(copy)).await?;
    db.migrate().await?;
    let mut tx = db.write().await?;
    uploads::forget_unfinished(&mut tx).await?;
    parse_attempts::release_all(&mut tx).await?;
    tx.commit().await?;
    let recordings = sessions::list_recordings(db.reader()).await?;
    let chain = audit::check_audit_chain(db.reader()).await?;
    let findings = [db.integrity().await?, chain.findings].concat();
    db.close().await;
    ensure!(findings.is_empty(), "the database is damaged, and nothing was backed up: {}", findings.join("; "));
    let report = VerificationReport {
        recordings: recordings.len(),
        audit_rows: chain.rows,
        audit_head: chain.head,
        findings: Vec::new(),
    };
    Ok((recordings, report))
}
