//! A few kilobytes must not cost gigabytes: bombs of every kind are refused while they unpack, in words that name the limit.

use allocation_counter::measure;
use recording::session::EXERCISE_ATTACHMENT;
use recording::write::SceneDrawing;
use recording::{Attachment, Budget, Event, EventKind, ReadError, Recording, Sample, Tent, Writer};

use crate::support::{attachments, session};

/// A budget that a bomb is over quickly.
const SMALL: Budget = Budget { kept_bytes: 1 << 20, unpacked_bytes: 4 << 20, messages: 20_000 };

fn writer() -> Writer<Vec<u8>> {
    Writer::create(Vec::new(), &session(), &attachments(), &SceneDrawing::default()).unwrap()
}

fn event(text: &str) -> Event {
    Event {
        t_s: 1.0,
        kind: EventKind::Coaching,
        boundary: None,
        x_m: 0.0,
        position_m: [0.0; 3],
        force_n: 0.0,
        dissipated_j: 0.0,
        track: None,
        structure: None,
        text: text.to_owned(),
    }
}

/// What a bomb is refused with, and that it cost no more than its budget and the buffers of the reader.
fn refused(bomb: &[u8], budget: Budget) -> String {
    let mut read = None;
    let cost = measure(|| read = Some(Recording::read_within(bomb, budget)));
    let Some(Err(error @ (ReadError::Damaged { .. } | ReadError::Missing { .. }))) = read else {
        panic!("a bomb of {} bytes was read", bomb.len())
    };
    assert!(cost.bytes_max < 2 * budget.kept_bytes + (48 << 20), "{error}: {} bytes", cost.bytes_max);
    error.to_string()
}

#[test]
fn zeros_in_tents_are_refused() {
    let mut writer = writer();
    let zeros = vec![0.0; 100_000];
    for n in 0..60 {
        let tent = Tent { t_s: f64::from(n), tent_m: zeros.clone(), ..Tent::default() };
        writer.tent(&tent).unwrap();
    }
    let bomb = writer.finish().unwrap();
    assert!(bomb.len() < 100_000, "{} bytes", bomb.len());
    assert!(refused(&bomb, SMALL).contains("memory"));
    let unpacked = Budget { kept_bytes: 1 << 30, ..SMALL };
    assert!(refused(&bomb, Budget { unpacked_bytes: 1 << 20, ..unpacked }).contains("decompresses to more than"));
}

#[test]
fn words_without_end_are_refused() {
    let mut writer = writer();
    writer.event(&event(&" ".repeat(5000))).unwrap();
    assert!(refused(&writer.finish().unwrap(), SMALL).contains("5000 bytes of an event's text; allowed: at most 4096"));
}

#[test]
fn events_without_end_are_refused() {
    let mut writer = writer();
    (0..10_001).for_each(|_| writer.event(&event("")).unwrap());
    // Each event is a line of the log, too.
    let plenty = Budget { messages: 1_000_000, kept_bytes: 1 << 30, unpacked_bytes: 1 << 30 };
    assert!(refused(&writer.finish().unwrap(), plenty).contains("10001 events; allowed: at most 10000"));
}

#[test]
fn samples_without_end_are_refused() {
    let mut writer = writer();
    for n in 0..21_000 {
        writer.sample(&Sample { t_s: f64::from(n) * 1e-3, ..Sample::default() }).unwrap();
    }
    let bomb = writer.finish().unwrap();
    assert!(refused(&bomb, SMALL).contains("memory"));
    let plenty = Budget { kept_bytes: 1 << 30, unpacked_bytes: 1 << 30, ..SMALL };
    assert!(refused(&bomb, plenty).contains("more than 20000 messages"));
    assert!(Recording::read(bomb.as_slice()).is_ok(), "which an ordinary budget has room for");
}

#[test]
fn attachments_without_end_are_refused() {
    let one = |name: String, bytes| Attachment { name, media_type: String::new(), data: vec![0; bytes] };
    let with = |more: Vec<Attachment>| {
        let all = [attachments(), more].concat();
        Writer::create(Vec::new(), &session(), &all, &SceneDrawing::default()).unwrap().finish().unwrap()
    };
    let many = with((0..300).map(|n| one(format!("{n}"), 0)).collect());
    assert!(refused(&many, SMALL).contains("257 attachments; allowed: at most 256"));
    let long = with(vec![one("n".repeat(300), 0)]);
    assert!(refused(&long, SMALL).contains("300 bytes of an attachment's name; allowed: at most 255"));
    let large = with(vec![one("mesh".to_owned(), 3 << 19)]);
    assert!(refused(&large, SMALL).contains("memory"));
    assert!(Recording::read(large.as_slice()).unwrap().attachment(EXERCISE_ATTACHMENT).is_some());
}

/// What lies beside the fuzz targets, by name.
fn committed() -> Vec<(String, Vec<u8>)> {
    let folder = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../../tests/fuzz/bombs/recording");
    let files = std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
    files.map(|path| (path.display().to_string(), std::fs::read(&path).unwrap())).collect()
}

#[test]
fn every_bomb_that_is_fuzzed_with_keeps_to_its_budget() {
    let budget = Budget { kept_bytes: 8 << 20, unpacked_bytes: 32 << 20, messages: 100_000 };
    let bombs = committed();
    let mut refused = 0;
    for (name, bomb) in bombs {
        let mut read = None;
        let cost = measure(|| read = Some(Recording::read_within(bomb.as_slice(), budget).map(drop)));
        assert!(cost.bytes_max < 2 * budget.kept_bytes + (48 << 20), "{name}: {} bytes", cost.bytes_max);
        refused += usize::from(matches!(read, Some(Err(_))));
    }
    // The others are read without what is of no topic, or stands where nothing of the kind can.
    assert!(refused >= 11, "{refused} were refused");
}
