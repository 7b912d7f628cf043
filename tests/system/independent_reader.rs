//! A recording is read by somebody else's reader. Fails when only our own code understands what our own code wrote: a
//! schema that does not describe its message, a topic missing, times that run backwards.

use tests::{python_ok, run_ok};

#[test]
fn the_mcap_packages_of_python_read_every_message() {
    let folder = tempfile::tempdir().expect("a folder");
    let recording = folder.path().join("attempt.mcap");
    let recording = recording.to_string_lossy();
    let exercise = tests::first_exercise();
    run_ok("stylet", &["simulate", &exercise, "--operator", "constant:10", "--seed", "1", "--out", &recording]);
    assert!(!python_ok(&["read_recording.py", &recording]).is_empty(), "the reader prints what it counted");
}
