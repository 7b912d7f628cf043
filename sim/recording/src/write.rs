//! Writes recordings.

use std::collections::BTreeMap;
use std::io::Write;

use mcap::records::MessageHeader;
use mcap::write::{Metadata, NoSeek};
use mcap::{Compression, WriteOptions};
use prost::Message;

pub use crate::drawing::SceneDrawing;
use crate::drawing::{draw_pose, draw_scene, draw_transforms, log_line};
use crate::error::WriteError;
use crate::event::Event;
use crate::fluoroscopy::{CArmControls, FluoroscopyPulse};
use crate::metadata;
use crate::motion::{AttemptHashes, ConditionsDigest, MotionDigest};
use crate::rate::{Ticker, nanoseconds};
use crate::sample::{Energy, Sample};
use crate::session::{Attachment, Session};
use crate::signature::{self, Signature};
use crate::summary::SummaryWindow;
use crate::tent::Tent;
use crate::topics::{MOST_RECORD_BYTES, PROFILE, Topic, declare};
use crate::wire::{CArmMessage, EnergyLedger, EventMessage, NeedleSample, PulseMessage, TissueTent};

/// Uncompressed size at which a chunk is closed even before its half second has passed, in bytes.
const CHUNK_BYTES: u64 = 1 << 20;
/// Writes one attempt. Derives the slower topics from the samples.
///
/// Every half second of recorded time it closes the chunk and flushes the sink, so that a program
/// killed at any moment loses less than the last second.
pub struct Writer<W: Write> {
    mcap: mcap::Writer<NoSeek<W>>,
    /// The channel of each declared topic.
    channels: [Option<u16>; Topic::ALL.len()],
    sequences: [u32; Topic::ALL.len()],
    start_ns: u64,
    drawing: SceneDrawing,
    window: SummaryWindow,
    motion: MotionDigest,
    conditions: ConditionsDigest,
    /// Time of the last sample since the start, in ns.
    elapsed_ns: u64,
    flushes: Ticker,
    summaries: Ticker,
    poses: Ticker,
    drawings: Ticker,
}

/// Opens an MCAP writer with the options of every recording, including recovered ones.
pub(crate) fn open<W: Write>(sink: W) -> mcap::McapResult<mcap::Writer<NoSeek<W>>> {
    WriteOptions::new()
        .profile(PROFILE)
        .library(concat!("stylet/", env!("CARGO_PKG_VERSION")))
        .compression(Some(Compression::Zstd))
        // Without threads of its own the library writes the same bytes on every machine.
        .compression_threads(0)
        .chunk_size(Some(CHUNK_BYTES))
        // Chunks are built in memory and written whole: a killed program never leaves a
        // half-written header.
        .disable_seeking(true)
        .create(NoSeek::new(sink))
}

impl<W: Write> Writer<W> {
    /// Starts a recording. Header, metadata and attachments come first, so that a truncated file
    /// still has them.
    ///
    /// # Errors
    /// On an I/O error, if an attachment is larger than 32 MiB, or if the start lies outside the
    /// years 1970 to 2105.
    pub fn create(
        sink: W,
        session: &Session,
        attachments: &[Attachment],
        drawing: &SceneDrawing,
    ) -> Result<Self, WriteError> {
        let start_ns = start_unix_ns(session)?;
        let mut mcap = open(sink)?;
        let metadata = metadata::to_text(session)?;
        mcap.write_metadata(&Metadata { name: metadata::RECORD.to_owned(), metadata })?;
        for attachment in attachments {
            write_attachment(&mut mcap, attachment, start_ns)?;
        }
        let mut channels = [None; Topic::ALL.len()];
        for topic in Topic::ALL.into_iter().filter(|topic| topic.is_always_declared()) {
            channels[topic as usize] = Some(declare(&mut mcap, topic)?);
        }
        let mut writer = Self {
            mcap,
            channels,
            sequences: [0; Topic::ALL.len()],
            start_ns,
            drawing: drawing.clone(),
            window: SummaryWindow::EMPTY,
            motion: MotionDigest::default(),
            conditions: ConditionsDigest::default(),
            elapsed_ns: 0,
            flushes: Ticker::new(2, 1),
            summaries: Ticker::new(100, 1),
            poses: Ticker::new(60, 0),
            drawings: Ticker::new(1, 1),
        };
        writer.put_drawing()?;
        writer.mcap.flush()?;
        Ok(writer)
    }

    /// Writes one servo tick, and the messages due on the slower topics.
    ///
    /// # Errors
    /// On an I/O error.
    pub fn sample(&mut self, sample: &Sample) -> Result<(), WriteError> {
        let now_ns = nanoseconds(sample.t_s);
        if self.summaries.due(now_ns) {
            self.put_summary()?;
        }
        if self.flushes.due(now_ns) {
            self.mcap.flush()?;
        }
        self.elapsed_ns = now_ns;
        self.window.add(sample);
        self.motion.add(sample);
        self.conditions.add_sample(sample);
        self.put(Topic::Sample, now_ns, &NeedleSample::from(sample))?;
        if self.drawings.due(now_ns) {
            self.put_drawing()?;
        }
        if self.poses.due(now_ns) {
            let unix_ns = self.start_ns.saturating_add(now_ns);
            self.put(Topic::Pose, now_ns, &draw_pose(sample, unix_ns))?;
            self.put(Topic::Tf, now_ns, &draw_transforms(sample, unix_ns))?;
        }
        Ok(())
    }

    /// Writes an event.
    ///
    /// # Errors
    /// On an I/O error.
    pub fn event(&mut self, event: &Event) -> Result<(), WriteError> {
        let at_ns = nanoseconds(event.t_s);
        self.conditions.add_event(event);
        self.put(Topic::Events, at_ns, &EventMessage::from(event))?;
        self.put(Topic::Log, at_ns, &log_line(event, self.start_ns.saturating_add(at_ns)))
    }

    /// Writes the ledger.
    ///
    /// # Errors
    /// On an I/O error.
    pub fn energy(&mut self, energy: &Energy) -> Result<(), WriteError> {
        self.put(Topic::Energy, nanoseconds(energy.t_s), &EnergyLedger::from(energy))
    }

    /// Writes the state of the field.
    ///
    /// # Errors
    /// On an I/O error.
    pub fn tent(&mut self, tent: &Tent) -> Result<(), WriteError> {
        self.put(Topic::Tent, nanoseconds(tent.t_s), &TissueTent::from(tent))
    }

    /// Writes the controls of the C-arm: the first ones, and those that differ from the last.
    ///
    /// # Errors
    /// On an I/O error.
    pub fn controls(&mut self, controls: &CArmControls) -> Result<(), WriteError> {
        self.conditions.add_controls(controls);
        self.put(Topic::CArm, nanoseconds(controls.t_s), &CArmMessage::from(controls))
    }

    /// Writes a pulse of X-rays.
    ///
    /// # Errors
    /// On an I/O error.
    pub fn pulse(&mut self, pulse: &FluoroscopyPulse) -> Result<(), WriteError> {
        self.put(Topic::Fluoroscopy, nanoseconds(pulse.t_s), &PulseMessage::from(pulse))
    }

    /// Writes a separate metadata record, for example the servo's statistics.
    ///
    /// # Errors
    /// On an I/O error.
    pub fn metadata(&mut self, name: &str, metadata: BTreeMap<String, String>) -> Result<(), WriteError> {
        Ok(self.mcap.write_metadata(&Metadata { name: name.to_owned(), metadata })?)
    }

    /// Returns the hashes of the attempt so far, which a signature covers.
    #[must_use]
    pub fn hashes(&self) -> AttemptHashes {
        AttemptHashes { motion: self.motion.sha256(), conditions: self.conditions.sha256() }
    }

    /// Writes a station's signature, after the last sample.
    ///
    /// # Errors
    /// On an I/O error.
    pub fn sign(&mut self, signature: &Signature) -> Result<(), WriteError> {
        self.metadata(signature::RECORD, signature.to_text())
    }

    /// Ends the recording: summary, indexes, footer.
    ///
    /// # Errors
    /// On an I/O error.
    pub fn finish(mut self) -> Result<W, WriteError> {
        self.put_summary()?;
        self.mcap.finish()?;
        let mut sink = self.mcap.into_inner().into_inner();
        sink.flush().map_err(mcap::McapError::Io)?;
        Ok(sink)
    }

    /// Writes the drawing, which viewers need first and again every second.
    fn put_drawing(&mut self) -> Result<(), WriteError> {
        let unix_ns = self.start_ns.saturating_add(self.elapsed_ns);
        self.put(Topic::Scene, self.elapsed_ns, &draw_scene(&self.drawing, unix_ns))
    }

    /// Writes the summary of the window that has ended, at the time of its last tick.
    fn put_summary(&mut self) -> Result<(), WriteError> {
        match self.window.take() {
            Some(summary) => self.put(Topic::Summary, self.elapsed_ns, &summary),
            None => Ok(()),
        }
    }

    /// Declares the missing topics up to this one, so that channels always have the numbers of [`Topic::ALL`].
    fn declare_up_to(&mut self, topic: Topic) -> Result<u16, WriteError> {
        let mut channel_id = 0;
        for earlier in Topic::ALL.into_iter().take(topic as usize + 1) {
            let channel = &mut self.channels[earlier as usize];
            channel_id = match *channel {
                Some(declared) => declared,
                None => declare(&mut self.mcap, earlier)?,
            };
            *channel = Some(channel_id);
        }
        Ok(channel_id)
    }

    fn put(&mut self, topic: Topic, elapsed_ns: u64, message: &impl Message) -> Result<(), WriteError> {
        let channel_id = match self.channels[topic as usize] {
            Some(declared) => declared,
            None => self.declare_up_to(topic)?,
        };
        let sequence = &mut self.sequences[topic as usize];
        let log_time = self.start_ns.saturating_add(elapsed_ns);
        let header = MessageHeader { channel_id, sequence: *sequence, log_time, publish_time: log_time };
        *sequence = sequence.wrapping_add(1);
        Ok(self.mcap.write_to_known_channel(&header, &message.encode_to_vec())?)
    }
}

/// Returns the start as Unix time in ns. Viewers store seconds in 32 bits.
pub(crate) fn start_unix_ns(session: &Session) -> Result<u64, WriteError> {
    let nanoseconds = session.started_at.unix_timestamp_nanos();
    let seconds = session.started_at.unix_timestamp();
    u32::try_from(seconds)
        .ok()
        .and_then(|_| u64::try_from(nanoseconds).ok())
        .ok_or_else(|| WriteError::invalid("started_at", session.started_at, "allowed: the years 1970 to 2105"))
}

fn write_attachment<W: Write>(
    mcap: &mut mcap::Writer<NoSeek<W>>,
    attachment: &Attachment,
    start_ns: u64,
) -> Result<(), WriteError> {
    let bytes = attachment.data.len() + attachment.name.len() + attachment.media_type.len();
    if bytes > MOST_RECORD_BYTES / 2 {
        let what = format!("attachment {}", attachment.name);
        return Err(WriteError::invalid(what, format!("{bytes} bytes"), "allowed: at most 32 MiB"));
    }
    mcap.attach(&mcap::Attachment {
        log_time: start_ns,
        create_time: start_ns,
        name: attachment.name.clone(),
        media_type: attachment.media_type.clone(),
        data: (&attachment.data).into(),
    })?;
    Ok(())
}
