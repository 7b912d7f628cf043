//! Cut, flipped and forged files. It would fail where damage passes for data, where a cut file is thrown away, or where
//! a false length is believed.

use std::cell::RefCell;
use std::collections::BTreeMap;
use std::io::Write;
use std::rc::Rc;

use mcap::records::{MessageHeader, op};
use mcap::write::Metadata;
use recording::{ReadError, Recording, Writer};

use crate::support::{attachments, drawing, file, read, sample, samples, session, writer};

/// Where each record of a file begins, with its opcode.
fn records(bytes: &[u8]) -> Vec<(usize, u8)> {
    let mut found = Vec::new();
    let mut at = 8;
    while at + 9 < bytes.len() {
        found.push((at, bytes[at]));
        at += 9 + u64::from_le_bytes(bytes[at + 1..at + 9].try_into().unwrap()) as usize;
    }
    found
}

fn start_of(bytes: &[u8], opcode: u8) -> usize {
    records(bytes).into_iter().find(|(_, o)| *o == opcode).unwrap().0
}

fn refused(bytes: &[u8]) -> ReadError {
    Recording::read(bytes).unwrap_err()
}

#[test]
fn an_empty_file_is_no_recording() {
    assert_eq!(refused(b"").to_string(), "not a recording: the file is empty");
}

#[test]
fn another_kind_of_file_is_no_recording() {
    let text = refused(b"t_s,x_m\n0,0\n");
    assert!(matches!(text, ReadError::NotARecording(_)), "{text}");
    let other = mcap::WriteOptions::new().profile("ros2").disable_seeking(true);
    let mut bytes = Vec::new();
    other.create(mcap::write::NoSeek::new(&mut bytes)).unwrap().finish().unwrap();
    assert!(refused(&bytes).to_string().contains(r#"profile is "ros2"; allowed: "stylet""#));
}

#[test]
fn a_cut_file_yields_every_whole_chunk() {
    let bytes = file(4000);
    let whole = samples(4000);
    let data_end = start_of(&bytes, op::DATA_END);
    for percent in 0..100 {
        let cut = bytes.len() * percent / 100;
        let Ok(recording) = Recording::read(&bytes[..cut]) else {
            assert!(cut < start_of(&bytes, op::CHUNK), "nothing from a cut at {percent} %");
            continue;
        };
        assert!(!recording.complete, "a cut at {percent} % passes as whole");
        assert_eq!(recording.samples, whole[..recording.samples.len()]);
        // The samples of 0.5 s are in each chunk, and chunks are of about the same size.
        let fraction = cut.min(data_end) as f64 / data_end as f64;
        let lost = 4000.0 * fraction - recording.samples.len() as f64;
        assert!(lost < 1000.0, "a cut at {percent} % loses {lost} ticks");
    }
}

/// A sink that outlives its writer, like a file that outlives its program.
#[derive(Clone, Default)]
struct Disk(Rc<RefCell<Vec<u8>>>);

impl Write for Disk {
    fn write(&mut self, bytes: &[u8]) -> std::io::Result<usize> {
        self.0.borrow_mut().write(bytes)
    }

    fn flush(&mut self) -> std::io::Result<()> {
        Ok(())
    }
}

#[test]
fn a_program_killed_at_any_moment_loses_less_than_a_second() {
    for ticks in [1, 499, 501, 999, 1500, 2345] {
        let disk = Disk::default();
        // Behind a buffer, so that what was not flushed is lost with the program.
        let buffered = std::io::BufWriter::with_capacity(1 << 20, disk.clone());
        let mut writer = Writer::create(buffered, &session(), &attachments(), &drawing()).unwrap();
        for n in 0..ticks {
            writer.sample(&sample(n)).unwrap();
        }
        std::mem::forget(writer);
        let recording = read(&disk.0.borrow());
        assert!(!recording.complete);
        assert!(ticks - (recording.samples.len() as u64) <= 500, "{} of {ticks}", recording.samples.len());
    }
}

#[test]
fn every_flipped_byte_is_noticed() {
    let mut bytes = file(40);
    let data_end = start_of(&bytes, op::DATA_END);
    assert!(read(&bytes).complete);
    let starts: Vec<usize> = records(&bytes).into_iter().map(|(start, _)| start).collect();
    for at in 0..bytes.len() {
        // Every byte of what comes before the chunks, of each record's beginning, of the end of the data and of the
        // file's end. What lies under one checksum, packed messages and the summary, byte by 17th byte.
        let near = starts.iter().any(|start| (*start..start + 60).contains(&at)) && at < data_end + 100;
        if !near && at > starts[4] && at % 17 != 0 && at + 40 < bytes.len() {
            continue;
        }
        for flip in [0x01, 0x80, 0xff] {
            bytes[at] ^= flip;
            let noticed = Recording::read(bytes.as_slice()).map_or(true, |recording| !recording.complete);
            assert!(noticed, "byte {at} of {} flipped by {flip:#x} passes", bytes.len());
            bytes[at] ^= flip;
        }
    }
}

#[test]
fn damage_in_the_data_is_an_error_that_names_its_place() {
    let bytes = file(2000);
    for (name, opcode) in [("attachment", op::ATTACHMENT), ("chunk", op::CHUNK)] {
        let start = start_of(&bytes, opcode);
        let mut flipped = bytes.clone();
        flipped[start + 70] ^= 1;
        match refused(&flipped) {
            ReadError::Damaged { offset, .. } => assert_eq!(offset, start as u64, "{name}"),
            other => panic!("{name}: {other}"),
        }
    }
}

#[test]
fn damage_behind_the_data_costs_no_sample() {
    let mut bytes = file(2000);
    let footer = start_of(&bytes, op::FOOTER);
    bytes[footer + 12] ^= 1;
    let recording = read(&bytes);
    assert_eq!(recording.samples.len(), 2000);
    assert!(!recording.complete);
}

#[test]
fn a_length_of_two_to_the_sixty_is_refused() {
    let bytes = file(100);
    let chunk = start_of(&bytes, op::CHUNK);
    // The record's length, the unpacked size and the packed size.
    for at in [chunk + 1, chunk + 9 + 16, chunk + 9 + 36] {
        let mut forged = bytes.clone();
        forged[at..at + 8].copy_from_slice(&(1u64 << 60).to_le_bytes());
        match refused(&forged) {
            ReadError::Damaged { offset, .. } => assert_eq!(offset, chunk as u64),
            other => panic!("{other}"),
        }
    }
    let attachment = start_of(&bytes, op::ATTACHMENT);
    let mut forged = bytes.clone();
    forged[attachment + 9 + 16..][..4].copy_from_slice(&u32::MAX.to_le_bytes());
    assert!(matches!(refused(&forged), ReadError::Damaged { offset, .. } if offset == attachment as u64));
}

/// A service that makes room for what a stranger's file claims can be stopped by a small file: the fuzzer found that the library does.
#[test]
fn false_text_length_is_rejected_before_it_allocates() {
    let bytes = file(100);
    let [header, metadata, chunk] = [op::HEADER, op::METADATA, op::CHUNK].map(|opcode| start_of(&bytes, opcode));
    let first_key = metadata + 9 + 4 + "stylet.session".len() + 4;
    for (record, at) in [(header, header + 9), (metadata, metadata + 9), (metadata, first_key), (chunk, chunk + 9 + 28)]
    {
        let mut forged = bytes.clone();
        forged[at..at + 4].copy_from_slice(&u32::MAX.to_le_bytes());
        let used = allocation_counter::measure(|| match refused(&forged) {
            ReadError::Damaged { offset, .. } => assert_eq!(offset, record as u64),
            other => panic!("{other}"),
        });
        assert!(used.bytes_max < 64 << 20, "{} bytes for a text of record {record}", used.bytes_max);
    }
}

#[test]
fn missing_documents_are_named() {
    for (kept, lost) in [(0, "scene.toml"), (1, "exercise.toml")] {
        let writer = Writer::create(Vec::new(), &session(), &attachments()[kept..=kept], &drawing()).unwrap();
        let error = refused(&writer.finish().unwrap()).to_string();
        assert_eq!(error, format!("attachment {lost}: missing from the file"));
    }
    let bytes = file(10);
    let error = refused(&bytes[..start_of(&bytes, op::METADATA)]).to_string();
    assert!(error.contains("the file ends before it"), "{error}");
}

type Forger = mcap::Writer<mcap::write::NoSeek<Vec<u8>>>;

/// A file that is sound as MCAP, with the metadata and a channel of the forger's.
fn forged(metadata: BTreeMap<String, String>, fill: impl FnOnce(&mut Forger)) -> Vec<u8> {
    let options = mcap::WriteOptions::new().profile("stylet").disable_seeking(true);
    let mut out = options.create(mcap::write::NoSeek::new(Vec::new())).unwrap();
    out.write_metadata(&Metadata { name: "stylet.session".to_owned(), metadata }).unwrap();
    fill(&mut out);
    out.finish().unwrap();
    out.into_inner().into_inner()
}

/// The metadata of a sound file.
fn sound_metadata() -> BTreeMap<String, String> {
    let bytes = writer().finish().unwrap();
    let (at, opcode) = records(&bytes)[1];
    let length = u64::from_le_bytes(bytes[at + 1..at + 9].try_into().unwrap()) as usize;
    match mcap::parse_record(opcode, &bytes[at + 9..at + 9 + length]).unwrap() {
        mcap::records::Record::Metadata(record) => record.metadata,
        other => panic!("{other:?}"),
    }
}

#[test]
fn a_wrong_schema_is_named() {
    let bytes = forged(sound_metadata(), |out| {
        let schema = out.add_schema("ros.Twist", "protobuf", b"").unwrap();
        out.add_channel(schema, "/needle/sample", "protobuf", &BTreeMap::new()).unwrap();
    });
    let error = refused(&bytes).to_string();
    assert!(error.contains("/needle/sample: schema ros.Twist"), "{error}");
    assert!(error.contains("allowed: stylet.NeedleSample"), "{error}");
}

#[test]
fn a_message_that_is_no_protobuf_is_damage() {
    let bytes = forged(sound_metadata(), |out| {
        let schema = out.add_schema("stylet.NeedleSample", "protobuf", b"").unwrap();
        let channel_id = out.add_channel(schema, "/needle/sample", "protobuf", &BTreeMap::new()).unwrap();
        let header = MessageHeader { channel_id, sequence: 0, log_time: 0, publish_time: 0 };
        out.write_to_known_channel(&header, &[0xff; 40]).unwrap();
    });
    assert!(matches!(refused(&bytes), ReadError::Damaged { .. }));
}

#[test]
fn metadata_that_is_not_what_it_should_be_is_named() {
    let cases = [
        ("session_id", "1234"),
        ("device_max_force_n", "-1"),
        ("tick_hz", "NaN"),
        ("tick_hz", "0"),
        ("seed", "-3"),
        ("started_at", "yesterday"),
        ("patient_thickness_mm", "[0.8, null]"),
    ];
    for (key, value) in cases {
        let mut metadata = sound_metadata();
        metadata.insert(key.to_owned(), value.to_owned());
        let error = refused(&forged(metadata, |_| {})).to_string();
        assert!(error.contains(&format!("{key} = {value}: only ")), "{error}");
    }
    let mut metadata = sound_metadata();
    metadata.remove("trainee");
    assert!(refused(&forged(metadata, |_| {})).to_string().contains("trainee"));
}

#[test]
fn time_that_does_not_increase_is_damage() {
    for (second, why) in [
        (0.0, "follows one at 0 s"),
        (-1.0, "allowed: 0 to"),
        (f64::NAN, "allowed: 0 to"),
        (f64::INFINITY, "allowed: 0 to"),
    ] {
        let mut writer = writer();
        writer.sample(&sample(0)).unwrap();
        writer.sample(&recording::Sample { t_s: second, ..sample(1) }).unwrap();
        let error = refused(&writer.finish().unwrap()).to_string();
        assert!(error.contains(why), "{error}");
    }
}

#[test]
fn a_document_that_is_not_the_one_named_is_refused() {
    for document in [0, 1] {
        let mut attachments = attachments();
        attachments[document].data.push(b' ');
        let writer =
            Writer::create(Vec::new(), &session(), &attachments, &recording::write::SceneDrawing::default()).unwrap();
        let error = refused(&writer.finish().unwrap()).to_string();
        assert!(error.contains(&attachments[document].name) && error.contains("SHA-256"), "{error}");
    }
}
