//! Iterates over the records of a file and of a chunk, in bounded memory and with their offsets in
//! the file.

use std::fmt::Display;
use std::io::{ErrorKind, Read};

use mcap::records::{Record, op};
use mcap::sans_io::{LinearReadEvent, LinearReader, LinearReaderOptions};
use mcap::{MAGIC, McapError};

use crate::error::ReadError;
use crate::topics::MOST_RECORD_BYTES;

/// Size of opcode and length before each record, in bytes.
pub(crate) const PREFIX_BYTES: usize = 9;
/// Bytes requested from the source at a time, so that a false length allocates no memory before the
/// data arrives.
const READ_BYTES: usize = 1 << 20;

/// A record: offset in the file, opcode, and the data after opcode and length.
pub(crate) struct RecordFrame<'a> {
    pub(crate) offset: u64,
    pub(crate) opcode: u8,
    pub(crate) data: &'a [u8],
}

impl RecordFrame<'_> {
    pub(crate) fn damaged(&self, why: impl Display) -> ReadError {
        ReadError::damaged(self.offset, why)
    }
}

/// Progress of the iteration through a file.
struct FileWalk {
    /// Bytes read.
    read: u64,
    /// Offset of the next record.
    next: u64,
    /// The last bytes read, as many as the closing magic has.
    tail: [u8; MAGIC.len()],
    /// Whether the data section has ended with a correct checksum.
    data_ended: bool,
}

/// Calls `visit` for every record of the data section; chunks are not unpacked. Returns `true` if
/// the file is complete to its last byte; `false` if it is truncated or damaged after its data.
pub(crate) fn walk_records(
    mut source: impl Read,
    mut visit: impl FnMut(RecordFrame<'_>) -> Result<(), ReadError>,
) -> Result<bool, ReadError> {
    let options = LinearReaderOptions::default()
        .with_emit_chunks(true)
        .with_validate_data_section_crc(true)
        .with_validate_summary_section_crc(true)
        .with_check_finishes_after_end_magic(true)
        .with_record_length_limit(MOST_RECORD_BYTES);
    let mut reader = LinearReader::new_with_options(options);
    let mut walk = FileWalk { read: 0, next: MAGIC.len() as u64, tail: [0; MAGIC.len()], data_ended: false };
    while let Some(event) = reader.next_event() {
        match event {
            Ok(LinearReadEvent::ReadRequest(wanted)) => {
                let count = walk.fill(&mut source, reader.insert(wanted.min(READ_BYTES)))?;
                reader.notify_read(count);
            }
            Ok(LinearReadEvent::Record { opcode: op::FOOTER, .. }) if !walk.data_ended => {
                return Err(ReadError::damaged(walk.next, "a footer before the end of the data"));
            }
            Ok(LinearReadEvent::Record { opcode, data }) => {
                // The reader requests no byte more than it needs, so the bytes read so far end with
                // this record.
                let offset = std::mem::replace(&mut walk.next, walk.read);
                walk.data_ended |= opcode == op::DATA_END;
                if !walk.data_ended {
                    visit(RecordFrame { offset, opcode, data })?;
                }
            }
            Err(_) if walk.data_ended => return Ok(false),
            Err(error) => return walk.stopped(error),
        }
    }
    Ok(true)
}

impl FileWalk {
    fn fill(&mut self, source: &mut impl Read, buffer: &mut [u8]) -> Result<usize, ReadError> {
        let count = loop {
            match source.read(buffer) {
                Err(error) if error.kind() == ErrorKind::Interrupted => {}
                result => break result?,
            }
        };
        self.read += count as u64;
        for &byte in buffer[..count].iter().rev().take(MAGIC.len()).rev() {
            self.tail.rotate_left(1);
            self.tail[MAGIC.len() - 1] = byte;
        }
        Ok(count)
    }

    /// Returns `false` if the file was truncated, otherwise the error.
    fn stopped(&self, error: McapError) -> Result<bool, ReadError> {
        match error {
            McapError::UnexpectedEof if self.read == 0 => Err(ReadError::NotARecording("the file is empty".to_owned())),
            McapError::UnexpectedEof if self.read < MAGIC.len() as u64 => {
                Err(ReadError::NotARecording(format!("it ends after {} bytes", self.read)))
            }
            McapError::BadMagic => {
                Err(ReadError::NotARecording("it does not begin with the eight bytes of an MCAP file".to_owned()))
            }
            // A truncated file lacks its end. If the closing magic is present, a length inside the
            // file is wrong.
            McapError::UnexpectedEof if self.tail == *MAGIC => {
                Err(ReadError::damaged(self.next, "the record's length reaches beyond the end of the file"))
            }
            McapError::UnexpectedEof => Ok(false),
            McapError::RecordTooLarge { len, .. } => {
                let why = format!("a record claims {len} bytes; allowed: at most {MOST_RECORD_BYTES}");
                Err(ReadError::damaged(self.next, why))
            }
            error => Err(broken_record(self.next, error)),
        }
    }
}

/// zstd's message when memory runs out, which does not mean that the file is damaged.
const NO_MEMORY: &str = "Allocation error : not enough memory";

/// Converts an error of the library at an offset: out of memory, or a damaged file.
fn broken_record(offset: u64, error: McapError) -> ReadError {
    match error {
        McapError::DecompressionError(why) if why == NO_MEMORY => ReadError::OutOfMemory,
        error => ReadError::damaged(offset, error),
    }
}

/// Unpacks chunks. Reuses its decompressor.
pub(crate) struct ChunkReader {
    reader: LinearReader,
}

impl ChunkReader {
    pub(crate) fn new() -> Self {
        let options = LinearReaderOptions::default()
            .with_skip_start_magic(true)
            .with_skip_end_magic(true)
            .with_prevalidate_chunk_crcs(true)
            .with_record_length_limit(MOST_RECORD_BYTES);
        Self { reader: LinearReader::new_with_options(options) }
    }

    /// Calls `visit` for each record of a chunk after verifying its checksum. The records get the
    /// chunk's offset.
    pub(crate) fn walk(
        &mut self,
        chunk: &RecordFrame<'_>,
        mut visit: impl FnMut(RecordFrame<'_>) -> Result<(), ReadError>,
    ) -> Result<(), ReadError> {
        let &RecordFrame { offset, data, .. } = chunk;
        check_chunk(data).map_err(|error| match error {
            McapError::UnsupportedCompression(compression) => ReadError::Compression { offset, compression },
            error => chunk.damaged(error),
        })?;
        let buffer = self.reader.insert(PREFIX_BYTES + data.len());
        buffer[0] = op::CHUNK;
        buffer[1..PREFIX_BYTES].copy_from_slice(&(data.len() as u64).to_le_bytes());
        buffer[PREFIX_BYTES..].copy_from_slice(data);
        self.reader.notify_read(PREFIX_BYTES + data.len());
        loop {
            let result = match self.reader.next_event() {
                Some(Ok(LinearReadEvent::Record { opcode, data })) => visit(RecordFrame { offset, opcode, data }),
                // The reader requests the next record: this chunk is done.
                None | Some(Ok(LinearReadEvent::ReadRequest(_))) => return Ok(()),
                Some(Err(error)) => Err(broken_record(offset, error)),
            };
            if result.is_err() {
                *self = Self::new();
                return result;
            }
        }
    }
}

/// Supported compressions; the empty name means uncompressed.
const COMPRESSIONS: [&str; 2] = ["zstd", ""];

/// Checks that a chunk's compression is supported and that it fills its record exactly; the library
/// would skip trailing bytes.
fn check_chunk(data: &[u8]) -> Result<(), McapError> {
    match parse_record(op::CHUNK, data)? {
        Record::Chunk { header, .. } if !COMPRESSIONS.contains(&header.compression.as_str()) => {
            Err(McapError::UnsupportedCompression(header.compression))
        }
        Record::Chunk { header, data: records } => {
            let header_bytes = chunk_header_bytes(&header.compression);
            let (inside, available) = (header_bytes + records.len(), data.len());
            if inside == available {
                Ok(())
            } else {
                Err(McapError::BadChunkLength { header: inside as u64, available: available as u64 })
            }
        }
        _ => Err(McapError::UnexpectedEoc),
    }
}

/// Returns the size of a chunk's header, after opcode and length, in bytes.
pub(crate) fn chunk_header_bytes(compression: &str) -> usize {
    // Start and end time, uncompressed size, checksum, the string with its length, compressed size.
    8 + 8 + 8 + 4 + 4 + compression.len() + 8
}

/// Maximum length of a compression's name, in bytes.
const LONGEST_COMPRESSION: usize = 16;

/// The fields of a chunk's header, and the part of the file that it claims.
pub(crate) struct ChunkSpan<'a> {
    /// Name of the compression.
    pub(crate) compression: &'a str,
    /// Size of its records, in bytes: decompressed and stored.
    pub(crate) unpacked: u64,
    pub(crate) stored: u64,
    /// Header and records.
    pub(crate) data: &'a [u8],
}

impl<'a> ChunkSpan<'a> {
    /// Reads the header after opcode and length. Checks the name first, because recovery tries
    /// every byte of a damaged range.
    pub(crate) fn read(bytes: &'a [u8]) -> Option<Self> {
        let number = |at: usize| Some(u64::from_le_bytes(*bytes.get(at..)?.first_chunk()?));
        let length = u32::from_le_bytes(*bytes.get(28..)?.first_chunk()?) as usize;
        let name = bytes.get(32..32 + Some(length).filter(|length| *length <= LONGEST_COMPRESSION)?)?;
        let compression = std::str::from_utf8(name).ok()?;
        let (unpacked, stored) = (number(16)?, number(32 + length)?);
        let whole = chunk_header_bytes(compression).checked_add(usize::try_from(stored).ok()?)?;
        Some(Self { compression, unpacked, stored, data: bytes.get(..whole)? })
    }

    /// Returns whether the compression is supported.
    pub(crate) fn is_known(&self) -> bool {
        COMPRESSIONS.contains(&self.compression)
    }
}

/// Parses a record of the data section. The library allocates memory for a text of the claimed
/// length, up to 4 GB, before it checks the length; false lengths are therefore refused first.
/// Index records do not belong in the data section and are not parsed.
pub(crate) fn parse_record(opcode: u8, data: &[u8]) -> Result<Record<'_>, McapError> {
    match opcode {
        op::CHUNK_INDEX | op::ATTACHMENT_INDEX | op::METADATA_INDEX => {
            Ok(Record::Unknown { opcode, data: data.into() })
        }
        _ if texts_fit(opcode, data).is_none() => Err(McapError::UnexpectedEof),
        _ => mcap::parse_record(opcode, data),
    }
}

/// Returns `Some` if every text of a record ends within it.
fn texts_fit(opcode: u8, data: &[u8]) -> Option<()> {
    // Bytes before the texts, number of texts, and whether a map of texts follows.
    let (before, texts, map) = match opcode {
        op::HEADER => (0, 2, false),
        op::SCHEMA => (2, 2, false),
        op::CHANNEL => (4, 2, true),
        op::ATTACHMENT => (16, 2, false),
        op::METADATA => (0, 1, true),
        op::CHUNK => (28, 1, false),
        _ => (0, 0, false),
    };
    let rest = behind_texts(data.get(before..)?, texts)?;
    if map {
        let (length, mut entries) = rest.split_first_chunk::<4>()?;
        let behind = entries.len().checked_sub(usize::try_from(u32::from_le_bytes(*length)).ok()?)?;
        while entries.len() > behind {
            entries = behind_texts(entries, 2)?;
        }
    }
    Some(())
}

/// Skips texts with length prefixes and returns the remaining data.
fn behind_texts(mut data: &[u8], texts: usize) -> Option<&[u8]> {
    for _ in 0..texts {
        let (length, behind) = data.split_first_chunk::<4>()?;
        data = behind.get(usize::try_from(u32::from_le_bytes(*length)).ok()?..)?;
    }
    Some(data)
}

/// Parses an attachment and verifies its checksum.
pub(crate) fn parse_attachment(data: &[u8]) -> Result<mcap::Attachment<'_>, McapError> {
    // The library assumes that four bytes follow the two times, the two strings and the content.
    if !attachment_fits(data).unwrap_or(false) {
        return Err(McapError::BadAttachmentLength { header: 0, available: data.len() as u64 });
    }
    match parse_record(op::ATTACHMENT, data)? {
        Record::Attachment { header, data, .. } => Ok(mcap::Attachment {
            log_time: header.log_time,
            create_time: header.create_time,
            name: header.name,
            media_type: header.media_type,
            data,
        }),
        _ => Err(McapError::UnexpectedEof),
    }
}

fn attachment_fits(data: &[u8]) -> Option<bool> {
    let rest = behind_texts(data.get(16..)?, 2)?;
    let (length, behind) = rest.split_first_chunk::<8>()?;
    Some(u64::from_le_bytes(*length).checked_add(4)? == behind.len() as u64)
}
