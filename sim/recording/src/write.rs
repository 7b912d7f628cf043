//! Writing a recording.

use std::io::{Seek, Write};

use crate::event::Event;
use crate::sample::{Energy, Sample};
use crate::session::{Attachment, Session};

/// A recording could not be written.
#[derive(Debug, thiserror::Error)]
pub enum WriteError {
    /// The MCAP library or the disk said no.
    #[error("recording: {0}")]
    Mcap(#[from] mcap::McapError),
}

/// What `/scene` draws, plain data in SI.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SceneDrawing {
    /// Name and thickness in m of each layer, from the surface down.
    pub layers: Vec<(String, f64)>,
    /// Structures.
    pub structures: Vec<mechanics::structures::StructureSpec>,
    /// Needle length, in m.
    pub needle_length_m: f64,
    /// Needle radius, in m.
    pub needle_radius_m: f64,
}

/// Writes one attempt. Derives the slower topics from the samples it is given.
pub struct Writer<W: Write + Seek> {
    _w: W,
}

impl<W: Write + Seek> Writer<W> {
    /// Starts a recording: header, metadata and attachments first, so that a cut file still has them.
    ///
    /// # Errors
    /// When the disk refuses.
    pub fn create(
        _sink: W,
        _session: &Session,
        _attachments: &[Attachment],
        _drawing: &SceneDrawing,
    ) -> Result<Self, WriteError> {
        unimplemented!()
    }

    /// Writes one servo tick, and what is due on the slower topics.
    ///
    /// # Errors
    /// When the disk refuses.
    pub fn sample(&mut self, _sample: &Sample) -> Result<(), WriteError> {
        unimplemented!()
    }

    /// Writes an event.
    ///
    /// # Errors
    /// When the disk refuses.
    pub fn event(&mut self, _event: &Event) -> Result<(), WriteError> {
        unimplemented!()
    }

    /// Writes the ledger.
    ///
    /// # Errors
    /// When the disk refuses.
    pub fn energy(&mut self, _energy: &Energy) -> Result<(), WriteError> {
        unimplemented!()
    }

    /// Ends the recording: summary, indexes, footer.
    ///
    /// # Errors
    /// When the disk refuses.
    pub fn finish(self) -> Result<W, WriteError> {
        unimplemented!()
    }
}
