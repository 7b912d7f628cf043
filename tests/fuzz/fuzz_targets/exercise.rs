//! An exercise and its scene in TOML, as they come attached to a recording: two documents, parted by a zero byte.
#![no_main]

use libfuzzer_sys::fuzz_target;

fuzz_target!(|bytes: &[u8]| {
    let mut parts = bytes.splitn(2, |byte| *byte == 0);
    if let (Some(exercise), Some(scene)) = (parts.next(), parts.next()) {
        let _ = scene::ExerciseBundle::from_parts(exercise, scene, &[]);
    }
});
