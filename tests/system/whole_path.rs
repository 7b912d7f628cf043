//! The whole path through both programs, as a school would walk it: an exercise file becomes a recording, an upload, a
//! score and a page. Fails when the service scores otherwise than the client, when the recording does not re-simulate
//! to the bit, or when an upload that was delivered is delivered twice.

use std::path::Path;
use std::time::Duration;

use serde_json::Value;
use tests::{Service, first_exercise, run, run_ok};

use crate::visitor::{INITIAL, Visitor, choose_password};

pub(super) const PASSWORD: &str = "a long enough password";

/// A school with one trainee and the shipped curricula; returns the trainee's upload token.
pub(super) fn found_school(data: &Path) -> String {
    let data = data.to_string_lossy();
    run_ok("web-admin", &["migrate", "--data-dir", &data]);
    let add = ["user", "add", "--data-dir", &data, "--school", "Test School", "--role", "trainee"];
    let who = ["--email", "ada@example.org", "--name", "Ada", "--password", INITIAL];
    run_ok("web-admin", &[&add[..], &who[..]].concat());
    run_ok("web-admin", &["curricula", "import", "curricula", "--data-dir", &data, "--school", "Test School"]);
    let token = run_ok("web-admin", &["user", "token", "--data-dir", &data, "--email", "ada@example.org"]);
    token.trim_end().to_owned()
}

pub(super) fn simulate(folder: &Path, name: &str, operator: &str) -> String {
    let path = folder.join(name).to_string_lossy().into_owned();
    run_ok("stylet", &["simulate", &first_exercise(), "--operator", operator, "--seed", "7", "--out", &path]);
    path
}

pub(super) fn json(text: &str) -> Value {
    serde_json::from_str(text).unwrap_or_else(|error| panic!("{error} in {text}"))
}

/// The score of a session, once the worker has made it: under an oblique needle a program that is not optimised first solves its field for seconds.
pub(super) fn scored(url: &str, token: &str, session: &str) -> Value {
    for _ in 0..900 {
        let answer = ureq::get(format!("{url}/api/v1/sessions/{session}/score"))
            .header("Authorization", format!("Bearer {token}"))
            .call();
        if let Ok(mut answer) = answer
            && answer.status() == 200
        {
            return json(&answer.body_mut().read_to_string().expect("a body"));
        }
        std::thread::sleep(Duration::from_millis(100));
    }
    panic!("session {session} was not scored within ninety seconds");
}

#[test]
fn an_exercise_becomes_a_scored_attempt_on_a_page() {
    let folder = tempfile::tempdir().expect("a folder");
    let data = folder.path().join("data");
    let token = found_school(&data);
    let recording = simulate(folder.path(), "attempt.mcap", "novice");
    let ours = json(&run_ok("stylet", &["score", &recording, "--json"]));
    let verified = json(&run_ok("stylet", &["verify", &recording, "--json"]));
    assert_eq!(verified["largest_deviation_n"], 0.0, "the recording re-simulates to the bit: {verified}");

    let service = Service::start(&data);
    choose_password(&service.url, "ada@example.org", PASSWORD);
    let token_file = folder.path().join("token");
    std::fs::write(&token_file, &token).expect("a token file");
    let outbox = folder.path().join("outbox").to_string_lossy().into_owned();
    let token_file = token_file.to_string_lossy();
    let upload = ["upload", &recording, "--server", &service.url, "--token-file", &token_file, "--outbox", &outbox];
    run_ok("stylet", &upload);
    run_ok("stylet", &upload);

    let session = id(&only_session(&service.url, &token), "session_id");
    let theirs = scored(&service.url, &token, &session);
    for key in ["score", "passed", "deductions", "hard_fails", "rubric", "simulator_version"] {
        assert_eq!(theirs[key], ours[key], "client and service differ on {key}");
    }
    let page = Visitor::signed_in(&service.url, "ada@example.org", PASSWORD).page(&format!("/sessions/{session}"));
    assert!(page.contains("<svg"), "the session's page draws the attempt");
    let data = data.to_string_lossy();
    run_ok("web-admin", &["verify", "--data-dir", &data]);
}

/// The only session the caller can see.
pub(super) fn only_session(url: &str, token: &str) -> Value {
    let answer = ureq::get(format!("{url}/api/v1/sessions")).header("Authorization", format!("Bearer {token}")).call();
    let body = answer.expect("a list of sessions").body_mut().read_to_string().expect("a body");
    let list = json(&body);
    let sessions = list["sessions"].as_array().expect("sessions");
    assert_eq!(sessions.len(), 1, "delivered twice, listed once: {list}");
    sessions[0].clone()
}

/// A text in an answer.
pub(super) fn id(of: &Value, key: &str) -> String {
    of[key].as_str().unwrap_or_else(|| panic!("no {key} in {of}")).to_owned()
}

#[test]
fn the_reference_cases_of_the_force_law_come_out_of_the_program() {
    for name in ["table_i", "trocar", "training_in_hold_out_in"] {
        let case = format!("tests/data/force/{name}.json");
        let trajectory = format!("tests/data/force/{name}.csv");
        let ours = run_ok("stylet", &["force", &case, "--trajectory", &trajectory]);
        let theirs = std::fs::read_to_string(tests::root().join(&trajectory)).expect("the reference");
        assert_eq!(ours.lines().count(), theirs.lines().count(), "{name}");
        for (line, (a, b)) in ours.lines().zip(theirs.lines()).enumerate() {
            for (x, y) in a.split(',').zip(b.split(',')) {
                assert!(close(x, y), "{name} line {}: {x} is not {y}", line + 1);
            }
        }
    }
}

/// Equal words, or numbers equal to a relative 1e-9 (an absolute 1e-12 near zero).
fn close(x: &str, y: &str) -> bool {
    match (x.parse::<f64>(), y.parse::<f64>()) {
        (Ok(x), Ok(y)) => (x - y).abs() <= 1e-12 + 1e-9 * y.abs(),
        _ => x == y,
    }
}

#[test]
fn every_shipped_document_passes_the_check() {
    let files: Vec<String> = tests::documents();
    assert!(files.len() >= 12, "only {} documents are shipped", files.len());
    let mut arguments = vec!["check"];
    arguments.extend(files.iter().map(String::as_str));
    run_ok("stylet", &arguments);
}

#[test]
fn bad_input_ends_in_one_line_and_status_two() {
    for arguments in [
        &["simulate", "no-such-file.toml", "--operator", "expert", "--seed", "1", "--out", "/dev/null"][..],
        &["score", "Cargo.toml"],
        &["force", "Cargo.toml", "--trajectory", "Cargo.toml"],
        &["check", "Cargo.toml"],
    ] {
        let output = run("stylet", arguments);
        let stderr = String::from_utf8_lossy(&output.stderr);
        assert!(matches!(output.status.code(), Some(1 | 2)), "{arguments:?} ended with {}: {stderr}", output.status);
        assert!(!stderr.contains("panicked") && !stderr.trim().is_empty(), "{arguments:?}: {stderr}");
    }
}
