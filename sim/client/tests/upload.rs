//! `stylet upload` against a stand-in: what counts as delivered, what is tried again, what is kept and with which
//! reason. Would fail if a sign-in page, a captive portal or garbage were taken for an acknowledgement, if a cut upload
//! began anew, if an attempt that was not delivered left the outbox, or if the token leaked.

use std::fs;
use std::path::PathBuf;

use tempfile::TempDir;

use crate::stand_in::{StandIn, answer, arrived, became, begun};
use crate::{Run, program, run, stylet, text};

const TOKEN: &str = "secret-token";
/// Bytes of a piece.
const PIECE: usize = 256 * 1024;

/// A file to send and an outbox. What is in the file is the service's business; this side only has to send it.
struct Desk {
    folder: TempDir,
    bytes: Vec<u8>,
}

impl Desk {
    fn new() -> Self {
        let folder = TempDir::new().expect("a folder");
        let bytes: Vec<u8> = (0..300_000_u32).map(|n| (n % 251) as u8).collect();
        fs::write(folder.path().join("attempt.mcap"), &bytes).expect("a file");
        Self { folder, bytes }
    }

    fn file(&self) -> PathBuf {
        self.folder.path().join("attempt.mcap")
    }

    fn outbox(&self) -> PathBuf {
        self.folder.path().join("outbox")
    }

    fn upload(&self, server: &str, more: &[&str]) -> Run {
        let (file, outbox) = (self.file(), self.outbox());
        let options = ["upload", text(&file), "--server", server, "--outbox", text(&outbox), "--retry-wait-ms", "1"];
        run(program().args(options).args(more).env("STYLET_TOKEN", TOKEN))
    }

    /// What waits, as `stylet outbox --json` lists it.
    fn waiting(&self) -> serde_json::Value {
        stylet(&["outbox", "--json", "--outbox", text(&self.outbox())]).ends(0).json()
    }
}

fn delivered() -> Vec<String> {
    vec![begun(), arrived(PIECE), became("0190-session")]
}

/// Uploads to a service that refuses with problem details, and returns what the user sees and what then waits.
fn refused(status: &str, detail: &str) -> (Run, serde_json::Value) {
    let body = format!(r#"{{"type":"about:blank","title":"{detail}","status":0,"detail":"{detail}"}}"#);
    let service = StandIn::answering(&[answer(status, "application/problem+json", &body)]);
    let desk = Desk::new();
    let run = desk.upload(&service.address, &[]).ends(1);
    assert_eq!(service.requests().len(), 1, "a refusal is not tried again");
    assert_eq!(run.stderr.lines().count(), 1, "{}", run.stderr);
    run.says(&["not delivered", "kept in the outbox"]);
    let waiting = desk.waiting();
    assert!(waiting[0]["last_error"].as_str().expect("a reason").contains(detail), "{waiting}");
    (run, waiting[0].clone())
}

#[test]
fn upload_sends_checked_pieces_with_a_token_and_empties_outbox() {
    let desk = Desk::new();
    let token = desk.folder.path().join("token");
    fs::write(&token, format!("{TOKEN}\n")).expect("a file");
    let service = StandIn::answering(&delivered());
    let (file, outbox) = (desk.file(), desk.outbox());
    let call = ["upload", text(&file), "--server", &service.address, "--outbox", text(&outbox)];
    let run = stylet(&[&call[..], &["--token-file", text(&token)]].concat()).ends(0);
    assert!(run.stdout.contains("attempt.mcap: delivered: session 0190-session"), "{}", run.stdout);
    let requests = service.requests();
    assert!(requests[0].head.starts_with("post /api/v1/uploads http/1.1"), "{}", requests[0].head);
    assert!(requests[0].head.contains("upload-length: 300000"), "{}", requests[0].head);
    for (request, offset) in requests[1..].iter().zip([0, PIECE]) {
        assert!(request.head.starts_with("patch /api/v1/uploads/u1 http/1.1"), "{}", request.head);
        for header in [
            "content-type: application/offset+octet-stream",
            &format!("upload-offset: {offset}\r"),
            "upload-checksum: sha256 ",
            "tus-resumable: 1.0.0",
            "bearer secret-token",
        ] {
            assert!(request.head.contains(header), "'{header}' is missing in: {}", request.head);
        }
    }
    assert_eq!([&requests[1].body[..], &requests[2].body].concat(), desk.bytes);
    assert_eq!(desk.waiting(), serde_json::json!([]));
    assert!(desk.file().exists(), "the user's own file is left alone");
}

#[test]
fn http_451_empties_the_outbox_and_keeps_the_users_file() {
    let body = r#"{"title":"Unavailable For Legal Reasons","status":451,"detail":"this guest has withdrawn"}"#;
    let service = StandIn::answering(&[answer("451 Unavailable For Legal Reasons", "application/problem+json", body)]);
    let desk = Desk::new();
    let run = desk.upload(&service.address, &[]).ends(1);
    run.says(&["this guest has withdrawn", "deleted here"]);
    assert_eq!(desk.waiting(), serde_json::json!([]));
    assert!(desk.file().exists(), "what this station has not recorded itself is its user's");
}

#[test]
fn what_the_service_sets_aside_waits() {
    let (_, waiting) = refused("424 Failed Dependency", "it is read no more");
    assert_eq!(waiting["state"], "waiting", "{waiting}");
}

#[test]
fn interrupted_upload_resumes_without_counting_as_a_failure() {
    let cut = String::new();
    let head = |offset: usize| arrived(offset).replace("204 No Content", "200 OK");
    let service = StandIn::answering(&[begun(), arrived(PIECE), cut.clone(), cut, head(PIECE), became("0190")]);
    let desk = Desk::new();
    desk.upload(&service.address, &["--retries", "1"]).ends(1);
    let waiting = desk.waiting();
    assert_eq!((&waiting[0]["state"], &waiting[0]["tries"]), (&"waiting".into(), &1.into()), "{waiting}");
    let run = desk.upload(&service.address, &["--json"]).ends(0);
    assert_eq!(run.json()[0]["session_id"], "0190");
    let requests = service.requests();
    assert!(requests[4].head.starts_with("head /api/v1/uploads/u1"), "{}", requests[4].head);
    assert_eq!(requests[5].body, desk.bytes[PIECE..], "only what was missing is sent");
}

#[test]
fn an_upload_the_service_has_forgotten_begins_anew() {
    let gone = answer("410 Gone", "application/problem+json", "{}");
    let cut = [begun(), arrived(PIECE), String::new()];
    let service = StandIn::answering(&[&cut[..], &[gone], &delivered()].concat());
    let desk = Desk::new();
    desk.upload(&service.address, &["--retries", "0"]).ends(1);
    desk.upload(&service.address, &["--retries", "0"]).ends(0);
    let requests = service.requests();
    assert!(requests[3].head.starts_with("head ") && requests[4].head.starts_with("post "), "it asks, then begins");
}

#[test]
fn refused_upload_reports_the_services_reason_and_next_step() {
    let (run, waiting) = refused("401 Unauthorized", "this token was revoked");
    run.says(&["HTTP 401", "this token was revoked", "stylet pair"]);
    assert_eq!(waiting["state"], "waiting", "a new token mends it");
    for (status, code, detail) in [
        ("409 Conflict", "HTTP 409", "other bytes under this id"),
        ("413 Content Too Large", "HTTP 413", "at most 64 MiB"),
        ("422 Unprocessable Content", "HTTP 422", "damaged at byte 77"),
    ] {
        let (run, waiting) = refused(status, detail);
        run.says(&[code, detail, "rejected permanently"]);
        assert_eq!(waiting["state"], "refused", "{status}");
    }
}

#[test]
fn a_recording_refused_when_it_was_whole_is_refused_for_good() {
    let conflict =
        answer("409 Conflict", "application/problem+json", r#"{"detail":"uploaded before with other bytes"}"#);
    let gone = answer("404 Not Found", "application/problem+json", "");
    let service = StandIn::answering(&[begun(), arrived(PIECE), conflict.clone(), gone]);
    let desk = Desk::new();
    desk.upload(&service.address, &[]).ends(1).says(&["other bytes", "rejected permanently"]);
    assert_eq!(desk.waiting()[0]["state"], "refused");
    // The same status for an offset that is not ours: then the upload is still there, and is asked about again.
    let there = arrived(PIECE).replace("204 No Content", "200 OK");
    let service = StandIn::answering(&[begun(), conflict, there.clone(), there, became("0190")]);
    Desk::new().upload(&service.address, &[]).ends(0);
}

#[test]
fn a_failing_service_is_tried_again() {
    let failure = answer("500 Internal Server Error", "text/plain", "oops");
    let service = StandIn::answering(&[&[failure.clone(), failure][..], &delivered()].concat());
    let run = Desk::new().upload(&service.address, &["--json"]).ends(0);
    assert_eq!(run.json()[0]["tries"], 3);
}

#[test]
fn a_service_that_keeps_failing_is_given_up_for_now() {
    let failure = answer("503 Service Unavailable", "text/plain", "");
    let service = StandIn::answering(&[failure.clone(), failure]);
    let desk = Desk::new();
    desk.upload(&service.address, &["--retries", "1"]).ends(1).says(&["not delivered", "HTTP 503", "after 2 tries"]);
    assert_eq!(service.requests().len(), 2);
    assert!(desk.waiting()[0]["next_try_at"].is_string());
}

#[test]
fn pages_and_garbage_are_no_acknowledgement() {
    let portal = StandIn::answering(&[answer("200 OK", "text/html", "<html>Welcome to our network</html>")]);
    Desk::new().upload(&portal.address, &[]).ends(1).says(&["not delivered", "is this the address of the service"]);
    let placeless = StandIn::answering(&[answer("201 Created", "text/html", "")]);
    Desk::new().upload(&placeless.address, &[]).ends(1).says(&["without an upload address"]);
    let silent = "HTTP/1.1 204 No Content\r\nConnection: close\r\n\r\n".to_owned();
    Desk::new().upload(&StandIn::answering(&[begun(), silent]).address, &[]).ends(1).says(&["without an offset"]);
    let whole = StandIn::answering(&[begun(), arrived(PIECE), arrived(300_000), arrived(300_000)]);
    Desk::new().upload(&whole.address, &["--retries", "0"]).ends(1).says(&["has not created an attempt"]);
    let sign_in =
        "HTTP/1.1 303 See Other\r\nLocation: /login\r\nContent-Length: 0\r\nConnection: close\r\n\r\n".to_owned();
    Desk::new()
        .upload(&StandIn::answering(&[sign_in]).address, &[])
        .ends(1)
        .says(&["HTTP 303", "redirects to another address"]);
    let garbage = StandIn::answering(&["mumble\u{1b}[2J mumble\r\n\r\n".to_owned()]);
    let run = Desk::new().upload(&garbage.address, &["--retries", "0"]).ends(1);
    run.says(&["not delivered"]);
    assert!(!run.stderr.contains('\u{1b}'), "control characters reach no terminal");
}

#[test]
fn the_token_goes_to_no_other_address() {
    let elsewhere = begun().replace("/api/v1/uploads/u1", "http://192.0.2.1/api/v1/uploads/u1");
    let service = StandIn::answering(&[elsewhere, arrived(PIECE), became("0190")]);
    Desk::new().upload(&service.address, &[]).ends(0);
    assert!(service.requests()[1].head.starts_with("patch /api/v1/uploads/u1"), "the id is taken, the host is not");
}

#[test]
fn a_service_that_is_not_there_is_named() {
    let closed = std::net::TcpListener::bind("127.0.0.1:0").expect("a port").local_addr().expect("an address");
    let run = Desk::new().upload(&format!("http://{closed}"), &["--retries", "2"]).ends(1);
    run.says(&[&closed.to_string(), "refused", "after 3 tries"]);
    assert_eq!(run.stderr.lines().count(), 1);
}

#[test]
fn wrong_calls_send_nothing() {
    let desk = Desk::new();
    let file = desk.file();
    let server = ["--server", "http://127.0.0.1:9"];
    stylet(&["upload", text(&file), server[0], server[1]]).refused(&["no token", "--token-file", "STYLET_TOKEN"]);
    stylet(&["upload", "nowhere.mcap", server[0], server[1]]).refused(&["nowhere.mcap"]);
    stylet(&["upload", text(&file), "--server", "ftp://example.org"]).refused(&["--server", "https://HOST"]);
    let run = run(program().args(["upload", text(&file), server[0], server[1]]).env("STYLET_TOKEN", "two words"));
    assert!(!run.stderr.contains("two words"), "a token is never printed: {}", run.stderr);
    run.refused(&["STYLET_TOKEN", "one word"]);
}
