//! Reads a complete or truncated recording in one pass and bounded memory.

use std::collections::BTreeMap;
use std::io::{BufReader, Read};

use data_encoding::HEXLOWER;
use mcap::records::{Channel, Record, SchemaHeader, op};
use prost::Message;
use sha2::{Digest, Sha256};

use crate::budget::{Budget, Purse};
use crate::error::ReadError;
use crate::event::Event;
use crate::fluoroscopy::Fluoroscopy;
use crate::frames::{ChunkReader, PREFIX_BYTES, RecordFrame, parse_attachment, parse_record, walk_records};
use crate::metadata;
use crate::motion::AttemptHashes;
use crate::sample::{Energy, Sample};
use crate::session::{Attachment, EXERCISE_ATTACHMENT, SCENE_ATTACHMENT, Session};
use crate::signature::{self, Signature};
use crate::tent::Tent;
use crate::topics::{PROFILE, Topic};
use crate::wire::{CArmMessage, EnergyLedger, EventMessage, NeedleSample, PulseMessage, TissueTent};

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
    /// The field in order of time; empty if the scene has none, and in files older than this topic.
    pub tents: Vec<Tent>,
    /// Use of the C-arm; empty without fluoroscopy.
    pub fluoroscopy: Fluoroscopy,
    /// The station's signature, if there is one. It is not verified here, because that requires the
    /// station's key.
    pub signature: Option<Signature>,
    /// Whether the file is complete, including its footer. `false` if it is truncated or damaged
    /// after its data.
    pub complete: bool,
}

impl Recording {
    /// Reads a complete or truncated recording. A truncated one yields every valid message and
    /// `complete = false`.
    ///
    /// A file without samples yields an empty list. The times of samples are finite and increase.
    ///
    /// # Errors
    /// If the input is not a recording, lacks metadata or documents, or is damaged before its end.
    pub fn read(source: impl Read) -> Result<Self, ReadError> {
        Self::read_within(source, Budget::default())
    }

    /// Like [`Self::read`], within a budget; use it for files from untrusted sources.
    ///
    /// # Errors
    /// As [`Self::read`], and if the budget is exceeded.
    pub fn read_within(source: impl Read, budget: Budget) -> Result<Self, ReadError> {
        let mut contents = Contents::read_within(source, budget)?;
        let why = contents.absence();
        let session = contents.session.take();
        let session = session.ok_or_else(|| ReadError::missing(format!("metadata {}", metadata::RECORD), why))?;
        for (name, sha256) in
            [(EXERCISE_ATTACHMENT, &session.exercise_sha256), (SCENE_ATTACHMENT, &session.scene_sha256)]
        {
            contents.check_document(name, sha256)?;
        }
        Ok(Self {
            session,
            attachments: contents.attachments,
            samples: contents.samples,
            events: contents.events,
            energies: contents.energies,
            tents: contents.tents,
            fluoroscopy: contents.fluoroscopy,
            signature: contents.signature,
            complete: contents.complete,
        })
    }

    /// Returns a complete recording in memory without samples.
    #[must_use]
    pub fn in_memory(session: Session) -> Self {
        Self {
            session,
            attachments: Vec::new(),
            samples: Vec::new(),
            events: Vec::new(),
            energies: Vec::new(),
            tents: Vec::new(),
            fluoroscopy: Fluoroscopy::default(),
            signature: None,
            complete: true,
        }
    }

    /// Returns the hashes that a station signs.
    #[must_use]
    pub fn hashes(&self) -> AttemptHashes {
        AttemptHashes::of_attempt(&self.samples, &self.events, &self.fluoroscopy)
    }

    /// Returns the content of the attachment with this name.
    #[must_use]
    pub fn attachment(&self, name: &str) -> Option<&[u8]> {
        self.attachments.iter().find(|a| a.name == name).map(|a| a.data.as_slice())
    }
}

/// Checks that the file has our profile.
pub(crate) fn check_profile(profile: &str) -> Result<(), ReadError> {
    match profile {
        PROFILE => Ok(()),
        _ => Err(ReadError::NotARecording(format!("its profile is {profile:?}; allowed: {PROFILE:?}"))),
    }
}

/// The schemas and channels declared so far.
#[derive(Default)]
pub(crate) struct Channels {
    schemas: BTreeMap<u16, String>,
    /// The topic of each channel, `None` for a channel that does not belong to this format.
    topics: BTreeMap<u16, Option<Topic>>,
}

impl Channels {
    pub(crate) fn declare_schema(&mut self, header: SchemaHeader) {
        self.schemas.insert(header.id, header.name);
    }

    pub(crate) fn declare(&mut self, channel: &Channel) -> Result<(), ReadError> {
        let topic = Topic::of_name(&channel.topic);
        if let Some(topic) = topic {
            let schema = self.schemas.get(&channel.schema_id).map_or("none", String::as_str);
            let allowed = topic.message_name();
            if schema != allowed || channel.message_encoding != "protobuf" {
                let what = format!("topic {}", channel.topic);
                let why = format!("schema {schema} as {}; allowed: {allowed} as protobuf", channel.message_encoding);
                return Err(ReadError::missing(what, why));
            }
        }
        self.topics.insert(channel.id, topic);
        Ok(())
    }

    /// Returns the topic of a message's channel; `None` for a channel that does not belong to this
    /// format.
    pub(crate) fn topic(&self, channel: u16) -> Result<Option<Topic>, String> {
        let topic = self.topics.get(&channel).copied();
        topic.ok_or_else(|| format!("a message of channel {channel}, which was not declared"))
    }
}

/// The contents of a file, before they are checked for completeness.
#[derive(Default)]
pub(crate) struct Contents {
    pub(crate) session: Option<Session>,
    pub(crate) attachments: Vec<Attachment>,
    pub(crate) samples: Vec<Sample>,
    pub(crate) events: Vec<Event>,
    pub(crate) energies: Vec<Energy>,
    pub(crate) tents: Vec<Tent>,
    fluoroscopy: Fluoroscopy,
    signature: Option<Signature>,
    pub(crate) complete: bool,
    /// Number of messages on all topics.
    pub(crate) messages: u64,
    channels: Channels,
    purse: Purse,
}

impl Contents {
    pub(crate) fn read(source: impl Read) -> Result<Self, ReadError> {
        Self::read_within(source, Budget::default())
    }

    fn read_within(source: impl Read, budget: Budget) -> Result<Self, ReadError> {
        let mut contents = Self { purse: Purse::new(budget), ..Self::default() };
        let mut chunks = ChunkReader::new();
        let complete = walk_records(BufReader::new(source), |frame| match frame.opcode {
            op::CHUNK => chunks.walk(&frame, |inner| contents.take(&inner)),
            _ => contents.take(&frame),
        })?;
        contents.complete = complete;
        Ok(contents)
    }

    /// Returns the reason why an item is missing.
    fn absence(&self) -> &'static str {
        if self.complete { "missing from the file" } else { "the file ends before it" }
    }

    /// Checks that a document is attached and has the hash in the metadata.
    fn check_document(&self, name: &str, sha256: &str) -> Result<(), ReadError> {
        let what = format!("attachment {name}");
        let Some(found) = self.attachments.iter().find(|a| a.name == name) else {
            return Err(ReadError::missing(what, self.absence()));
        };
        let is = HEXLOWER.encode(&Sha256::digest(&found.data));
        match is == sha256 {
            true => Ok(()),
            false => Err(ReadError::missing(what, format!("its SHA-256 is {is}, but the metadata contain {sha256:?}"))),
        }
    }

    fn take(&mut self, frame: &RecordFrame<'_>) -> Result<(), ReadError> {
        self.purse.unpack(PREFIX_BYTES + frame.data.len()).map_err(|why| frame.damaged(why))?;
        if frame.opcode == op::ATTACHMENT {
            let found = parse_attachment(frame.data).map_err(|e| frame.damaged(e))?;
            return self.take_attachment(frame, found);
        }
        match parse_record(frame.opcode, frame.data).map_err(|e| frame.damaged(e))? {
            Record::Header(header) => check_profile(&header.profile),
            Record::Metadata(record) if record.name == metadata::RECORD => {
                let session = metadata::from_text(&record.metadata)?;
                expect_once(self.session.replace(session).is_none(), &record.name)
            }
            Record::Metadata(record) if record.name == signature::RECORD => {
                let found = Signature::from_text(&record.metadata)?;
                expect_once(self.signature.replace(found).is_none(), &record.name)
            }
            Record::Schema { header, .. } => {
                self.purse.keep(header.name.len()).map_err(|why| frame.damaged(why))?;
                self.channels.declare_schema(header);
                Ok(())
            }
            Record::Channel(channel) => self.channels.declare(&channel),
            Record::Message { header, data } => {
                self.take_message(header.channel_id, &data).map_err(|why| frame.damaged(why))
            }
            _ => Ok(()),
        }
    }

    fn take_attachment(&mut self, frame: &RecordFrame<'_>, found: mcap::Attachment<'_>) -> Result<(), ReadError> {
        expect_once(self.attachments.iter().all(|a| a.name != found.name), &found.name)?;
        let mcap::Attachment { name, media_type, data, .. } = found;
        let found = Attachment { name, media_type, data: data.into_owned() };
        self.purse.attachment(&found).map_err(|why| frame.damaged(why))?;
        self.attachments.push(found);
        Ok(())
    }

    fn take_message(&mut self, channel: u16, data: &[u8]) -> Result<(), String> {
        self.messages += 1;
        self.purse.message()?;
        match self.channels.topic(channel)? {
            Some(Topic::Sample) => self.take_sample(decode_message::<NeedleSample>(data)?.into())?,
            Some(Topic::Events) => {
                let event = decode_message::<EventMessage>(data)?.try_into()?;
                self.purse.event(&event)?;
                self.events.push(event);
            }
            Some(Topic::Energy) => {
                let energy = decode_message::<EnergyLedger>(data)?.into();
                self.purse.energy(&energy)?;
                self.energies.push(energy);
            }
            Some(Topic::Tent) => {
                let tent = decode_message::<TissueTent>(data)?.into();
                self.purse.tent(&tent)?;
                self.tents.push(tent);
            }
            Some(Topic::CArm) => {
                let controls = decode_message::<CArmMessage>(data)?.into();
                self.purse.controls(&controls)?;
                self.fluoroscopy.controls.push(controls);
            }
            Some(Topic::Fluoroscopy) => {
                let pulse = decode_message::<PulseMessage>(data)?.into();
                self.purse.pulse(&pulse)?;
                self.fluoroscopy.pulses.push(pulse);
            }
            _ => {}
        }
        Ok(())
    }

    fn take_sample(&mut self, sample: Sample) -> Result<(), String> {
        self.purse.sample(&sample)?;
        let last_s = self.samples.last().map_or(f64::NEG_INFINITY, |last| last.t_s);
        if sample.t_s > last_s {
            self.samples.push(sample);
            Ok(())
        } else {
            Err(format!("a sample at {} s follows one at {last_s} s; allowed: increasing times", sample.t_s))
        }
    }
}

fn decode_message<M: Message + Default>(data: &[u8]) -> Result<M, String> {
    M::decode(data).map_err(|error| error.to_string())
}

fn expect_once(first: bool, name: &str) -> Result<(), ReadError> {
    if first { Ok(()) } else { Err(ReadError::missing(name, "present twice; allowed: once")) }
}
