//! Recovers every valid message from a truncated or damaged file.
//!
//! A message is valid if its chunk's checksum is correct. Damaged ranges are skipped: the search
//! continues byte by byte to the next record with a correct checksum, regardless of the lengths
//! claimed in between.

use std::collections::{BTreeMap, BTreeSet};
use std::io::{Read, Seek, Write};

use mcap::records::{MessageHeader, Record, op};
use mcap::write::{Metadata, NoSeek};
use mcap::{MAGIC, McapError};

use crate::error::ReadError;
use crate::frames::{ChunkReader, ChunkSpan, PREFIX_BYTES, RecordFrame, parse_attachment, parse_record};
use crate::read::Contents;
use crate::topics::{Topic, declare};
use crate::{metadata, write};

/// The result of a recovery.
#[derive(Clone, Debug, PartialEq, Eq, serde::Serialize)]
pub struct Recovered {
    /// Number of messages written.
    pub messages: u64,
    /// Number of servo ticks among them.
    pub samples: u64,
    /// Size of the input, in bytes.
    pub bytes_read: u64,
    /// Description of the damage; empty if the input was complete.
    pub damage: String,
}

/// Copies every valid record of `source` into a new, complete file, and reopens it as a check.
///
/// A description of the damage is also stored in the new file, as metadata `stylet.recovery`.
///
/// # Errors
/// If the metadata cannot be read, or on an I/O error.
pub fn recover<W: Read + Write + Seek>(mut source: impl Read, sink: W) -> Result<Recovered, ReadError> {
    // Read the whole file into memory: finding the next good chunk requires trying every byte after
    // a bad one.
    let mut bytes = Vec::new();
    source.read_to_end(&mut bytes)?;
    let found = find_records(&bytes)?;
    let damage = found.damage(&bytes);
    let mut copy = Copy::new(sink)?;
    for frame in found.frames.iter().filter(|f| f.opcode != op::CHUNK) {
        copy.document(frame)?;
    }
    if !damage.is_empty() {
        copy.note(&damage)?;
    }
    copy.messages(&found.frames)?;
    let (messages, mut sink) = copy.finish()?;
    sink.rewind()?;
    let reopened = Contents::read(&mut sink)?;
    if reopened.session.is_none() {
        return Err(ReadError::missing(format!("metadata {}", metadata::RECORD), "not found"));
    }
    if !reopened.complete || reopened.messages != messages {
        let why = format!("the recovered file reads back {} of {messages} messages", reopened.messages);
        return Err(ReadError::NotARecording(why));
    }
    if messages == 0 {
        return Err(ReadError::NotARecording(format!("it contains no complete message: {damage}")));
    }
    let samples = reopened.samples.len() as u64;
    Ok(Recovered { messages, samples, bytes_read: bytes.len() as u64, damage })
}

/// The valid records of a file that can be copied, and the gaps between them.
#[derive(Default)]
pub(crate) struct FoundRecords<'a> {
    pub(crate) frames: Vec<RecordFrame<'a>>,
    /// Offset and length of each range without a valid record.
    gaps: Vec<(u64, u64)>,
}

pub(crate) fn find_records(bytes: &[u8]) -> Result<FoundRecords<'_>, ReadError> {
    if bytes.is_empty() {
        return Err(ReadError::NotARecording("the file is empty".to_owned()));
    }
    let mut found = FoundRecords::default();
    let (mut chunks, mut seen) = (ChunkReader::new(), BTreeSet::new());
    let mut at = if bytes.starts_with(MAGIC) { MAGIC.len() } else { 0 };
    while at < bytes.len() {
        match good_record(&bytes[at..], at as u64, &mut chunks) {
            Some((frame, _)) if frame.opcode == op::DATA_END => break,
            // A duplicated range: its contents have been found already.
            Some((frame, length)) if frame.opcode == op::CHUNK && !seen.insert(frame.data) => {
                found.gaps.push((at as u64, length as u64));
                at += length;
            }
            Some((frame, length)) => {
                if matches!(frame.opcode, op::CHUNK | op::ATTACHMENT | op::METADATA) {
                    found.frames.push(frame);
                }
                at += length;
            }
            None => {
                refuse_unknown_compression(&bytes[at..], at as u64)?;
                found.skip(at as u64);
                at += 1;
            }
        }
    }
    Ok(found)
}

/// Refuses a chunk that is consistent in its lengths but uses an unsupported compression: it is not
/// damaged, and skipping it would lose its contents.
fn refuse_unknown_compression(bytes: &[u8], offset: u64) -> Result<(), ReadError> {
    let span = bytes.get(PREFIX_BYTES..).filter(|_| bytes[0] == op::CHUNK).and_then(ChunkSpan::read);
    match span.filter(|span| !span.is_known() && bytes[1..PREFIX_BYTES] == (span.data.len() as u64).to_le_bytes()) {
        Some(span) => Err(ReadError::Compression { offset, compression: span.compression.to_owned() }),
        None => Ok(()),
    }
}

/// Returns the valid record that begins here, if there is one, with its length.
fn good_record<'a>(bytes: &'a [u8], offset: u64, chunks: &mut ChunkReader) -> Option<(RecordFrame<'a>, usize)> {
    let (&opcode, rest) = bytes.split_first()?;
    let (length, rest) = rest.split_first_chunk::<8>()?;
    let claimed = u64::from_le_bytes(*length);
    let data = usize::try_from(claimed).ok().and_then(|length| rest.get(..length));
    let good = match opcode {
        // The header inside the chunk contains its length, and the checksum confirms it.
        op::CHUNK => {
            let ChunkSpan { data, unpacked, stored, compression } =
                ChunkSpan::read(rest).filter(ChunkSpan::is_known)?;
            // An uncompressed chunk may have no checksum: then its lengths must agree.
            if compression.is_empty() && (unpacked != stored || claimed != data.len() as u64) {
                return None;
            }
            let frame = RecordFrame { offset, opcode, data };
            return chunks.walk(&frame, |_| Ok(())).is_ok().then_some((frame, PREFIX_BYTES + data.len()));
        }
        op::ATTACHMENT => parse_attachment(data?).is_ok(),
        op::METADATA => parse_record(opcode, data?).is_ok(),
        // These two have no checksum and little structure: after damage, any data might look like
        // one.
        op::HEADER => offset == MAGIC.len() as u64,
        op::MESSAGE_INDEX => index_fits(data?),
        op::DATA_END => data?.len() == 4,
        _ => false,
    };
    let data = data?;
    good.then_some((RecordFrame { offset, opcode, data }, PREFIX_BYTES + data.len()))
}

/// Returns whether the entries of a message index fill it exactly: channel, length of the entries,
/// entries.
fn index_fits(data: &[u8]) -> bool {
    let length = data.get(2..6).and_then(|bytes| bytes.first_chunk::<4>());
    length.is_some_and(|length| u64::from(u32::from_le_bytes(*length)) + 6 == data.len() as u64)
}

impl FoundRecords<'_> {
    fn skip(&mut self, at: u64) {
        match self.gaps.last_mut() {
            Some((start, length)) if *start + *length == at => *length += 1,
            _ => self.gaps.push((at, 1)),
        }
    }

    /// Describes the damage in words.
    fn damage(&self, bytes: &[u8]) -> String {
        let gaps = self.gaps.iter().map(|(start, length)| format!("{length} bytes damaged at byte {start}"));
        let mut words: Vec<String> = gaps.collect();
        match Contents::read(bytes) {
            Ok(contents) if contents.complete => {}
            Ok(_) => words.push(format!("no end within {} bytes", bytes.len())),
            Err(error) => words.push(error.to_string()),
        }
        words.join("; ")
    }
}

/// A new file that is being filled from an old one.
pub(crate) struct Copy<W: Write> {
    out: mcap::Writer<NoSeek<W>>,
    /// Schemas of the old file: name, encoding, content.
    schemas: BTreeMap<u16, (String, String, Vec<u8>)>,
    /// The new channel of each old one.
    channels: BTreeMap<u16, u16>,
    messages: u64,
    /// Events to add, the latest first: time in Unix ns, and the message.
    pub(crate) remarks: Vec<(u64, Vec<u8>)>,
}

/// Converts an error of the library to an I/O error: while writing, it is caused by the sink.
fn disk_failure(error: McapError) -> ReadError {
    match error {
        McapError::Io(error) => ReadError::Io(error),
        other => ReadError::Io(std::io::Error::other(other)),
    }
}

impl<W: Write> Copy<W> {
    pub(crate) fn new(sink: W) -> Result<Self, ReadError> {
        let out = write::open(sink).map_err(disk_failure)?;
        Ok(Self { out, schemas: BTreeMap::new(), channels: BTreeMap::new(), messages: 0, remarks: Vec::new() })
    }

    /// Copies metadata or an attachment.
    pub(crate) fn document(&mut self, frame: &RecordFrame<'_>) -> Result<(), ReadError> {
        if frame.opcode == op::ATTACHMENT {
            let attachment = parse_attachment(frame.data).map_err(|e| frame.damaged(e))?;
            return self.out.attach(&attachment).map_err(disk_failure);
        }
        match parse_record(frame.opcode, frame.data).map_err(|e| frame.damaged(e))? {
            Record::Metadata(metadata) => self.out.write_metadata(&metadata).map_err(disk_failure),
            _ => Ok(()),
        }
    }

    fn note(&mut self, damage: &str) -> Result<(), ReadError> {
        let metadata = BTreeMap::from([("damage".to_owned(), damage.to_owned())]);
        self.out.write_metadata(&Metadata { name: "stylet.recovery".to_owned(), metadata }).map_err(disk_failure)
    }

    /// Copies the messages of every chunk.
    pub(crate) fn messages(&mut self, frames: &[RecordFrame<'_>]) -> Result<(), ReadError> {
        // Channels are declared once, in the first chunk. If that is lost, their fixed order
        // identifies them.
        for (channel, topic) in (1..).zip(Topic::ALL) {
            self.channels.insert(channel, declare(&mut self.out, topic).map_err(disk_failure)?);
        }
        let mut chunks = ChunkReader::new();
        for chunk in frames.iter().filter(|frame| frame.opcode == op::CHUNK) {
            chunks.walk(chunk, |inner| self.record(&inner))?;
        }
        Ok(())
    }

    fn record(&mut self, frame: &RecordFrame<'_>) -> Result<(), ReadError> {
        match parse_record(frame.opcode, frame.data).map_err(|e| frame.damaged(e))? {
            Record::Schema { header, data } => {
                self.schemas.insert(header.id, (header.name, header.encoding, data.into_owned()));
            }
            Record::Channel(channel) => {
                let (name, encoding, data) = self
                    .schemas
                    .get(&channel.schema_id)
                    .ok_or_else(|| frame.damaged(format!("topic {} without a schema", channel.topic)))?;
                let schema = self.out.add_schema(name, encoding, data).map_err(disk_failure)?;
                let to = self.out.add_channel(schema, &channel.topic, &channel.message_encoding, &channel.metadata);
                self.channels.insert(channel.id, to.map_err(disk_failure)?);
            }
            Record::Message { header, data } => {
                self.add_remarks(header.log_time)?;
                if let Some(&channel_id) = self.channels.get(&header.channel_id) {
                    let header = MessageHeader { channel_id, ..header };
                    self.out.write_to_known_channel(&header, &data).map_err(disk_failure)?;
                    self.messages += 1;
                }
            }
            _ => {}
        }
        Ok(())
    }

    /// Adds the remarks that are due.
    fn add_remarks(&mut self, until_ns: u64) -> Result<(), ReadError> {
        while let Some((log_time, data)) = self.remarks.pop_if(|(at_ns, _)| *at_ns <= until_ns) {
            let channel_id = declare(&mut self.out, Topic::Events).map_err(disk_failure)?;
            let header = MessageHeader { channel_id, sequence: 0, log_time, publish_time: log_time };
            self.out.write_to_known_channel(&header, &data).map_err(disk_failure)?;
            self.messages += 1;
        }
        Ok(())
    }

    pub(crate) fn finish(mut self) -> Result<(u64, W), ReadError> {
        self.add_remarks(u64::MAX)?;
        self.out.finish().map_err(disk_failure)?;
        let mut sink = self.out.into_inner().into_inner();
        sink.flush()?;
        Ok((self.messages, sink))
    }
}
