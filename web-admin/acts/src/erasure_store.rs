//! Where the list of erasures is kept: in a file of the data folder, or where recordings lie in a bucket beside them, for every service on
//! the same database. There an erasure is an object of its own, which holds the line that a file would have: nobody who adds one touches
//! another. One that is taken back is removed.

use std::path::Path;

use anyhow::ensure;
use futures::{StreamExt, TryStreamExt};

use crate::config::Config;
use crate::erasures::{Erasure, ErasureList, lines_of, read_lines};
use crate::recording_store::{Bucket, RecordingStore, StoreError};

/// Folder of the erasures in a bucket.
const ERASURES: &str = "erasures";
/// Objects that are asked for at once.
const AT_ONCE: usize = 16;

/// Where the list of erasures is kept.
#[derive(Clone, Debug)]
pub enum ErasureStore {
    /// In a file.
    File(ErasureList),
    /// In a bucket.
    Bucket(Bucket),
}

impl ErasureStore {
    /// That of a service.
    #[must_use]
    pub fn of(config: &Config, recordings: &RecordingStore) -> Self {
        match recordings {
            RecordingStore::Folder(_) => Self::File(ErasureList::of(config)),
            RecordingStore::Bucket(bucket) => Self::Bucket(bucket.clone()),
        }
    }

    /// Whether a bucket answers; a file is not asked.
    ///
    /// # Errors
    /// When it does not.
    pub async fn check(&self) -> Result<(), StoreError> {
        match self {
            Self::File(_) => Ok(()),
            Self::Bucket(bucket) => bucket.check().await,
        }
    }

    /// The erasures that were not taken back, in the order in which they were added.
    ///
    /// # Errors
    /// When a file or an object is none of ours, or they cannot be read.
    pub async fn read(&self) -> anyhow::Result<Vec<Erasure>> {
        match self {
            Self::File(list) => Ok(off_the_runtime(list, |list| Ok(list.read())).await??),
            Self::Bucket(bucket) => read_objects(bucket).await,
        }
    }

    /// The list as a file holds it, for a backup. One that cannot be read would be of no use there.
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

    /// Adds an erasure, which outlives this machine's power or the machine itself when this returns.
    ///
    /// # Errors
    /// When the disk refuses or the bucket does not answer. It may have been added all the same.
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

    /// Notes that an erasure did not come about.
    ///
    /// # Errors
    /// When the disk refuses or the bucket does not answer.
    pub async fn take_back(&self, erasure: &Erasure) -> Result<(), StoreError> {
        match self {
            Self::File(list) => {
                let erasure = erasure.clone();
                off_the_runtime(list, move |list| list.take_back(&erasure)).await
            }
            Self::Bucket(bucket) => bucket.remove(vec![name_erasure(erasure)]).await,
        }
    }

    /// Adds those of another list that are not in this one.
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

    /// Has a bucket hold what the data folder's file still has of the time before it. The file stays.
    ///
    /// # Errors
    /// When the file cannot be read, or as [`ErasureStore::merge`].
    pub async fn carry_over(&self, config: &Config) -> anyhow::Result<()> {
        match self {
            Self::File(_) => Ok(()),
            Self::Bucket(_) => self.merge(&ErasureList::of(config).read()?).await,
        }
    }
}

/// Works on a file where blocking is allowed.
async fn off_the_runtime<T: Send + 'static>(
    list: &ErasureList,
    work: impl FnOnce(ErasureList) -> std::io::Result<T> + Send + 'static,
) -> Result<T, StoreError> {
    let list = list.clone();
    Ok(tokio::task::spawn_blocking(move || work(list)).await.map_err(std::io::Error::other)??)
}

/// Names sort by time.
fn name_erasure(erasure: &Erasure) -> String {
    format!("{ERASURES}/{:020}-{}.json", erasure.at.micros(), erasure.person_id)
}

async fn read_objects(bucket: &Bucket) -> anyhow::Result<Vec<Erasure>> {
    let mut names = bucket.list(ERASURES).await?;
    names.sort();
    let read = futures::stream::iter(names).map(|name| async move {
        let place = format!("{ERASURES}/{name}");
        // One that was taken back meanwhile is none.
        let Some(bytes) = bucket.read_whole(&place).await? else { return anyhow::Ok(Vec::new()) };
        let place = format!("{}/{place}", bucket.address());
        let erasures = read_lines(Path::new(&place), bytes)?;
        ensure!(erasures.len() == 1, "{place}: not an erasure, as web-admin writes them");
        Ok(erasures)
    });
    Ok(read.buffered(AT_ONCE).try_collect::<Vec<_>>().await?.into_iter().flatten().collect())
}
