//! Copies a recording and adds later remarks as events.

use std::io::Write;

use mcap::records::op;
use prost::Message;
use serde::{Deserialize, Serialize};

use crate::error::ReadError;
use crate::event::{Event, EventKind};
use crate::rate::nanoseconds;
use crate::read::Recording;
use crate::recover::{Copy, find_records};
use crate::wire::EventMessage;
use crate::write::start_unix_ns;

/// A remark about a moment of an attempt.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Annotation {
    /// Time since the start, in s.
    pub t_s: f64,
    /// The remark with its author: a role or a pseudonym, never a name.
    pub text: String,
}

/// Copies a recording into `sink` and inserts each remark at its time as an event of kind coaching.
/// Everything else is copied message by message: forces, score and re-simulation are those of the
/// original.
///
/// # Errors
/// If the input is not a recording, or on an I/O error.
pub fn annotate<W: Write>(bytes: &[u8], sink: W, remarks: &[Annotation]) -> Result<W, ReadError> {
    let recording = Recording::read(bytes)?;
    let start_ns = start_unix_ns(&recording.session).map_err(|error| ReadError::missing("started_at", error))?;
    let found = find_records(bytes)?;
    let mut copy = Copy::new(sink)?;
    copy.remarks = remarks
        .iter()
        .map(|remark| {
            let event = EventMessage::from(&event(&recording, remark));
            (start_ns.saturating_add(nanoseconds(remark.t_s)), event.encode_to_vec())
        })
        .collect();
    copy.remarks.sort_by_key(|(at_ns, _)| std::cmp::Reverse(*at_ns));
    for frame in found.frames.iter().filter(|frame| frame.opcode != op::CHUNK) {
        copy.document(frame)?;
    }
    copy.messages(&found.frames)?;
    copy.finish().map(|(_, sink)| sink)
}

/// Creates the event, with the needle's state at that time.
fn event(recording: &Recording, remark: &Annotation) -> Event {
    let before = recording.samples.partition_point(|sample| sample.t_s <= remark.t_s).saturating_sub(1);
    let sample = recording.samples.get(before).copied().unwrap_or_default();
    Event {
        t_s: remark.t_s,
        kind: EventKind::Coaching,
        boundary: None,
        x_m: sample.x_m,
        position_m: sample.position_m,
        force_n: sample.axial_n(),
        dissipated_j: 0.0,
        track: None,
        structure: None,
        text: remark.text.clone(),
    }
}
