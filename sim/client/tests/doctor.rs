//! `stylet doctor`: it looks, names what it found with units, and fails only for what would lose an attempt. Of a haptic
//! device it says which thing is missing, and what to do.

use std::thread;

use inverse_service::{Script, Service, State, first};
use serde_json::Value;

use crate::stand_in::{StandIn, answer};
use crate::{Run, program, run, stylet, text};

#[test]
fn it_reports_timer_priority_processor_and_disk() {
    let folder = tempfile::TempDir::new().expect("a folder");
    let service = StandIn::answering(&[answer("200 OK", "text/plain", "ok")]);
    let run = stylet(&["doctor", "--json", "--recordings", text(folder.path()), "--server", &service.address]).ends(0);
    let findings = run.json()["findings"].clone();
    for subject in [
        "processor",
        "timer",
        "real-time priority",
        "disk space",
        "disk speed",
        "OpenHaptics",
        "Inverse3",
        "gamepads",
        "graphics",
        "server",
    ] {
        let known = findings.as_array().expect("a list").iter().any(|finding| finding["subject"] == subject);
        assert!(known, "{subject} is missing in {findings}");
    }
    assert!(service.requests()[0].head.starts_with("get /healthz "));
    assert_eq!(std::fs::read_dir(folder.path()).expect("a folder").count(), 0, "it leaves nothing behind");
}

#[test]
fn a_folder_and_a_server_that_are_not_there_are_problems() {
    let run = stylet(&["doctor", "--recordings", "/nowhere/at/all", "--server", "http://127.0.0.1:9"]).ends(1);
    for part in ["PROBLEM  disk speed", "/nowhere/at/all", "PROBLEM  server", "http://127.0.0.1:9"] {
        assert!(run.stdout.contains(part), "'{part}' is missing in: {}", run.stdout);
    }
}

/// What was found of a subject: level, words, advice.
#[track_caller]
fn finding(run: &Run, subject: &str) -> (String, String, String) {
    let findings = run.json()["findings"].clone();
    let found = findings.as_array().expect("a list").iter().find(|finding| finding["subject"] == subject).cloned();
    let found = found.expect("a finding of that subject");
    let word = |key: &str| found[key].as_str().map(str::to_owned).unwrap_or_default();
    (word("level"), word("found"), word("advice"))
}

/// What is found of an OpenHaptics device that behaves as a word of the stand-in's script says.
fn openhaptics(library: &str, script: &str) -> (String, String, String) {
    let folder = tempfile::TempDir::new().expect("a folder");
    let mut command = program();
    command.args(["doctor", "--json", "--recordings", text(folder.path()), "--openhaptics", library]);
    command.args(["--inverse3", "ws://127.0.0.1:9"]).env(libhd::ENVIRONMENT, script);
    finding(&run(&mut command).ends(0), "OpenHaptics")
}

#[test]
fn it_names_what_is_wrong_with_an_openhaptics_device() {
    let good = libhd::StandIn::new(libhd::Script::default());
    let library = text(&good.path()).to_owned();
    let (_old, lacking) = libhd::lacking("hdUnschedule");
    let cases = [
        // How many frames a busy machine makes of a second is its own affair, and so the level is.
        (&*library, "", "", "Touch 40720700147: 3.3 N (0.88 N continuous), 400 N/m", ""),
        (&*library, "no-device", "warning", "device not found", "connect"),
        (&*library, "no-licence", "warning", "licence refused", "licence manager"),
        (&*library, "not-calibrated", "warning", "calibration needed", "inkwell"),
        (&*library, "refuses-force", "warning", "force refused", "power supply"),
        (text(&lacking), "", "warning", "wrong driver version", "install"),
        ("/nowhere/libHD.so", "", "warning", "library not found", "install"),
    ];
    let runs = |(library, script, level, words, advice): (&str, &str, &str, &str, &str)| {
        let found = openhaptics(library, script);
        assert!(found.0.contains(level) && found.1.contains(words) && found.2.contains(advice), "{script}: {found:?}");
    };
    thread::scope(|scope| cases.into_iter().for_each(|case| drop(scope.spawn(move || runs(case)))));
}

/// What is found of an Inverse3 at an address.
fn inverse3(url: &str) -> (String, String, String) {
    let folder = tempfile::TempDir::new().expect("a folder");
    let run = stylet(&["doctor", "--json", "--recordings", text(folder.path()), "--inverse3", url]).ends(0);
    finding(&run, "Inverse3")
}

#[test]
fn it_names_what_is_wrong_with_an_inverse3() {
    let cold = first(&State { power_supply: false, ..State::default() });
    let nothing = Value::from(serde_json::Map::new()).to_string();
    let cases = [
        (Script::default(), "", "service 3.5.0", ""),
        (Script { version: Some("2.1.0"), ..Script::default() }, "warning", "wrong service version: 2.1.0", "update"),
        (Script { first: Some(cold), ..Script::default() }, "warning", "04C3 is without power supply", "power supply"),
        (Script { first: Some(nothing), ..Script::default() }, "warning", "device not found", "USB"),
    ];
    let runs = |(script, level, words, advice): (Script, &str, &str, &str)| {
        let service = Service::start(script);
        let found = inverse3(&service.url);
        assert!(found.0.contains(level) && found.1.contains(words) && found.2.contains(advice), "{found:?}");
    };
    thread::scope(|scope| cases.into_iter().for_each(|case| drop(scope.spawn(move || runs(case)))));
    let nobody = inverse3("ws://127.0.0.1:9");
    assert!(nobody.1.contains("service not reached") && nobody.2.contains("Inverse Service"), "{nobody:?}");
}

#[test]
fn a_force_that_no_inverse3_has_is_refused() {
    let run = stylet(&["doctor", "--inverse3-max-force", "50"]);
    run.refused(&["--inverse3-max-force", "50", "above 0, at most 10"]);
}
