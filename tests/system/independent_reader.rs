//! A recording is read by somebody else's reader. Fails when only our own code understands what our own code wrote: a
//! schema that does not describe its message, a topic missing, times that run backwards; and when the layouts for viewers
//! name a topic, a field or a frame that is not there.

use tests::{python_ok, run_ok};

/// Runs a script of `tests/python` on a recording of the first exercise, made for it.
fn run_on_a_recording(script: &str) {
    let folder = tempfile::tempdir().expect("a folder");
    let recording = folder.path().join("attempt.mcap");
    let recording = recording.to_string_lossy();
    let exercise = tests::first_exercise();
    run_ok("stylet", &["simulate", &exercise, "--operator", "constant:10", "--seed", "1", "--out", &recording]);
    assert!(!python_ok(&[script, &recording]).is_empty(), "the script says what it found");
}

#[test]
fn the_mcap_packages_of_python_read_every_message() {
    run_on_a_recording("read_recording.py");
}

#[test]
fn what_is_shipped_for_viewers_names_what_is_there() {
    run_on_a_recording("check_viewers.py");
}
