//! Stand-in for buckets in programs built without the feature `replicas`. It cannot be constructed,
//! so its methods are never called.

use std::convert::Infallible;
use std::ops::Range;
use std::path::{Path, PathBuf};

use anyhow::bail;
use bytes::Bytes;
use futures::stream::BoxStream;

use super::StoreError;
use crate::bucket_address::{BucketAddress, UNBUILT};
use crate::files::PartFile;

/// An uninhabited stand-in for a bucket.
#[derive(Clone, Debug)]
pub struct Bucket(Infallible);

impl Bucket {
    pub(super) fn open(address: &BucketAddress, _passing: PathBuf) -> anyhow::Result<Self> {
        bail!("{address}: {UNBUILT}")
    }

    /// Returns the address.
    #[must_use]
    pub const fn address(&self) -> &BucketAddress {
        match self.0 {}
    }

    pub(super) async fn send(&self, _file: &Path, _name: &str) -> Result<(), StoreError> {
        match self.0 {}
    }

    pub(super) async fn send_and_check(&self, _file: &Path, _name: &str, _sha256: &str) -> Result<(), StoreError> {
        match self.0 {}
    }

    pub(super) async fn hash(&self, _name: &str) -> Result<(String, u64), StoreError> {
        match self.0 {}
    }

    pub(super) async fn fetch(&self, _name: &str) -> Result<PartFile, StoreError> {
        match self.0 {}
    }

    pub(super) async fn join(&self, _names: &[String]) -> Result<(PartFile, String), StoreError> {
        match self.0 {}
    }

    pub(super) async fn find_size(&self, _name: &str) -> Result<Option<u64>, StoreError> {
        match self.0 {}
    }

    pub(super) async fn read(
        &self,
        _name: &str,
        _range: Range<u64>,
    ) -> Result<BoxStream<'static, anyhow::Result<Bytes>>, StoreError> {
        match self.0 {}
    }

    pub async fn put(&self, _name: &str, _bytes: Vec<u8>) -> Result<(), StoreError> {
        match self.0 {}
    }

    pub async fn read_whole(&self, _name: &str) -> Result<Option<Vec<u8>>, StoreError> {
        match self.0 {}
    }

    pub async fn check(&self) -> Result<(), StoreError> {
        match self.0 {}
    }

    pub async fn list(&self, _folder: &str) -> Result<Vec<String>, StoreError> {
        match self.0 {}
    }

    pub async fn remove(&self, _names: Vec<String>) -> Result<(), StoreError> {
        match self.0 {}
    }
}
