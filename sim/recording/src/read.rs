//! Reading a recording, whole or cut, in one pass and bounded memory.

use std::collections::BTreeMap;
use std::fmt::Display;
use std::io::{BufReader, Read};

use mcap::records::{Channel, Record, SchemaHeader, op};
use prost::Message;

use crate::event::Event;
use crate::frames::{ChunkReader, Frame, attachment, record, walk};
use crate::metadata;
use crate::sample::{Energy, Sample};
use crate::session::{Attachment, EXERCISE_ATTACHMENT, SCENE_ATTACHMENT, Session};
use crate::signature::{self, Signature};
use crate::tent::Tent;
use crate::topics::Topic;
use crate::wire::{EnergyLedger, EventMessage, NeedleSample, TissueTent};
use crate::write::PROFILE;

/// Most samples, and most events, ledgers and tents, that are read: over an hour at 1 kHz. A small file can unpack to far more.
const MOST_MESSAGES: usize = 4_000_000;

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
    /// The field in order of time; empty where the scene has none, and in files that are older than this topic.
    pub tents: Vec<Tent>,
    /// A station's signature, if there is one; whether it is right is for those to say who know the station.
    pub signature: Option<Signature>,
    /// The file is whole, footer and all. One that was cut, or is damaged behind its data, is not.
    pub complete: bool,
}

impl Recording {
    /// Reads a complete or cut recording. A cut one yields every valid message and `complete = false`.
    ///
    /// A file without samples reads as one with an empty list. The times of samples are finite and increase.
    ///
    /// # Errors
    /// When it is no recording, lacks metadata or documents, or is damaged before its end.
    pub fn read(source: impl Read) -> Result<Self, ReadError> {
        let contents = Contents::read(source)?;
        for name in [EXERCISE_ATTACHMENT, SCENE_ATTACHMENT] {
            if !contents.attachments.iter().any(|a| a.name == name) {
                return Err(ReadError::missing(format!("attachment {name}"), contents.absence()));
            }
        }
        let why = contents.absence();
        Ok(Self {
            session: contents
                .session
                .ok_or_else(|| ReadError::missing(format!("metadata {}", metadata::RECORD), why))?,
            attachments: contents.attachments,
            samples: contents.samples,
            events: contents.events,
            energies: contents.energies,
            tents: contents.tents,
            signature: contents.signature,
            complete: contents.complete,
        })
    }

    /// The attachment of a name.
    #[must_use]
    pub fn attachment(&self, name: &str) -> Option<&[u8]> {
        self.attachments.iter().find(|a| a.name == name).map(|a| a.data.as_slice())
    }
}

/// Whether a file is one of ours.
pub(crate) fn check_profile(profile: &str) -> Result<(), ReadError> {
    match profile {
        PROFILE => Ok(()),
        _ => Err(ReadError::NotARecording(format!("its profile is {profile:?}, allowed is {PROFILE:?}"))),
    }
}

/// What a file has declared so far.
#[derive(Default)]
pub(crate) struct Channels {
    schemas: BTreeMap<u16, String>,
    /// The topic of each channel, `None` for one that is not of this format.
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
            let allowed = topic.schema().name;
            if schema != allowed || channel.message_encoding != "protobuf" {
                let what = format!("topic {}", channel.topic);
                let why = format!("schema {schema} as {}, allowed is {allowed} as protobuf", channel.message_encoding);
                return Err(ReadError::missing(what, why));
            }
        }
        self.topics.insert(channel.id, topic);
        Ok(())
    }

    /// The topic of a message's channel; `None` for one that is not of this format.
    pub(crate) fn topic(&self, channel: u16) -> Result<Option<Topic>, String> {
        let topic = self.topics.get(&channel).copied();
        topic.ok_or_else(|| format!("a message of channel {channel}, which was not declared"))
    }
}

/// What a file holds, before asking whether it is all there.
#[derive(Default)]
pub(crate) struct Contents {
    pub(crate) session: Option<Session>,
    pub(crate) attachments: Vec<Attachment>,
    pub(crate) samples: Vec<Sample>,
    pub(crate) events: Vec<Event>,
    pub(crate) energies: Vec<Energy>,
    pub(crate) tents: Vec<Tent>,
    signature: Option<Signature>,
    pub(crate) complete: bool,
    /// Messages on every topic.
    pub(crate) messages: u64,
    channels: Channels,
}

impl Contents {
    pub(crate) fn read(source: impl Read) -> Result<Self, ReadError> {
        let mut contents = Self::default();
        let mut chunks = ChunkReader::new();
        let complete = walk(BufReader::new(source), |frame| match frame.opcode {
            op::CHUNK => chunks.walk(&frame, |inner| contents.take(&inner)),
            _ => contents.take(&frame),
        })?;
        contents.complete = complete;
        Ok(contents)
    }

    /// Why something is not there.
    fn absence(&self) -> &'static str {
        if self.complete { "not in the file" } else { "the file ends before it" }
    }

    fn take(&mut self, frame: &Frame<'_>) -> Result<(), ReadError> {
        if frame.opcode == op::ATTACHMENT {
            return self.take_attachment(attachment(frame.data).map_err(|e| frame.damaged(e))?);
        }
        match record(frame.opcode, frame.data).map_err(|e| frame.damaged(e))? {
            Record::Header(header) => check_profile(&header.profile),
            Record::Metadata(record) if record.name == metadata::RECORD => {
                let session = metadata::from_text(&record.metadata)?;
                once(self.session.replace(session).is_none(), &record.name)
            }
            Record::Metadata(record) if record.name == signature::RECORD => {
                let found = Signature::from_text(&record.metadata)?;
                once(self.signature.replace(found).is_none(), &record.name)
            }
            Record::Schema { header, .. } => {
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

    fn take_attachment(&mut self, found: mcap::Attachment<'_>) -> Result<(), ReadError> {
        once(self.attachments.iter().all(|a| a.name != found.name), &found.name)?;
        let mcap::Attachment { name, media_type, data, .. } = found;
        self.attachments.push(Attachment { name, media_type, data: data.into_owned() });
        Ok(())
    }

    fn take_message(&mut self, channel: u16, data: &[u8]) -> Result<(), String> {
        self.messages += 1;
        if self.samples.len().max(self.events.len() + self.energies.len() + self.tents.len()) >= MOST_MESSAGES {
            return Err(format!("more than {MOST_MESSAGES} messages"));
        }
        match self.channels.topic(channel)? {
            Some(Topic::Sample) => self.take_sample(decode::<NeedleSample>(data)?.into()),
            Some(Topic::Events) => {
                self.events.push(decode::<EventMessage>(data)?.try_into()?);
                Ok(())
            }
            Some(Topic::Energy) => {
                self.energies.push(decode::<EnergyLedger>(data)?.into());
                Ok(())
            }
            Some(Topic::Tent) => {
                self.tents.push(decode::<TissueTent>(data)?.into());
                Ok(())
            }
            _ => Ok(()),
        }
    }

    fn take_sample(&mut self, sample: Sample) -> Result<(), String> {
        let last_s = self.samples.last().map_or(f64::NEG_INFINITY, |last| last.t_s);
        if sample.t_s.is_finite() && sample.t_s > last_s {
            self.samples.push(sample);
            Ok(())
        } else {
            Err(format!("a sample at {} s after one at {last_s} s, allowed is later", sample.t_s))
        }
    }
}

fn decode<M: Message + Default>(data: &[u8]) -> Result<M, String> {
    M::decode(data).map_err(|error| error.to_string())
}

fn once(first: bool, name: &str) -> Result<(), ReadError> {
    if first { Ok(()) } else { Err(ReadError::missing(name, "there twice, allowed is once")) }
}
