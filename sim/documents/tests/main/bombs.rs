//! Documents that are nested, long or repeated without end, as they lie beside the fuzz targets: each is refused in words, without a
//! stack or a machine running out.

use std::path::Path;

/// What lies in a folder of bombs, by name.
fn bombs(target: &str) -> Vec<(String, Vec<u8>)> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../tests/fuzz/bombs").join(target);
    let files = std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
    let read: Vec<_> = files.map(|path| (path.display().to_string(), std::fs::read(&path).unwrap())).collect();
    assert!(read.len() >= 3, "{target}: {} bombs", read.len());
    read
}

#[test]
fn every_document_that_is_a_bomb_is_refused() {
    for (name, bytes) in bombs("scene") {
        let text = String::from_utf8(bytes).unwrap();
        assert!(documents::load::read_scene_text(Path::new("bomb.toml"), &text).is_err(), "{name}");
    }
    for (name, bytes) in bombs("course") {
        assert!(documents::Curriculum::from_parts(&bytes, |_| None).is_err(), "{name}");
    }
    for (name, bytes) in bombs("instrument") {
        for kind in ["bomb.toml", "bomb.json"] {
            assert!(documents::Instrument::from_bytes(kind, &bytes).is_err(), "{name} as {kind}");
        }
    }
    for (name, bytes) in bombs("field_case") {
        let text = String::from_utf8(bytes).unwrap();
        assert!(documents::field_case::parse("bomb.json", &text).is_err(), "{name}");
    }
    for (name, bytes) in bombs("exercise") {
        let mut parts = bytes.splitn(3, |byte| *byte == 0);
        let (exercise, scene) = (parts.next().unwrap(), parts.next().unwrap());
        assert!(documents::ExerciseBundle::from_parts(exercise, scene, &[]).is_err(), "{name}");
    }
}
