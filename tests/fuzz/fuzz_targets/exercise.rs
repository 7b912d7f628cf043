//! An exercise, its scene and a mesh, as they come attached to a recording: three files, parted by zero bytes. The mesh is there under a
//! name of either format.
#![no_main]

use libfuzzer_sys::fuzz_target;

fuzz_target!(|bytes: &[u8]| {
    let mut parts = bytes.splitn(3, |byte| *byte == 0);
    if let (Some(exercise), Some(scene)) = (parts.next(), parts.next()) {
        let mesh = parts.next().unwrap_or_default();
        let meshes = ["a.stl", "a.obj"].map(|name| (name.to_owned(), mesh.to_owned()));
        let _ = documents::ExerciseBundle::from_parts(exercise, scene, &meshes);
    }
});
