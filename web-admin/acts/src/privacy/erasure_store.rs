//! Storage of the erasure list: a file in the data folder or, if recordings are stored in a bucket,
//! objects there, shared by all replicas on the same database. In a bucket each erasure is an
//! object that holds its line of the file, so that concurrent additions do not conflict. Taking an
//! erasure back deletes its object.

use std::path::Path;

use anyhow::ensure;
use futures::{StreamExt, TryStreamExt};
use platform::config::Config;
use platform::recording_store::{Bucket, RecordingStore, StoreError};

use crate::privacy::erasures::{Erasure, ErasureList, lines_of, read_lines};

/// Prefix of the erasures in a bucket.
const ERASURES: &str = "erasures";
/// Number of objects fetched concurrently.
const AT_ONCE: usize = 16;

/// Storage of the erasure list.
#[derive(Clone, Debug)]
pub enum ErasureStore {
    /// In a file.
    File(ErasureList),
    /// In a bucket.
    Bucket(Bucket),
}

impl ErasureStore {
    /// Returns the erasure list of a service.
    #[must_use]
    pub fn of(config: &Config, recordings: &RecordingStore) -> Self {
        match recordings {
            RecordingStore::Folder(_) => Self::File(ErasureList::of(config)),
            RecordingStore::Bucket(bucket) => Self::Bucket(bucket.clone()),
        }
    }

    /// Checks that the bucket responds; does nothing for a file.
    ///
    /// # Errors
    /// Fails if it does not respond.
    pub async fn check(&self) -> Result<(), StoreError> {
        match self {
            Self::File(_) => Ok(()),
            Self::Bucket(bucket) => bucket.check().await,
        }
    }

    /// Returns the erasures that were not taken back, in the order in which they were added.
    ///
    /// # Errors
    /// Fails if a file or an object has an unknown format or cannot be read.
    pub async fn read(&self) -> anyhow::Result<Vec<Erasure>> {
        match self {
            Self::File(list) => Ok(off_the_runtime(list, |list| Ok(list.read())).await??),
            Self::Bucket(bucket) => read_objects(bucket).await,
        }
    }

    /// Returns the list in the file format, for a backup. Fails for an unreadable list, which would
    /// make the backup useless.
    ///
    /// # Errors
    /// As [`ErasureStore::read`].
    pub async fn copy(&self) -> anyhow::Result<Vec<u8>> {
        let erasures = self.read().await?;
        match self {
            Self::File(list) => Ok(list.bytes()?),
            Self::Bucket(_) => Ok(lines_of(&erasures)?.into_bytes()),
        }
    }

    /// Adds an erasure durably: when this returns, it survives a power cut or, in a bucket, the
    /// loss of this machine.
    ///
    /// # Errors
    /// Fails if the disk or the bucket fails. The erasure may have been added nevertheless.
    pub async fn add(&self, erasure: &Erasure) -> Result<(), StoreError> {
        match self {
            Self::File(list) => {
                let erasure = erasure.clone();
                off_the_runtime(list, move |list| list.add(&erasure)).await
            }
            Self::Bucket(bucket) => {
                bucket.put(&name_erasure(erasure), lines_of(std::slice::from_ref(erasure))?.into_bytes()).await
            }
        }
    }

    /// Takes an erasure back that was not carried out.
    ///
    /// # Errors
    /// Fails if the disk or the bucket fails.
    pub async fn take_back(&self, erasure: &Erasure) -> Result<(), StoreError> {
        match self {
            Self::File(list) => {
                let erasure = erasure.clone();
                off_the_runtime(list, move |list| list.take_back(&erasure)).await
            }
            Self::Bucket(bucket) => bucket.remove(vec![name_erasure(erasure)]).await,
        }
    }

    /// Adds the erasures of another list that are not in this one.
    ///
    /// # Errors
    /// As [`ErasureStore::read`] and [`ErasureStore::add`].
    pub async fn merge(&self, others: &[Erasure]) -> anyhow::Result<()> {
        let mut known = if others.is_empty() { Vec::new() } else { self.read().await? };
        for erasure in others {
            if !known.contains(erasure) {
                self.add(erasure).await?;
                known.push(erasure.clone());
            }
        }
        Ok(())
    }

    /// Copies the erasures from the data folder's file, written before a bucket was used, to the
    /// bucket. The file is kept.
    ///
    /// # Errors
    /// Fails if the file cannot be read, or as [`ErasureStore::merge`].
    pub async fn carry_over(&self, config: &Config) -> anyhow::Result<()> {
        match self {
            Self::File(_) => Ok(()),
            Self::Bucket(_) => self.merge(&ErasureList::of(config).read()?).await,
        }
    }
}

/// Runs file operations on the blocking thread pool.
async fn off_the_runtime<T: Send + 'static>(
    list: &ErasureList,
    work: impl FnOnce(ErasureList) -> std::io::Result<T> + Send + 'static,
) -> Result<T, StoreError> {
    let list = list.clone();
    Ok(tokio::task::spawn_blocking(move || work(list)).await.map_err(std::io::Error::other)??)
}

/// Returns the object name of an erasure; names sort by time.
fn name_erasure(erasure: &Erasure) -> String {
    format!("{ERASURES}/{:020}-{}.json", erasure.at.micros(), erasure.person_id)
}

async fn read_objects(bucket: &Bucket) -> anyhow::Result<Vec<Erasure>> {
    let mut names = bucket.list(ERASURES).await?;
    names.sort();
    let read = futures::stream::iter(names).map(|name| async move {
        let place = format!("{ERASURES}/{name}");
        // An object that has disappeared was taken back in the meantime.
        let Some(bytes) = bucket.read_whole(&place).await? else { return anyhow::Ok(Vec::new()) };
        let place = format!("{}/{place}", bucket.address());
        let erasures = read_lines(Path::new(&place), bytes)?;
        ensure!(erasures.len() == 1, "{place}: not an erasure written by web-admin");
        Ok(erasures)
    });
    Ok(read.buffered(AT_ONCE).try_collect::<Vec<_>>().await?.into_iter().flatten().collect())
}
