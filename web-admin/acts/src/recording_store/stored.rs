//! What is stored, to be read whole or in ranges without a copy of it.

use std::ops::Range;
use std::path::PathBuf;

use bytes::Bytes;
use futures::StreamExt;
use futures::stream::BoxStream;

use super::{Bucket, StoreError};

/// Something that is stored.
#[derive(Debug)]
pub enum StoredFile {
    /// A file of this machine.
    Local(PathBuf),
    /// An object elsewhere.
    Remote(StoredObject),
}

/// An object that is there, and never changes.
#[derive(Debug)]
pub struct StoredObject {
    bucket: Bucket,
    name: String,
    /// In bytes.
    pub size: u64,
}

impl StoredFile {
    /// An object of a bucket; none where there is none.
    pub(super) async fn in_bucket(bucket: &Bucket, name: String) -> Result<Option<Self>, StoreError> {
        let size = bucket.find_size(&name).await?;
        let object = size.map(|size| StoredObject { bucket: bucket.clone(), name, size });
        Ok(object.map(Self::Remote))
    }

    /// All bytes of something small.
    ///
    /// # Errors
    /// When the disk fails, or the store does not answer.
    pub async fn read_all(self) -> anyhow::Result<Vec<u8>> {
        match self {
            Self::Local(path) => Ok(tokio::fs::read(path).await?),
            Self::Remote(object) => {
                let mut chunks = object.read(0..object.size).await?;
                let mut bytes = Vec::new();
                while let Some(chunk) = chunks.next().await {
                    bytes.extend_from_slice(&chunk?);
                }
                Ok(bytes)
            }
        }
    }
}

impl StoredObject {
    /// A range of the bytes, some at a time.
    ///
    /// # Errors
    /// When the store does not answer.
    pub async fn read(&self, range: Range<u64>) -> Result<BoxStream<'static, anyhow::Result<Bytes>>, StoreError> {
        if range.is_empty() {
            return Ok(futures::stream::empty().boxed());
        }
        self.bucket.read(&self.name, range).await
    }
}
