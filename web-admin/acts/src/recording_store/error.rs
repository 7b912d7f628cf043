//! Why a store has not done what was asked.

/// Codes by which stores say that they have no room: the status of HTTP for it, and what MinIO and Ceph call it.
const FULL: [&str; 3] = ["507 Insufficient Storage", "StorageFull", "QuotaExceeded"];

/// Why a store has not done what was asked.
#[derive(Debug, thiserror::Error)]
pub enum StoreError {
    /// The disk of this machine, on which a folder lies and by which everything goes.
    #[error(transparent)]
    Disk(#[from] std::io::Error),
    /// There is no such object.
    #[error("the bucket holds no such object")]
    Missing,
    /// The store does not answer, or not as it should.
    #[error("the store does not do what was asked: {0:#}")]
    Away(anyhow::Error),
    /// The store has no room.
    #[error("the store has no room: {0:#}")]
    Full(anyhow::Error),
}

impl StoreError {
    /// Why something was not written or listed. What is missing then is the bucket.
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
