//! `stylet outbox` and `stylet pair`: what waits, and how a station gets its token. Would fail if an attempt were lost by
//! a spoilt note or a full disk, if the same recording waited twice, if the token could be read by others, or if it went
//! to a service that did not give it.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Stdio;

use tempfile::TempDir;

use crate::stand_in::{StandIn, answer, became, begun};
use crate::{Run, program, run, text};

/// A home of its own.
struct Home(TempDir);

impl Home {
    fn new() -> Self {
        let home = Self(TempDir::new().expect("a folder"));
        fs::write(home.recording(), b"an attempt").expect("a file");
        home
    }

    fn recording(&self) -> PathBuf {
        self.0.path().join("attempt.mcap")
    }

    fn outbox(&self) -> PathBuf {
        self.0.path().join("data/stylet/outbox")
    }

    fn pairing(&self) -> PathBuf {
        self.0.path().join("config/stylet/station.json")
    }

    fn command(&self, args: &[&str]) -> std::process::Command {
        let mut command = program();
        command.args(args).env("XDG_DATA_HOME", self.0.path().join("data"));
        command.env("XDG_CONFIG_HOME", self.0.path().join("config"));
        command
    }

    fn stylet(&self, args: &[&str]) -> Run {
        run(&mut self.command(args))
    }

    /// Pairs with a stand-in that then gives `answers`.
    fn paired(&self, answers: &[String]) -> StandIn {
        let service = StandIn::answering(&[&[joined()][..], answers].concat());
        self.stylet(&["pair", "--server", &service.address, "--code", "ABCD-EFGH", "--name", "lab"]).ends(0);
        service
    }

    /// Brings the recording into the outbox; nobody is there to take it.
    fn keep(&self) {
        let recording = self.recording();
        let call = ["upload", text(&recording), "--server", "http://127.0.0.1:9", "--retries", "0"];
        run(self.command(&call).env("STYLET_TOKEN", "t")).ends(1);
    }

    fn waiting(&self) -> serde_json::Value {
        self.stylet(&["outbox", "--json"]).ends(0).json()
    }
}

fn joined() -> String {
    let station = "01a20705-e993-735e-8be9-ef0ebc59bfc5";
    let said = format!(r#"{{"station_id":"{station}","token":"station-token","school":"North","name":"lab"}}"#);
    answer("201 Created", "application/json", &said)
}

fn delivered() -> Vec<String> {
    vec![begun(), became("0190")]
}

#[test]
fn a_station_is_paired_and_its_token_kept_for_its_user_alone() {
    let home = Home::new();
    let service = StandIn::answering(&[joined()]);
    let call = ["pair", "--server", &service.address, "--code", "ABCD-EFGH", "--name", "lab"];
    let run = home.stylet(&call).ends(0);
    assert!(run.stdout.contains("\"lab\" of North"), "{}", run.stdout);
    assert!(!run.stdout.contains("station-token") && !run.stderr.contains("station-token"));
    let request = service.requests().remove(0);
    assert!(request.head.starts_with("post /api/v1/stations/pair"), "{}", request.head);
    let mut body: serde_json::Value = serde_json::from_slice(&request.body).expect("JSON");
    let key = body["public_key"].take();
    assert!(key.as_str().is_some_and(|key| key.len() == 64), "{key}");
    assert_eq!(body, serde_json::json!({ "code": "ABCD-EFGH", "name": "lab", "public_key": null }));
    let kept = fs::read_to_string(home.pairing()).expect("a file");
    assert!(kept.contains("station-token") && kept.contains("North"), "{kept}");
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt;
        let mode = fs::metadata(home.pairing()).expect("a file").permissions().mode();
        assert_eq!(mode & 0o777, 0o600, "{mode:o}");
    }
}

#[test]
fn what_is_no_pairing_is_told_and_keeps_nothing() {
    let home = Home::new();
    let problem = |status, detail| answer(status, "application/problem+json", &format!(r#"{{"detail":"{detail}"}}"#));
    for (answer, words) in [
        (problem("403 Forbidden", "this code is used"), "this code is used"),
        (problem("429 Too Many Requests", "too many attempts"), "too many attempts"),
        (answer("200 OK", "text/html", "<html>"), "is this the address of the service"),
        (answer("201 Created", "application/json", "{}"), "is this the address of the service"),
    ] {
        let service = StandIn::answering(&[answer]);
        home.stylet(&["pair", "--server", &service.address, "--code", "x"]).ends(1).says(&["not paired", words]);
        assert!(!home.pairing().exists(), "{words}");
    }
    let server = ["pair", "--server", "http://127.0.0.1:9"];
    run(home.command(&server).stdin(Stdio::null())).refused(&["--code", "terminal"]);
}

#[test]
fn what_waits_is_listed_with_the_reason_and_once() {
    let home = Home::new();
    assert!(home.stylet(&["outbox"]).ends(0).stdout.contains("no pending attempts in"));
    home.keep();
    home.keep();
    let waiting = home.waiting();
    assert_eq!(waiting.as_array().expect("a list").len(), 1, "the same bytes wait once: {waiting}");
    assert_eq!(
        (&waiting[0]["name"], &waiting[0]["bytes"], &waiting[0]["tries"]),
        (&"attempt.mcap".into(), &10.into(), &2.into())
    );
    fs::remove_file(home.recording()).expect("the user's file");
    let kept = fs::read(waiting[0]["file"].as_str().expect("a path")).expect("the attempt");
    assert_eq!(kept, b"an attempt", "the user may delete theirs");
    let list = home.stylet(&["outbox"]).ends(0).stdout;
    for part in ["attempt.mcap", "waiting", "127.0.0.1:9", "tries: 2", "next at 20"] {
        assert!(list.contains(part), "'{part}' is missing in: {list}");
    }
}

#[test]
fn what_waits_is_sent_with_the_stations_token_and_is_gone() {
    let home = Home::new();
    let service = home.paired(&delivered());
    let recording = home.recording();
    fs::create_dir_all(home.outbox()).expect("a folder");
    // As the simulator keeps it: for whichever service the station is paired with.
    fs::copy(&recording, home.outbox().join("0123456789abcdef.mcap")).expect("a file");
    let run = home.stylet(&["outbox", "send", "--json"]).ends(0);
    assert_eq!(run.json()[0]["session_id"], "0190");
    assert!(service.requests()[1].head.contains("bearer station-token"));
    assert_eq!(home.waiting(), serde_json::json!([]));
    assert_eq!(files(&home.outbox()), 0, "nothing is left over");
}

/// Files in a folder but for hidden ones.
fn files(folder: &Path) -> usize {
    let entries = fs::read_dir(folder).expect("a folder");
    entries.filter(|e| !e.as_ref().expect("an entry").file_name().to_string_lossy().starts_with('.')).count()
}

#[test]
fn a_token_goes_to_the_service_that_gave_it_alone() {
    let home = Home::new();
    home.keep();
    let service = home.paired(&[]);
    home.stylet(&["outbox", "send"]).ends(1).says(&["no token for http://127.0.0.1:9", "stylet pair"]);
    assert_eq!(service.requests().len(), 1, "nothing but the pairing");
}

#[test]
fn a_spoilt_note_or_none_loses_no_attempt() {
    let home = Home::new();
    home.keep();
    let note = PathBuf::from(home.waiting()[0]["file"].as_str().expect("a path")).with_extension("json");
    for spoil in ["{", "", "[1,2]"] {
        fs::write(&note, spoil).expect("a file");
        let waiting = home.waiting();
        assert_eq!((&waiting[0]["state"], &waiting[0]["tries"]), (&"waiting".into(), &0.into()), "{waiting}");
    }
    fs::remove_file(&note).expect("a file");
    assert_eq!(home.waiting()[0]["bytes"], 10);
}

#[test]
fn what_was_refused_for_good_is_sent_or_discarded_by_name_only() {
    let home = Home::new();
    let service = StandIn::answering(&[answer("413 Content Too Large", "text/plain", "")]);
    let recording = home.recording();
    let upload = ["upload", text(&recording), "--server", &service.address];
    run(home.command(&upload).env("STYLET_TOKEN", "t")).ends(1);
    let waiting = home.waiting();
    let id = waiting[0]["id"].as_str().expect("an id").to_owned();
    assert_eq!(waiting[0]["state"], "refused");
    assert_eq!(home.stylet(&["outbox", "send", "--json"]).ends(0).json(), serde_json::json!([]), "not tried by itself");
    home.stylet(&["outbox", "discard", "nothing"]).refused(&["nothing", "no such attempt"]);
    assert_eq!(home.waiting().as_array().expect("a list").len(), 1);
    home.stylet(&["outbox", "discard", &id]).ends(0);
    assert_eq!(home.waiting(), serde_json::json!([]));
}

#[test]
fn watching_sends_what_comes() {
    let home = Home::new();
    let service = home.paired(&delivered());
    let mut watch = home.command(&["outbox", "send", "--watch"]).stdout(Stdio::null()).spawn().expect("it starts");
    fs::create_dir_all(home.outbox()).expect("a folder");
    fs::copy(home.recording(), home.outbox().join("0123456789abcdef.mcap")).expect("a file");
    let requests = service.requests();
    watch.kill().and_then(|()| watch.wait()).expect("it is ended");
    assert_eq!(requests.len(), 3);
}

#[cfg(unix)]
#[test]
fn full_disk_is_reported_and_the_attempt_stays_in_place() {
    let home = Home::new();
    let recording = home.recording();
    let call = format!(
        "trap '' XFSZ; ulimit -f 0; exec '{}' upload '{}' --server http://127.0.0.1:9",
        env!("CARGO_BIN_EXE_stylet"),
        text(&recording)
    );
    let mut shell = std::process::Command::new("sh");
    shell.args(["-c", &call]).env("STYLET_TOKEN", "t").env("XDG_DATA_HOME", home.0.path().join("data"));
    run(&mut shell).ends(1).says(&["attempt.mcap", "cannot be stored", "is left in place"]);
    assert_eq!(fs::read(&recording).expect("the attempt"), b"an attempt");
}

/// Brings answers to a survey into the outbox, as the window leaves them.
fn keep_answers(home: &Home, server: &str) {
    let answers = r#"{"session":"019a0000-0000-7000-8000-000000000001","survey":"019a0000-0000-7000-8000-000000000002",
        "secret":"aa","language":"de","answers":{"mental":55.0,"why":["a","b"]},"sent":true}"#;
    fs::create_dir_all(home.outbox()).expect("a folder");
    fs::write(home.outbox().join("0123456789abcdef.answers"), answers).expect("a file");
    let note = format!(
        r#"{{"name":"answers","kept_at":"2026-05-20T10:00:00Z","server":"{server}","upload":null,"tries":0,"last_error":null,
        "refused":false,"next_try_at":null}}"#
    );
    fs::write(home.outbox().join("0123456789abcdef.json"), note).expect("a file");
}

#[test]
fn answers_leave_the_outbox_only_when_the_service_has_them() {
    let home = Home::new();
    let not_there = answer("404 Not Found", "application/problem+json", r#"{"detail":"there is nothing here"}"#);
    let portal = answer("200 OK", "text/html", "<p>Welcome to our network</p>");
    let taken = answer("200 OK", "application/json", r#"{"state":"submitted"}"#);
    let service = home.paired(&[not_there, portal, taken]);
    keep_answers(&home, &service.address);
    for says in ["there is nothing here", "is this the address of the service?"] {
        home.stylet(&["outbox", "send"]).ends(1);
        let waiting = home.waiting();
        assert_eq!(waiting[0]["state"], "waiting", "{waiting}");
        assert!(waiting[0]["last_error"].as_str().is_some_and(|error| error.contains(says)), "{waiting}");
    }
    home.stylet(&["outbox", "send"]).ends(0);
    assert_eq!(home.waiting(), serde_json::json!([]));
    let requests = service.requests();
    let last = requests.last().expect("a request");
    let place =
        "put /api/v1/sessions/019a0000-0000-7000-8000-000000000001/survey/019a0000-0000-7000-8000-000000000002 ";
    assert!(last.head.starts_with(place) && last.head.contains("bearer station-token"), "{}", last.head);
    let given: serde_json::Value = serde_json::from_slice(&last.body).expect("JSON");
    assert_eq!(given["answers"], serde_json::json!({ "mental": 55.0, "why": ["a", "b"] }));
    assert_eq!((&given["consent"], &given["sent"]), (&true.into(), &true.into()));
}

#[test]
fn answers_that_are_refused_for_good_say_so() {
    let home = Home::new();
    let gone = answer("410 Gone", "application/problem+json", r#"{"detail":"this survey was not open"}"#);
    let service = home.paired(&[gone]);
    keep_answers(&home, &service.address);
    home.stylet(&["outbox", "send"]).ends(1);
    assert_eq!(home.waiting()[0]["state"], "refused");
}
