//! Wrong calls: exit 2, one line that names what was wrong, and no trace of a panic. Would fail if clap's own
//! several-line explanations reached the user, or if a window opened on what cannot be shown.

use std::process::Stdio;

use crate::{program, stylet};

/// An exercise as it is named from the package's folder.
const EXERCISE: &str = "../../curricula/lower-back-basics/1-feel-the-layers.toml";

#[test]
fn help_and_version_end_with_0() {
    for args in [&["--help"][..], &["--version"], &["force", "--help"], &["simulate", "--help"]] {
        let run = stylet(args).ends(0);
        assert!(!run.stdout.is_empty());
        assert_eq!(run.stderr, "");
    }
}

#[test]
fn a_wrong_call_is_one_line() {
    stylet(&[]).refused(&["subcommand", "--help"]);
    stylet(&["force"]).refused(&["--trajectory"]);
    stylet(&["force", "a.json", "--trajectory", "t.csv", "--frobnicate"]).refused(&["--frobnicate"]);
    stylet(&["schema", "poem"]).refused(&["poem", "scene", "exercise", "curriculum"]);
}

#[test]
fn numbers_out_of_range_name_value_and_range() {
    let simulate = ["simulate", "e.toml", "--out", "r.mcap"];
    let with = |more: &[&'static str]| stylet(&[&simulate, more].concat());
    with(&["--tick-hz", "5"]).refused(&["--tick-hz", "5", "100..=10000"]);
    with(&["--operator", "constant:NaN"]).refused(&["--operator", "NaN mm/s", "0.01 mm/s to 1000 mm/s"]);
    with(&["--operator", "constant:-2"]).refused(&["-2 mm/s"]);
    with(&["--operator", "surgeon"]).refused(&["surgeon", "novice, intermediate, expert, constant:MM_S"]);
    with(&["--session-id", "7"]).refused(&["--session-id"]);
    with(&["--started-at", "yesterday"]).refused(&["--started-at", "RFC 3339"]);
    with(&["--trainee", "Ada Lovelace"]).refused(&["--trainee", "pseudonym"]);
    with(&["--seed", "-1"]).refused(&["-1"]);
}

#[test]
fn a_wrong_call_of_the_window_is_refused_before_there_is_one() {
    let play = |arguments: &[&str]| stylet(&[&["play"], arguments].concat());
    play(&[]).refused(&["EXERCISE.toml"]);
    play(&["nothing-there.toml"]).refused(&["nothing-there.toml"]);
    play(&[EXERCISE, "--device", "joystick"]).refused(&["joystick", "auto, mouse, gamepad, openhaptics, inverse3"]);
    play(&[EXERCISE, "--device", "operator:surgeon"]).refused(&["surgeon", "novice, intermediate, expert"]);
    play(&[EXERCISE, "--trainee", "Ada Lovelace"]).refused(&["--trainee", "pseudonym"]);
    stylet(&["replay", "nothing-there.mcap"]).refused(&["nothing-there.mcap"]);
}

#[test]
fn a_reader_that_leaves_is_no_failure() {
    let mut child = program().arg("--help").stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().expect("it starts");
    drop(child.stdout.take());
    let output = child.wait_with_output().expect("it ends");
    assert_eq!(output.status.code(), Some(0));
    assert!(output.stderr.is_empty());
}
