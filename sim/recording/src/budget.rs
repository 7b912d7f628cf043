//! Limits on the resources used for reading a recording. A few kilobytes can decompress to
//! gigabytes, and a few bytes can expand to a thousand in memory.

use std::mem::size_of;

use law::ledger::LayerEnergy;

use crate::event::Event;
use crate::fluoroscopy::{CArmControls, FluoroscopyPulse};
use crate::sample::{Energy, Sample};
use crate::session::Attachment;
use crate::tent::Tent;

/// Resource limits for reading a recording.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Budget {
    /// Memory for the result, in bytes.
    pub kept_bytes: u64,
    /// Total size of decompressed chunks, in bytes.
    pub unpacked_bytes: u64,
    /// Messages on all topics.
    pub messages: u64,
}

impl Default for Budget {
    /// Enough for an hour and a half at 1 kHz.
    fn default() -> Self {
        Self { kept_bytes: 1 << 30, unpacked_bytes: 2 << 30, messages: 8_000_000 }
    }
}

/// Maximum number of events: an attempt has a few dozen.
const MOST_EVENTS: usize = 10_000;
/// Maximum number of attachments: exercise, scene and meshes.
const MOST_ATTACHMENTS: usize = 256;
/// Maximum length of an event's text, in bytes.
const LONGEST_TEXT: usize = 4096;
/// Maximum length of an attachment's name, in bytes.
const LONGEST_NAME: usize = 255;
/// Largest time of a message since the start, in s.
const LATEST_S: f64 = 1e6;

/// The remaining part of a budget.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Purse {
    left: Budget,
    whole: Budget,
    events: usize,
    attachments: usize,
}

impl Default for Purse {
    fn default() -> Self {
        Self::new(Budget::default())
    }
}

impl Purse {
    pub(crate) fn new(whole: Budget) -> Self {
        Self { left: whole, whole, events: 0, attachments: 0 }
    }

    /// Charges a record of `bytes` bytes, from a chunk or from the file.
    pub(crate) fn unpack(&mut self, bytes: usize) -> Result<(), String> {
        let whole = self.whole.unpacked_bytes;
        spend_budget(&mut self.left.unpacked_bytes, bytes, || format!("it decompresses to more than {whole} bytes"))
    }

    pub(crate) fn message(&mut self) -> Result<(), String> {
        let whole = self.whole.messages;
        spend_budget(&mut self.left.messages, 1, || format!("more than {whole} messages"))
    }

    /// Charges bytes that stay in memory.
    pub(crate) fn keep(&mut self, bytes: usize) -> Result<(), String> {
        let whole = self.whole.kept_bytes;
        spend_budget(&mut self.left.kept_bytes, bytes, || format!("it takes more than {whole} bytes of memory"))
    }

    pub(crate) fn sample(&mut self, sample: &Sample) -> Result<(), String> {
        check_moment("a sample", sample.t_s)?;
        self.keep(size_of::<Sample>())
    }

    pub(crate) fn event(&mut self, event: &Event) -> Result<(), String> {
        check_moment("an event", event.t_s)?;
        self.events += 1;
        check_at_most("events", self.events, MOST_EVENTS)?;
        check_at_most("bytes of an event's text", event.text.len(), LONGEST_TEXT)?;
        self.keep(size_of::<Event>() + event.text.len())
    }

    pub(crate) fn energy(&mut self, energy: &Energy) -> Result<(), String> {
        check_moment("a ledger", energy.t_s)?;
        self.keep(size_of::<Energy>() + energy.ledger.layers.len() * size_of::<LayerEnergy>())
    }

    pub(crate) fn tent(&mut self, tent: &Tent) -> Result<(), String> {
        check_moment("a tent", tent.t_s)?;
        let numbers = tent.tent_m.len() + tent.contactor_n.len() + tent.drag_n.len() + tent.linear_n.len();
        self.keep(size_of::<Tent>() + numbers * size_of::<f32>())
    }

    pub(crate) fn controls(&mut self, controls: &CArmControls) -> Result<(), String> {
        check_moment("controls of the C-arm", controls.t_s)?;
        self.keep(size_of::<CArmControls>())
    }

    pub(crate) fn pulse(&mut self, pulse: &FluoroscopyPulse) -> Result<(), String> {
        check_moment("a pulse", pulse.t_s)?;
        self.keep(size_of::<FluoroscopyPulse>())
    }

    pub(crate) fn attachment(&mut self, found: &Attachment) -> Result<(), String> {
        self.attachments += 1;
        check_at_most("attachments", self.attachments, MOST_ATTACHMENTS)?;
        check_at_most("bytes of an attachment's name", found.name.len().max(found.media_type.len()), LONGEST_NAME)?;
        self.keep(size_of::<Attachment>() + found.name.len() + found.media_type.len() + found.data.len())
    }
}

fn spend_budget(left: &mut u64, cost: usize, broke: impl FnOnce() -> String) -> Result<(), String> {
    *left = left.checked_sub(cost as u64).ok_or_else(broke)?;
    Ok(())
}

fn check_at_most(what: &str, count: usize, most: usize) -> Result<(), String> {
    if count <= most { Ok(()) } else { Err(format!("{count} {what}; allowed: at most {most}")) }
}

fn check_moment(what: &str, t_s: f64) -> Result<(), String> {
    match (0.0..=LATEST_S).contains(&t_s) {
        true => Ok(()),
        false => Err(format!("{what} at {t_s} s; allowed: 0 to {LATEST_S} s")),
    }
}
