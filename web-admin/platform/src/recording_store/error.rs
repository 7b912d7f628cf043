//! Errors of a recording store.

/// Error of a recording store.
#[derive(Debug, thiserror::Error)]
pub enum StoreError {
    /// The local disk failed, which holds the folder and all temporary files.
    #[error(transparent)]
    Disk(#[from] std::io::Error),
    /// The object does not exist.
    #[error("no such object in the bucket")]
    Missing,
    /// The store does not respond, or responds with an error.
    #[error("the store failed: {0:#}")]
    Away(anyhow::Error),
    /// The store is full.
    #[error("the store is full: {0:#}")]
    Full(anyhow::Error),
}
