//! Why a store has not done what was asked.

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
