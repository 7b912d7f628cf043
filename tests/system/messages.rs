//! The messages in `sim/recording` are the ones that their schemas describe. Fails when `sim/recording/proto/stylet.proto` changes and
//! the generated types or descriptors do not. `STYLET_UPDATE_MESSAGES=1` writes them anew.

use std::fs;
use std::path::Path;

use prost::Message;
use prost_types::FileDescriptorSet;
use tests::root;

/// The schemas of viewers, as their authors compiled them.
const VIEWERS: [&str; 4] = ["FrameTransforms", "Log", "PoseInFrame", "SceneUpdate"];

/// Our schemas, compiled.
fn compile_ours() -> FileDescriptorSet {
    let proto = root().join("sim/recording/proto");
    protox::compile(["stylet.proto"], [proto]).expect("stylet.proto compiles")
}

/// Every file that a schema of viewers needs, once.
fn read_viewers() -> FileDescriptorSet {
    let mut all = FileDescriptorSet::default();
    for name in VIEWERS {
        let bytes = fs::read(root().join(format!("sim/recording/proto/foxglove/{name}.bin"))).expect("a schema");
        let set = FileDescriptorSet::decode(bytes.as_slice()).expect("a set of descriptors");
        let is_new = |file: &prost_types::FileDescriptorProto| all.file.iter().all(|known| known.name != file.name);
        let new: Vec<_> = set.file.into_iter().filter(is_new).collect();
        all.file.extend(new);
    }
    all
}

/// The Rust types of a package of messages.
fn generate(descriptors: FileDescriptorSet, package: &str) -> Vec<u8> {
    let folder = tempfile::tempdir().expect("a folder");
    prost_build::Config::new().out_dir(folder.path()).compile_fds(descriptors).expect("types");
    fs::read(folder.path().join(format!("{package}.rs"))).expect("the types of the package")
}

/// Compares a file of the tree with the bytes that it must have, or writes them.
#[track_caller]
fn holds(path: &str, bytes: &[u8]) {
    let file: &Path = &root().join(path);
    if std::env::var_os("STYLET_UPDATE_MESSAGES").is_some() {
        fs::write(file, bytes).expect("it can be written");
    }
    let kept = fs::read(file).expect("it is committed");
    assert!(kept == bytes, "{path} differs from its schema: STYLET_UPDATE_MESSAGES=1 writes it anew");
}

#[test]
fn generated_messages_are_those_of_their_schemas() {
    let mut ours = compile_ours();
    holds("sim/recording/src/generated/stylet.rs", &generate(ours.clone(), "stylet"));
    holds("sim/recording/src/generated/foxglove.rs", &generate(read_viewers(), "foxglove"));
    // Comments would travel in every recording, several times.
    for file in &mut ours.file {
        file.source_code_info = None;
    }
    holds("sim/recording/proto/stylet.bin", &ours.encode_to_vec());
}
