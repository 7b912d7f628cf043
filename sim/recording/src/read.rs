//! Reading a recording, whole or cut, in one pass and bounded memory.

use std::io::Read;

use crate::event::Event;
use crate::sample::{Energy, Sample};
use crate::session::{Attachment, Session};

/// Why a file is not a usable recording.
#[derive(Debug, thiserror::Error)]
pub enum ReadError {
    /// Not an MCAP file, or nothing in it.
    #[error("not a recording: {0}")]
    NotARecording(String),
    /// Metadata or an attachment is missing or malformed.
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
    /// The disk said no.
    #[error(transparent)]
    Io(#[from] std::io::Error),
}

/// A recording in memory.
#[derive(Clone, Debug, PartialEq)]
pub struct Recording {
    /// Metadata.
    pub session: Session,
    /// Attachments.
    pub attachments: Vec<Attachment>,
    /// Servo ticks in order of time.
    pub samples: Vec<Sample>,
    /// Events in order of time.
    pub events: Vec<Event>,
    /// Ledger snapshots in order of time.
    pub energies: Vec<Energy>,
    /// The file ended with its footer; a cut one did not.
    pub complete: bool,
}

impl Recording {
    /// Reads a complete or cut recording. A cut one yields every valid message and `complete = false`.
    ///
    /// # Errors
    /// When it is no recording, lacks metadata or documents, or is damaged before its end.
    pub fn read(_source: impl Read) -> Result<Self, ReadError> {
        unimplemented!()
    }

    /// The attachment of a name.
    #[must_use]
    pub fn attachment(&self, name: &str) -> Option<&[u8]> {
        self.attachments.iter().find(|a| a.name == name).map(|a| a.data.as_slice())
    }
}
