//! Every valid message out of a cut or damaged file.

use std::io::{Read, Seek, Write};

use crate::read::ReadError;

/// What a recovery found.
#[derive(Clone, Debug, PartialEq, Eq, serde::Serialize)]
pub struct Recovered {
    /// Messages written.
    pub messages: u64,
    /// Servo ticks among them.
    pub samples: u64,
    /// Bytes read before the damage, or all.
    pub bytes_read: u64,
    /// What was wrong with the input, in words; empty when it was whole.
    pub damage: String,
}

/// Copies every valid record of `source` into a new, complete file, and reopens it to check.
///
/// # Errors
/// When not even the metadata can be read, or the disk refuses.
pub fn recover<W: Read + Write + Seek>(_source: impl Read, _sink: W) -> Result<Recovered, ReadError> {
    unimplemented!()
}
