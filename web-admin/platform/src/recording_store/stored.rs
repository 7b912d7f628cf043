//! Stored files, read as a whole or by ranges, without a local copy.

use std::ops::Range;
use std::path::PathBuf;

use bytes::Bytes;
use futures::StreamExt;
use futures::stream::BoxStream;

use super::{Bucket, StoreError};

/// A stored file.
#[derive(Debug)]
pub enum StoredFile {
    /// A local file.
    Local(PathBuf),
    /// An object in a bucket.
    Remote(StoredObject),
}

/// An existing, immutable object.
#[derive(Debug)]
pub struct StoredObject {
    bucket: Bucket,
    name: String,
    /// Size, in bytes.
    pub size: u64,
}

impl StoredFile {
    /// Looks up an object in a bucket; returns `None` if it does not exist.
    pub(super) async fn in_bucket(bucket: &Bucket, name: String) -> Result<Option<Self>, StoreError> {
        let size = bucket.find_size(&name).await?;
        let object = size.map(|size| StoredObject { bucket: bucket.clone(), name, size });
        Ok(object.map(Self::Remote))
    }

    /// Reads a small file as a whole.
    ///
    /// # Errors
    /// Fails if the disk fails, or the store does not respond.
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
    /// Streams a byte range of the object.
    ///
    /// # Errors
    /// Fails if the store does not respond.
    pub async fn read(&self, range: Range<u64>) -> Result<BoxStream<'static, anyhow::Result<Bytes>>, StoreError> {
        if range.is_empty() {
            return Ok(futures::stream::empty().boxed());
        }
        self.bucket.read(&self.name, range).await
    }
}
