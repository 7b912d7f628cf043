//! Why a recording cannot be read or written.

use std::fmt::Display;

/// Why a file is not a usable recording.
#[derive(Debug, thiserror::Error)]
pub enum ReadError {
    /// Not an MCAP file, or nothing in it.
    #[error("not a recording: {0}")]
    NotARecording(String),
    /// Metadata, an attachment or a topic is missing or malformed.
    #[error("{what}: {why}")]
    Missing {
        /// What is missing.
        what: String,
        /// What was found.
        why: String,
    },
    /// A record is damaged.
    #[error("damaged at byte {offset}: {why}")]
    Damaged {
        /// Offset in the file.
        offset: u64,
        /// What is wrong.
        why: String,
    },
    /// A chunk is compressed in a way that is not read here; the file may be whole.
    #[error(
        "byte {offset}: a chunk is compressed by \"{compression}\"; allowed: zstd, or none. Rewrite the file, as \
         \"mcap compress FILE --output NEW\" does"
    )]
    Compression {
        /// Offset in the file.
        offset: u64,
        /// What the chunk names.
        compression: String,
    },
    /// There was not enough memory to unpack it; nothing is said of the file.
    #[error("not enough memory to unpack a chunk")]
    OutOfMemory,
    /// The disk said no.
    #[error(transparent)]
    Io(#[from] std::io::Error),
}

impl ReadError {
    pub(crate) fn missing(what: impl Display, why: impl Display) -> Self {
        Self::Missing { what: what.to_string(), why: why.to_string() }
    }

    pub(crate) fn damaged(offset: u64, why: impl Display) -> Self {
        Self::Damaged { offset, why: why.to_string() }
    }
}

/// A recording could not be written.
#[derive(Debug, thiserror::Error)]
pub enum WriteError {
    /// The MCAP library or the disk said no.
    #[error("recording: {}", words(.0))]
    Mcap(#[from] mcap::McapError),
    /// Something that a recording cannot hold.
    #[error("recording: {field} = {value}: {allowed}")]
    Invalid {
        /// What it is.
        field: String,
        /// The value found.
        value: String,
        /// What is allowed, in words.
        allowed: String,
    },
}

impl WriteError {
    /// That a field's value cannot be written.
    #[must_use]
    pub fn invalid(field: impl Display, value: impl Display, allowed: impl Display) -> Self {
        Self::Invalid { field: field.to_string(), value: value.to_string(), allowed: allowed.to_string() }
    }
}

/// The disk's own words, where it was the disk.
fn words(error: &mcap::McapError) -> String {
    match error {
        mcap::McapError::Io(error) => error.to_string(),
        other => other.to_string(),
    }
}
