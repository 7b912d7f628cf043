//! Recordings in an S3-compatible bucket. Objects appear atomically, and their names are unique to
//! their content, so no object is ever replaced by a different one.

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Duration;

use anyhow::Context;
use bytes::Bytes;
use data_encoding::HEXLOWER;
use futures::stream::BoxStream;
use futures::{StreamExt, TryStreamExt};
use object_store::aws::{AmazonS3, AmazonS3Builder, AmazonS3ConfigKey};
use object_store::path::Path as ObjectName;
use object_store::{
    BackoffConfig, ClientOptions, GetOptions, MultipartUpload, ObjectStore, ObjectStoreExt, RetryConfig,
};
use sha2::{Digest, Sha256};
use tokio::fs::File;
use tokio::io::{AsyncReadExt, AsyncWrite, AsyncWriteExt};
use tokio::sync::Semaphore;
use uuid::Uuid;

use super::StoreError;
use crate::bucket_address::BucketAddress;
use crate::files::PartFile;

/// Size of a part of a multipart upload, in bytes; also the memory used per upload. S3 requires at
/// least 5 MiB per part and at most 10 000 parts.
const PART_BYTES: u64 = 16 << 20;
/// Maximum number of concurrent uploads.
const MOST_SENT: usize = 4;
/// Error codes of a full store: the HTTP status, and the codes of MinIO and Ceph.
const FULL: [&str; 3] = ["507 Insufficient Storage", "StorageFull", "QuotaExceeded"];
/// Read timeout of a connection.
const SILENCE: Duration = Duration::from_secs(30);
/// Maximum number of retries of a failed request.
const TRIES: usize = 3;
/// Time limit for the retries of a request, and for waiting to upload.
const PATIENCE: Duration = Duration::from_secs(30);
/// Timeout of connecting.
const CONNECTING: Duration = Duration::from_secs(5);

/// A bucket, and the local folder for temporary files.
#[derive(Clone, Debug)]
pub struct Bucket {
    objects: Arc<AmazonS3>,
    address: BucketAddress,
    passing: PathBuf,
    sending: Arc<Semaphore>,
}

impl Bucket {
    /// Opens a bucket without contacting it. Temporary files are created in `passing`.
    ///
    /// # Errors
    /// Fails if a setting is invalid.
    pub(super) fn open(address: &BucketAddress, passing: PathBuf) -> anyhow::Result<Self> {
        crate::settle_tls();
        let mut builder = AmazonS3Builder::new();
        // No total timeout, since a large recording takes long; the read timeout catches stalls.
        let mut client = ClientOptions::new().with_timeout_disabled().with_read_timeout(SILENCE);
        client = client.with_connect_timeout(CONNECTING);
        let plain = |endpoint: &str| endpoint.starts_with("http://");
        let endpoints = ["AWS_ENDPOINT", "AWS_ENDPOINT_URL", "AWS_ENDPOINT_URL_S3"];
        // An endpoint configured without TLS is a deliberate choice.
        client =
            client.with_allow_http(endpoints.iter().any(|name| address.settings.get(*name).is_some_and(|e| plain(e))));
        builder = builder.with_client_options(client);
        for (name, value) in &address.settings {
            // Unknown AWS variables belong to other programs.
            if let Ok(key) = name.to_ascii_lowercase().parse::<AmazonS3ConfigKey>() {
                builder = builder.with_config(key, value);
            }
        }
        let backoff = BackoffConfig { max_backoff: Duration::from_secs(2), ..BackoffConfig::default() };
        let retry = RetryConfig { backoff, max_retries: TRIES, retry_timeout: PATIENCE };
        // Some S3-compatible stores lack bulk deletion.
        let builder = builder.with_bucket_name(&address.bucket).with_retry(retry).with_disable_bulk_delete(true);
        let objects = builder.build().with_context(|| address.to_string())?;
        let sending = Arc::new(Semaphore::new(MOST_SENT));
        Ok(Self { objects: Arc::new(objects), address: address.clone(), passing, sending })
    }

    /// Returns the address, for messages.
    #[must_use]
    pub const fn address(&self) -> &BucketAddress {
        &self.address
    }

    fn full_name(&self, name: &str) -> ObjectName {
        ObjectName::from(self.address.name_within(name))
    }

    /// Returns a new temporary file, deleted on drop.
    fn new_part(&self) -> PartFile {
        PartFile { path: self.passing.join(format!("{}.part", Uuid::new_v4())), kept: false }
    }

    /// Uploads a file as an object.
    pub(super) async fn send(&self, file: &Path, name: &str) -> Result<(), StoreError> {
        let place = tokio::time::timeout(PATIENCE, self.sending.acquire()).await.context("others are sent first");
        let _place = place.and_then(|place| Ok(place?)).map_err(StoreError::Away)?;
        let (mut file, name) = (File::open(file).await?, self.full_name(name));
        let first = read_part(&mut file).await?;
        if (first.len() as u64) < PART_BYTES {
            self.objects.put(&name, first.into()).await.map_err(StoreError::of_writing)?;
            return Ok(());
        }
        let mut upload = self.objects.put_multipart(&name).await.map_err(StoreError::of_writing)?;
        let sent = send_parts(&mut *upload, first, &mut file).await;
        if sent.is_err() {
            // Report the first error only; the bucket's lifecycle rule removes incomplete uploads.
            let _ = upload.abort().await;
        }
        sent
    }

    /// Uploads a file as an object and reads it back to verify its hash.
    pub(super) async fn send_and_check(&self, file: &Path, name: &str, sha256: &str) -> Result<(), StoreError> {
        self.send(file, name).await?;
        let (there, size) = self.hash(name).await?;
        if there == sha256 {
            return Ok(());
        }
        Err(StoreError::Away(anyhow::anyhow!(
            "{}/{name}: the stored {size} bytes have a different hash than the bytes sent",
            self.address
        )))
    }

    /// Returns the SHA-256 of an object, lower-case hexadecimal, and its size in bytes.
    pub(super) async fn hash(&self, name: &str) -> Result<(String, u64), StoreError> {
        let mut hash = Sha256::new();
        let size = self.pour(name, &mut hash, &mut tokio::io::sink()).await?;
        Ok((HEXLOWER.encode(&hash.finalize()), size))
    }

    /// Downloads an object to a temporary file.
    pub(super) async fn fetch(&self, name: &str) -> Result<PartFile, StoreError> {
        Ok(self.join(&[name.to_owned()]).await?.0)
    }

    /// Downloads several objects, concatenated, to a temporary file. Returns it with its SHA-256.
    pub(super) async fn join(&self, names: &[String]) -> Result<(PartFile, String), StoreError> {
        let part = self.new_part();
        let (mut file, mut hash) = (File::create_new(&part.path).await?, Sha256::new());
        for name in names {
            self.pour(name, &mut hash, &mut file).await?;
        }
        file.flush().await?;
        Ok((part, HEXLOWER.encode(&hash.finalize())))
    }

    /// Streams an object into `to` and `hash`, and returns its size in bytes.
    async fn pour(&self, name: &str, hash: &mut Sha256, to: &mut (impl AsyncWrite + Unpin)) -> Result<u64, StoreError> {
        let mut chunks = self.objects.get(&self.full_name(name)).await?.into_stream();
        let mut size = 0;
        while let Some(chunk) = chunks.try_next().await? {
            hash.update(&chunk);
            to.write_all(&chunk).await?;
            size += chunk.len() as u64;
        }
        Ok(size)
    }

    /// Returns the size of an object, in bytes; `None` if it does not exist.
    pub(super) async fn find_size(&self, name: &str) -> Result<Option<u64>, StoreError> {
        match self.objects.head(&self.full_name(name)).await.map_err(StoreError::from) {
            Err(StoreError::Missing) => Ok(None),
            found => Ok(Some(found?.size)),
        }
    }

    /// Streams a byte range of an object.
    pub(super) async fn read(
        &self,
        name: &str,
        range: std::ops::Range<u64>,
    ) -> Result<BoxStream<'static, anyhow::Result<Bytes>>, StoreError> {
        let asked = GetOptions::new().with_range(Some(range));
        let found = self.objects.get_opts(&self.full_name(name), asked).await?;
        Ok(found.into_stream().map_err(anyhow::Error::from).boxed())
    }

    /// Writes a small object.
    pub async fn put(&self, name: &str, bytes: Vec<u8>) -> Result<(), StoreError> {
        self.objects.put(&self.full_name(name), bytes.into()).await.map(drop).map_err(StoreError::of_writing)
    }

    /// Reads a small object; returns `None` if it does not exist.
    pub async fn read_whole(&self, name: &str) -> Result<Option<Vec<u8>>, StoreError> {
        let found = match self.objects.get(&self.full_name(name)).await.map_err(StoreError::from) {
            Err(StoreError::Missing) => return Ok(None),
            found => found?,
        };
        Ok(Some(found.bytes().await?.into()))
    }

    /// Checks that the bucket exists and responds.
    pub async fn check(&self) -> Result<(), StoreError> {
        let name = ObjectName::from(self.address.prefix.as_str());
        self.objects.list_with_delimiter(Some(&name)).await.map(drop).map_err(StoreError::of_writing)
    }

    /// Lists the names below a prefix, relative to it.
    pub async fn list(&self, folder: &str) -> Result<Vec<String>, StoreError> {
        let (folder, below) = (self.full_name(folder), format!("{}/", self.address.name_within(folder)));
        let names = self.objects.list(Some(&folder)).map_ok(|object| object.location.to_string());
        let names: Vec<String> = names.try_collect().await.map_err(StoreError::of_writing)?;
        Ok(names.iter().filter_map(|name| name.strip_prefix(&below)).map(str::to_owned).collect())
    }

    /// Deletes objects; a missing object is not an error.
    pub async fn remove(&self, names: Vec<String>) -> Result<(), StoreError> {
        let names: Vec<_> = names.iter().map(|name| Ok(self.full_name(name))).collect();
        let mut gone = self.objects.delete_stream(futures::stream::iter(names).boxed());
        while let Some(one) = gone.next().await {
            match one.map_err(StoreError::from) {
                Err(StoreError::Missing) | Ok(_) => {}
                Err(error) => return Err(error),
            }
        }
        Ok(())
    }
}

impl StoreError {
    /// Classifies an error from writing or listing. A missing resource here is the bucket itself,
    /// so it counts as unavailable.
    pub(super) fn of_writing(error: object_store::Error) -> Self {
        let said = anyhow::Error::new(error);
        let text = format!("{said:#}");
        if FULL.iter().any(|code| text.contains(code)) { Self::Full(said) } else { Self::Away(said) }
    }
}

impl From<object_store::Error> for StoreError {
    fn from(error: object_store::Error) -> Self {
        match error {
            object_store::Error::NotFound { .. } => Self::Missing,
            error => Self::of_writing(error),
        }
    }
}

/// Uploads the rest of a file after its first part, one part at a time.
async fn send_parts(upload: &mut dyn MultipartUpload, first: Bytes, file: &mut File) -> Result<(), StoreError> {
    let mut part = first;
    while !part.is_empty() {
        upload.put_part(part.into()).await.map_err(StoreError::of_writing)?;
        part = read_part(file).await?;
    }
    upload.complete().await.map_err(StoreError::of_writing)?;
    Ok(())
}

/// Reads the next part of a file; returns it empty at the end of the file.
async fn read_part(file: &mut File) -> std::io::Result<Bytes> {
    let mut part = Vec::new();
    file.take(PART_BYTES).read_to_end(&mut part).await?;
    Ok(part.into())
}
