//! Recordings that other programs have written anew, as MCAP allows: without compression, in other chunks, without chunks. It would fail
//! where such a file is called damaged, where it reads otherwise than the original, or where a recovery ends well and holds nothing.

use std::io::Cursor;

use mcap::records::{Record, op};
use mcap::write::NoSeek;
use mcap::{Compression, WriteOptions};
use recording::recover::recover;
use recording::{ReadError, Recording};

use crate::format::records;
use crate::support::{file, read};

/// The same messages, attachments and metadata as another program writes them.
fn rewritten(bytes: &[u8], options: WriteOptions) -> Vec<u8> {
    let mut out =
        options.profile("stylet").library("other").disable_seeking(true).create(NoSeek::new(Vec::new())).unwrap();
    for record in records(bytes) {
        match record {
            Record::Attachment { header, data, .. } => out
                .attach(&mcap::Attachment {
                    log_time: header.log_time,
                    create_time: header.create_time,
                    name: header.name,
                    media_type: header.media_type,
                    data,
                })
                .unwrap(),
            Record::Metadata(metadata) => out.write_metadata(&metadata).unwrap(),
            _ => {}
        }
    }
    for message in mcap::MessageStream::new(bytes).unwrap() {
        out.write(&message.unwrap()).unwrap();
    }
    out.finish().unwrap();
    out.into_inner().into_inner()
}

fn plain() -> WriteOptions {
    WriteOptions::new().compression(None)
}

/// The file with its first chunk's compression named otherwise; lengths are right.
fn naming(bytes: &[u8], compression: &str) -> Vec<u8> {
    let (at, header) = {
        let mut at = 8;
        while bytes[at] != op::CHUNK {
            at += 9 + u64::from_le_bytes(bytes[at + 1..at + 9].try_into().unwrap()) as usize;
        }
        (at, at + 9)
    };
    let length = u64::from_le_bytes(bytes[at + 1..at + 9].try_into().unwrap());
    let old = u32::from_le_bytes(bytes[header + 28..header + 32].try_into().unwrap()) as usize;
    let new = length - old as u64 + compression.len() as u64;
    [
        &bytes[..=at],
        &new.to_le_bytes(),
        &bytes[header..header + 28],
        &(compression.len() as u32).to_le_bytes(),
        compression.as_bytes(),
        &bytes[header + 32 + old..],
    ]
    .concat()
}

#[test]
fn chunks_without_compression_read_as_the_original() {
    let original = file(3000);
    for options in [
        plain(),
        plain().chunk_size(Some(4096)),
        plain().use_chunks(false),
        plain().calculate_chunk_crcs(false).calculate_data_section_crc(false),
        WriteOptions::new().compression(Some(Compression::Zstd)).chunk_size(Some(4096)),
    ] {
        let other = rewritten(&original, options.clone());
        let (one, other_read) = (read(&original), read(&other));
        assert_eq!(
            (&one.samples, &one.events, &one.session),
            (&other_read.samples, &other_read.events, &other_read.session),
            "{options:?}"
        );
        assert_eq!(one.attachments, other_read.attachments);
    }
}

#[test]
fn chunks_without_compression_are_recovered() {
    let original = file(3000);
    for options in [
        plain().chunk_size(Some(4096)),
        plain().chunk_size(Some(4096)).calculate_chunk_crcs(false).calculate_data_section_crc(false),
    ] {
        let other = rewritten(&original, options);
        let mut sink = Cursor::new(Vec::new());
        let found = recover(other.as_slice(), &mut sink).unwrap();
        assert_eq!(found.damage, "");
        assert_eq!(read(sink.get_ref()).samples, read(&original).samples);
        // Cut, and cut in the head as well.
        let cut = &other[..other.len() * 2 / 3];
        let found = recover(cut, Cursor::new(Vec::new())).unwrap();
        assert!(found.samples > 1000 && found.damage.contains("no end"), "{found:?}");
    }
}

#[test]
fn another_compression_is_named_and_nothing_is_left_behind() {
    for compression in ["lz4", "brotli"] {
        let other = naming(&file(1000), compression);
        let told = Recording::read(other.as_slice()).unwrap_err();
        assert!(matches!(&told, ReadError::Compression { compression: named, .. } if named == compression), "{told}");
        assert!(told.to_string().contains("allowed: zstd, or none"), "{told}");
        let told = recover(other.as_slice(), Cursor::new(Vec::new())).unwrap_err();
        assert!(matches!(told, ReadError::Compression { .. }), "{told}");
    }
}

#[test]
fn a_recovery_of_nothing_fails() {
    let bytes = file(1000);
    let first = bytes.windows(4).position(|window| window == b"zstd").unwrap() - 41;
    let told = recover(&bytes[..first], Cursor::new(Vec::new())).unwrap_err().to_string();
    assert!(told.contains("it contains no complete message"), "{told}");
}
