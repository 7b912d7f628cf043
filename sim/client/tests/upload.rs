//! `stylet upload` against a stand-in: what counts as delivered, what is tried again, what is reported and how. Would
//! fail if a sign-in page, a captive portal or garbage were taken for an acknowledgement, or if the token leaked.

use std::fs;
use std::path::PathBuf;

use tempfile::TempDir;

use crate::stand_in::{StandIn, answer};
use crate::{Run, program, run, stylet, text};

const TOKEN: &str = "secret-token";

/// A file to send. What is in it is the service's business; this side only has to send it byte for byte.
fn recording() -> (TempDir, PathBuf, Vec<u8>) {
    let folder = TempDir::new().expect("a folder");
    let file = folder.path().join("attempt.mcap");
    let bytes: Vec<u8> = (0..300_000_u32).map(|n| (n % 251) as u8).collect();
    fs::write(&file, &bytes).expect("a file");
    (folder, file, bytes)
}

fn upload(server: &str, more: &[&str]) -> Run {
    let (_folder, file, _) = recording();
    let options = ["upload", text(&file), "--server", server, "--retry-wait-ms", "1"];
    run(program().args(options).args(more).env("STYLET_TOKEN", TOKEN))
}

/// Uploads to a service that refuses with problem details, and returns what the user sees.
fn refused(status: &str, detail: &str) -> Run {
    let body = format!(r#"{{"type":"about:blank","title":"{detail}","status":0,"detail":"{detail}"}}"#);
    let service = StandIn::answering(&[answer(status, "application/problem+json", &body)]);
    let run = upload(&service.address, &[]).ends(1);
    assert_eq!(service.requests().len(), 1, "a refusal is not tried again");
    assert_eq!(run.stderr.lines().count(), 1, "{}", run.stderr);
    run
}

fn accepted() -> String {
    answer("201 Created", "application/json", r#"{"session_id":"0"}"#)
}

#[test]
fn a_recording_is_streamed_byte_for_byte_with_its_token() {
    let (folder, file, bytes) = recording();
    let token = folder.path().join("token");
    fs::write(&token, format!("{TOKEN}\n")).expect("a file");
    let service = StandIn::answering(&[accepted()]);
    let run = stylet(&["upload", text(&file), "--server", &service.address, "--token-file", text(&token)]).ends(0);
    assert!(run.stdout.contains("attempt.mcap: delivered"), "{}", run.stdout);
    let request = service.requests().remove(0);
    assert!(request.head.starts_with("post /api/v1/sessions http/1.1"), "{}", request.head);
    for header in ["content-type: application/octet-stream", "content-length: 300000", "bearer secret-token"] {
        assert!(request.head.contains(header), "'{header}' is missing in: {}", request.head);
    }
    assert_eq!(request.body, bytes);
}

#[test]
fn a_session_that_was_there_already_is_delivered() {
    let service = StandIn::answering(&[answer("200 OK", "application/json", "{}")]);
    let run = upload(&service.address, &["--json"]).ends(0);
    let deliveries = run.json();
    assert_eq!(deliveries[0]["delivered"], true);
    assert_eq!(deliveries[0]["status"], 200);
}

#[test]
fn refusals_are_told_in_the_services_words() {
    refused("401 Unauthorized", "this token was revoked").says(&["HTTP 401", "this token was revoked"]);
    refused("409 Conflict", "other bytes under this id").says(&["HTTP 409", "other bytes under this id"]);
    refused("413 Content Too Large", "at most 64 MiB").says(&["HTTP 413", "at most 64 MiB"]);
    refused("422 Unprocessable Content", "damaged at byte 77").says(&["HTTP 422", "damaged at byte 77"]);
}

#[test]
fn a_failing_service_is_tried_again() {
    let failure = answer("500 Internal Server Error", "text/plain", "oops");
    let service = StandIn::answering(&[failure.clone(), failure, accepted()]);
    let run = upload(&service.address, &["--json"]).ends(0);
    assert_eq!(run.json()[0]["tries"], 3);
    let requests = service.requests();
    assert!(requests.iter().all(|request| request.body == requests[0].body), "every try sends the whole recording");
}

#[test]
fn a_service_that_keeps_failing_is_given_up() {
    let failure = answer("503 Service Unavailable", "text/plain", "");
    let service = StandIn::answering(&[failure.clone(), failure]);
    upload(&service.address, &["--retries", "1"]).ends(1).says(&["not delivered", "HTTP 503", "after 2 tries"]);
    assert_eq!(service.requests().len(), 2);
}

#[test]
fn pages_and_garbage_are_no_acknowledgement() {
    let portal = StandIn::answering(&[answer("200 OK", "text/html", "<html>Welcome to our network</html>")]);
    upload(&portal.address, &[]).ends(1).says(&["not delivered", "without a session"]);
    let sign_in =
        "HTTP/1.1 303 See Other\r\nLocation: /login\r\nContent-Length: 0\r\nConnection: close\r\n\r\n".to_owned();
    upload(&StandIn::answering(&[sign_in]).address, &[]).ends(1).says(&["HTTP 303", "elsewhere"]);
    let garbage = StandIn::answering(&["mumble\u{1b}[2J mumble\r\n\r\n".to_owned()]);
    let run = upload(&garbage.address, &["--retries", "0"]).ends(1);
    run.says(&["not delivered"]);
    assert!(!run.stderr.contains('\u{1b}'), "control characters reach no terminal");
}

#[test]
fn a_service_that_is_not_there_is_named() {
    let closed = std::net::TcpListener::bind("127.0.0.1:0").expect("a port").local_addr().expect("an address");
    let run = upload(&format!("http://{closed}"), &["--retries", "2"]).ends(1);
    run.says(&[&closed.to_string(), "refused", "after 3 tries"]);
    assert_eq!(run.stderr.lines().count(), 1);
}

#[test]
fn wrong_calls_send_nothing() {
    let (_folder, file, _) = recording();
    let server = ["--server", "http://127.0.0.1:9"];
    stylet(&["upload", text(&file), server[0], server[1]]).refused(&["no token", "--token-file", "STYLET_TOKEN"]);
    stylet(&["upload", "nowhere.mcap", server[0], server[1]]).refused(&["nowhere.mcap"]);
    stylet(&["upload", text(&file), "--server", "ftp://example.org"]).refused(&["--server", "https://HOST"]);
    let run = run(program().args(["upload", text(&file), server[0], server[1]]).env("STYLET_TOKEN", "two words"));
    assert!(!run.stderr.contains("two words"), "a token is never printed: {}", run.stderr);
    run.refused(&["STYLET_TOKEN", "one word"]);
}
