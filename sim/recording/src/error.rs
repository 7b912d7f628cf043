//! Errors of reading and writing recordings.

use std::fmt::Display;

/// A file cannot be read as a recording.
#[derive(Debug, thiserror::Error)]
pub enum ReadError {
    /// Not an MCAP file, or an empty one.
    #[error("not a recording: {0}")]
    NotARecording(String),
    /// Metadata, an attachment or a topic is missing or malformed.
    #[error("{what}: {why}")]
    Missing {
        /// The missing or malformed item.
        what: String,
        /// The reason.
        why: String,
    },
    /// A record is damaged.
    #[error("damaged at byte {offset}: {why}")]
    Damaged {
        /// Offset in the file.
        offset: u64,
        /// The reason.
        why: String,
    },
    /// A chunk uses an unsupported compression; the file may be intact.
    #[error(
        "byte {offset}: a chunk is compressed with \"{compression}\"; allowed: zstd, or none. Rewrite the file, for \
         example with \"mcap compress FILE --output NEW\""
    )]
    Compression {
        /// Offset in the file.
        offset: u64,
        /// Name of the compression.
        compression: String,
    },
    /// Memory ran out while decompressing a chunk; the file may be intact.
    #[error("not enough memory to decompress a chunk")]
    OutOfMemory,
    /// An I/O error.
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
    /// An error of the MCAP library, or an I/O error.
    #[error("recording: {}", words(.0))]
    Mcap(#[from] mcap::McapError),
    /// A value that a recording cannot contain.
    #[error("recording: {field} = {value}; {allowed}")]
    Invalid {
        /// The field.
        field: String,
        /// The value found.
        value: String,
        /// The allowed values in words.
        allowed: String,
    },
}

impl WriteError {
    /// Creates the error for a field with a value that cannot be written.
    #[must_use]
    pub fn invalid(field: impl Display, value: impl Display, allowed: impl Display) -> Self {
        Self::Invalid { field: field.to_string(), value: value.to_string(), allowed: allowed.to_string() }
    }
}

/// Returns the message of the underlying I/O error, if there is one, without the library's prefix.
fn words(error: &mcap::McapError) -> String {
    match error {
        mcap::McapError::Io(error) => error.to_string(),
        other => other.to_string(),
    }
}
