//! `stylet doctor`: it looks, names what it found with units, and fails only for what would lose an attempt.

use crate::stand_in::{StandIn, answer};
use crate::{stylet, text};

#[test]
fn it_reports_timer_priority_processor_and_disk() {
    let folder = tempfile::TempDir::new().expect("a folder");
    let service = StandIn::answering(&[answer("200 OK", "text/plain", "ok")]);
    let run = stylet(&["doctor", "--json", "--recordings", text(folder.path()), "--server", &service.address]).ends(0);
    let findings = run.json()["findings"].clone();
    for subject in ["processor", "timer", "real-time priority", "disk space", "disk speed", "server"] {
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
