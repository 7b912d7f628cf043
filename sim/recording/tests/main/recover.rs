//! Everything valid comes out of a damaged file, into a whole one. It would fail where a message is lost that the
//! reader still sees, or where one bad byte takes its neighbours along.

use std::io::Cursor;

use mcap::records::op;
use recording::recover::{Recovered, recover};
use recording::{Recording, Sample};

use crate::support::{attachments, file, read, sample, samples, session};

fn recovered(bytes: &[u8]) -> (Recovered, Recording) {
    let mut sink = Cursor::new(Vec::new());
    let found = recover(bytes, &mut sink).unwrap();
    let recording = read(sink.get_ref());
    assert!(recording.complete);
    assert_eq!(recording.session, session());
    assert_eq!(recording.samples.len() as u64, found.samples);
    assert_eq!(found.bytes_read, bytes.len() as u64);
    (found, recording)
}

/// First byte and length of each chunk's record.
fn chunks(bytes: &[u8]) -> Vec<(usize, usize)> {
    let mut found = Vec::new();
    let mut at = 8;
    while bytes[at] != op::DATA_END {
        let length = 9 + u64::from_le_bytes(bytes[at + 1..at + 9].try_into().unwrap()) as usize;
        if bytes[at] == op::CHUNK {
            found.push((at, length));
        }
        at += length;
    }
    found
}

#[test]
fn a_whole_file_is_copied_without_complaint() {
    let bytes = file(2000);
    let (found, recording) = recovered(&bytes);
    assert_eq!(found.damage, "");
    assert_eq!(recording, read(&bytes));
}

#[test]
fn a_cut_file_yields_what_the_reader_sees() {
    let bytes = file(3000);
    for tenth in 1..10 {
        let cut = &bytes[..bytes.len() * tenth / 10];
        let (found, recording) = recovered(cut);
        let seen = read(cut);
        assert_eq!(recording.samples, seen.samples);
        assert_eq!((recording.events, recording.energies), (seen.events, seen.energies));
        assert!(found.damage.contains("no end within"), "{}", found.damage);
    }
}

#[test]
fn a_damaged_chunk_costs_only_itself() {
    let bytes = file(3000);
    let (start, length) = chunks(&bytes)[3];
    // In its data, in its checksum, in its opcode.
    for at in [start + length / 2, start + 9 + 24, start] {
        let mut damaged = bytes.clone();
        damaged[at] ^= 0xff;
        let (found, recording) = recovered(&damaged);
        // The first chunk holds the declarations, the next ones half a second each.
        let expected: Vec<Sample> = (0..1000).chain(1500..3000).map(sample).collect();
        assert_eq!(recording.samples, expected);
        assert!(found.damage.contains(&format!("damaged at byte {start}")), "{}", found.damage);
    }
}

#[test]
fn a_false_length_costs_nothing() {
    let bytes = file(3000);
    let (start, _) = chunks(&bytes)[3];
    for length in [0, 1 << 20, 1 << 60] {
        let mut damaged = bytes.clone();
        damaged[start + 1..start + 9].copy_from_slice(&u64::to_le_bytes(length));
        assert_eq!(recovered(&damaged).1.samples, samples(3000));
    }
}

#[test]
fn a_damaged_index_costs_nothing() {
    let bytes = file(3000);
    let (start, length) = chunks(&bytes)[3];
    for at in 0..40 {
        let mut damaged = bytes.clone();
        damaged[start + length + at] ^= 0x10;
        let (found, recording) = recovered(&damaged);
        assert_eq!(recording.samples, samples(3000));
        assert_ne!(found.damage, "");
    }
}

#[test]
fn the_channels_are_known_without_their_declaration() {
    let bytes = file(1000);
    let (start, length) = chunks(&bytes)[0];
    let mut damaged = bytes.clone();
    damaged[start + length - 10] ^= 1;
    assert_eq!(recovered(&damaged).1.samples, samples(1000));
}

#[test]
fn a_lost_attachment_does_not_cost_the_samples() {
    let mut bytes = file(1000);
    let name = bytes.windows(10).position(|w| w == b"scene.toml").unwrap();
    bytes[name] ^= 1;
    let mut sink = Cursor::new(Vec::new());
    let found = recover(bytes.as_slice(), &mut sink).unwrap();
    assert_eq!(found.samples, 1000);
    let error = Recording::read(sink.get_ref().as_slice()).unwrap_err().to_string();
    assert_eq!(error, "attachment scene.toml: missing from the file");
}

#[test]
fn a_magic_number_is_not_needed() {
    let mut bytes = file(600);
    bytes[..8].fill(0);
    assert_eq!(recovered(&bytes).1.attachments, attachments());
}

#[test]
fn nothing_comes_of_nothing() {
    for (bytes, why) in [(&b""[..], "empty"), (&[7; 5000][..], "stylet.session"), (&file(10)[..60], "stylet.session")] {
        let error = recover(bytes, Cursor::new(Vec::new())).unwrap_err().to_string();
        assert!(error.contains(why), "{error}");
    }
}

#[test]
fn a_stretch_that_was_written_twice_is_found_once() {
    let bytes = file(3000);
    for (start, length) in [chunks(&bytes)[1], chunks(&bytes)[3]] {
        let repeated = [&bytes[..start + length], &bytes[start..]].concat();
        let (found, recording) = recovered(&repeated);
        assert_eq!(recording.samples, read(&bytes).samples);
        assert!(found.damage.contains(&format!("byte {}", start + length)), "{}", found.damage);
    }
}
