//! Stored files, read as a whole or by ranges, without a local copy.

use std::ops::Range;
use std::path::PathBuf;

use bytes::{Bytes, BytesMut};
use futures::stream::BoxStream;
use futures::{Stream, StreamExt};
use tokio::io::AsyncReadExt;

use super::{Bucket, StoreError};

/// Bytes of a local file that are sent at once.
const PIECE: usize = 1 << 16;

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

    /// Streams the whole file.
    ///
    /// # Errors
    /// Fails if the disk fails, or the store does not respond.
    pub async fn read_whole(self) -> Result<BoxStream<'static, anyhow::Result<Bytes>>, StoreError> {
        match self {
            Self::Local(path) => Ok(read_pieces(tokio::fs::File::open(path).await?).boxed()),
            Self::Remote(object) => object.read(0..object.size).await,
        }
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

/// Streams an open file.
fn read_pieces(file: tokio::fs::File) -> impl Stream<Item = anyhow::Result<Bytes>> {
    futures::stream::try_unfold(file, |mut file| async move {
        let mut piece = BytesMut::with_capacity(PIECE);
        let read = file.read_buf(&mut piece).await?;
        Ok((read > 0).then(|| (piece.freeze(), file)))
    })
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
