//! Storage of audit checkpoints (statements): a folder in the data folder or, if recordings are
//! stored in a bucket, objects there, shared by all replicas on the same database.

use std::fs::{DirBuilder, File, OpenOptions};
use std::io::{ErrorKind, Write};
use std::os::unix::fs::{DirBuilderExt, OpenOptionsExt};
use std::path::{Path, PathBuf};

use anyhow::Context;
use platform::config::Config;
use platform::recording_store::{Bucket, RecordingStore};

/// Name of the folder, in the data folder and in a bucket.
pub(crate) const STATEMENTS: &str = "statements";

/// Storage of audit checkpoints.
#[derive(Clone, Debug)]
pub enum StatementStore {
    /// In a folder.
    Folder(PathBuf),
    /// In a bucket.
    Bucket(Bucket),
}

impl StatementStore {
    /// Returns the storage of a service.
    #[must_use]
    pub fn of(config: &Config, recordings: &RecordingStore) -> Self {
        match recordings {
            RecordingStore::Folder(_) => Self::Folder(config.data_dir.join(STATEMENTS)),
            RecordingStore::Bucket(bucket) => Self::Bucket(bucket.clone()),
        }
    }

    /// Returns the location of a file, for messages.
    #[must_use]
    pub fn place(&self, name: &str) -> String {
        match self {
            Self::Folder(folder) => folder.join(name).display().to_string(),
            Self::Bucket(bucket) => format!("{}/{STATEMENTS}/{name}", bucket.address()),
        }
    }

    /// Reads a file; returns `None` if it does not exist.
    ///
    /// # Errors
    /// Fails if the disk fails, or the bucket does not respond.
    pub async fn read(&self, name: &str) -> anyhow::Result<Option<Vec<u8>>> {
        match self {
            Self::Folder(folder) => match tokio::fs::read(folder.join(name)).await {
                Err(error) if error.kind() == ErrorKind::NotFound => Ok(None),
                read => Ok(Some(read.with_context(|| self.place(name))?)),
            },
            Self::Bucket(bucket) => Ok(bucket.read_whole(&format!("{STATEMENTS}/{name}")).await?),
        }
    }

    /// Writes a file atomically.
    ///
    /// # Errors
    /// Fails if the disk fails, or the bucket does not respond.
    pub async fn keep(&self, name: &str, bytes: Vec<u8>) -> anyhow::Result<()> {
        match self {
            Self::Folder(folder) => {
                let (folder, file) = (folder.clone(), folder.join(name));
                let kept = tokio::task::spawn_blocking(move || keep_file(&folder, &file, &bytes)).await?;
                kept.with_context(|| self.place(name))
            }
            Self::Bucket(bucket) => Ok(bucket.put(&format!("{STATEMENTS}/{name}"), bytes).await?),
        }
    }

    /// Copies the files in the data folder, written before a bucket was used, to the bucket. The
    /// files are kept.
    ///
    /// # Errors
    /// Fails if a file cannot be read, or the bucket does not respond.
    pub async fn carry_over(&self, config: &Config) -> anyhow::Result<()> {
        let Self::Bucket(bucket) = self else { return Ok(()) };
        let folder = config.data_dir.join(STATEMENTS);
        let Ok(entries) = std::fs::read_dir(&folder) else { return Ok(()) };
        let known = bucket.list(STATEMENTS).await?;
        for entry in entries {
            let name = entry?.file_name().to_string_lossy().into_owned();
            if !name.ends_with(PART) && !known.contains(&name) {
                self.keep(&name, tokio::fs::read(folder.join(&name)).await?).await?;
            }
        }
        Ok(())
    }
}

/// Suffix of incomplete files.
const PART: &str = ".part";

fn keep_file(folder: &Path, file: &Path, bytes: &[u8]) -> anyhow::Result<()> {
    DirBuilder::new().recursive(true).mode(0o700).create(folder)?;
    let part = PathBuf::from(format!("{}{PART}", file.display()));
    let mut written = OpenOptions::new().write(true).create(true).truncate(true).mode(0o600).open(&part)?;
    written.write_all(bytes)?;
    written.sync_all()?;
    std::fs::rename(&part, file)?;
    Ok(File::open(folder)?.sync_all()?)
}
