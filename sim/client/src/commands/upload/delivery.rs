//! One recording over HTTP: streamed, tried again where that can help, and acknowledged or not.

use std::fs::File;
use std::io::Read;
use std::path::Path;
use std::time::Duration;

use serde::Serialize;
use serde_json::Value;
use ureq::http::header::{AUTHORIZATION, CONTENT_LENGTH, CONTENT_TYPE, EXPECT};
use ureq::http::{HeaderValue, Uri};
use ureq::{Agent, SendBody};

use crate::progress::Progress;

/// Longest wait between two tries.
const LONGEST_WAIT: Duration = Duration::from_secs(60);
/// Most bytes read of an answer: a session or a problem is far smaller.
const LARGEST_ANSWER: u64 = 1 << 20;
/// Longest time for a connection, for each piece sent, and for an answer once the recording is sent.
const PATIENCE: Duration = Duration::from_secs(30);

/// What became of a recording.
#[derive(Debug, Serialize)]
pub struct Delivery {
    /// The file.
    pub recording: String,
    /// The service has it on its disk.
    pub delivered: bool,
    /// The last HTTP status; absent when there was no answer.
    pub status: Option<u16>,
    /// How often it was tried.
    pub tries: u32,
    /// What was said, in words.
    pub detail: String,
}

/// The service that recordings go to.
pub struct Service {
    agent: Agent,
    address: String,
    token: HeaderValue,
    retries: u32,
    first_wait: Duration,
}

/// What one try came to.
struct Answer {
    status: Option<u16>,
    delivered: bool,
    try_again: bool,
    detail: String,
}

impl Service {
    /// A service at an address.
    pub fn new(server: &Uri, token: HeaderValue, retries: u32, first_wait: Duration) -> Self {
        // A redirect to a sign-in page is an answer, not a place to send a recording to.
        let config = Agent::config_builder()
            .http_status_as_error(false)
            .max_redirects(0)
            .max_redirects_will_error(false)
            .timeout_connect(Some(PATIENCE))
            .timeout_recv_response(Some(PATIENCE))
            .timeout_recv_body(Some(PATIENCE))
            .timeout_per_write(Some(PATIENCE))
            .user_agent(concat!("stylet/", env!("CARGO_PKG_VERSION")))
            .build();
        let address = format!("{}/api/v1/sessions", server.to_string().trim_end_matches('/'));
        Self { agent: config.into(), address, token, retries, first_wait }
    }

    /// Sends a recording, several times if need be.
    pub fn deliver(&self, path: &Path) -> Delivery {
        let mut wait = self.first_wait;
        let mut tries = 1;
        let mut answer = self.attempt(path);
        while answer.try_again && tries <= self.retries {
            std::thread::sleep(wait);
            wait = (wait * 2).min(LONGEST_WAIT);
            tries += 1;
            answer = self.attempt(path);
        }
        let detail = if tries > 1 { format!("{} (after {tries} tries)", answer.detail) } else { answer.detail };
        let recording = path.display().to_string();
        Delivery { recording, delivered: answer.delivered, status: answer.status, tries, detail }
    }

    fn attempt(&self, path: &Path) -> Answer {
        let opened = File::open(path).and_then(|file| file.metadata().map(|metadata| (file, metadata.len())));
        match opened {
            Ok((file, length)) => self.send(file, length).unwrap_or_else(|error| no_answer(&self.address, &error)),
            Err(error) => Answer { status: None, delivered: false, try_again: false, detail: error.to_string() },
        }
    }

    fn send(&self, file: File, length: u64) -> Result<Answer, ureq::Error> {
        let progress = Progress::new(length, "uploading");
        let mut body = progress.watch(file);
        let mut response = self
            .agent
            .post(&self.address)
            .header(AUTHORIZATION, &self.token)
            .header(CONTENT_TYPE, "application/octet-stream")
            .header(CONTENT_LENGTH, length)
            // A service that refuses the token or the length can say so before the recording is sent.
            .header(EXPECT, "100-continue")
            .send(SendBody::from_reader(&mut body))?;
        let status = response.status().as_u16();
        let mut text = String::new();
        let reader = response.body_mut().as_reader();
        // What cannot be read of an explanation only makes it shorter.
        let _ = reader.take(LARGEST_ANSWER).read_to_string(&mut text);
        Ok(judge(status, &text))
    }
}

/// What an answer means.
fn judge(status: u16, text: &str) -> Answer {
    let body: Option<Value> = serde_json::from_str(text).ok();
    let session = body.as_ref().is_some_and(Value::is_object);
    let (delivered, detail) = match (status, session) {
        (201, true) => (true, "accepted".to_owned()),
        (200, true) => (true, "the service had it already".to_owned()),
        (200 | 201, false) => (false, format!("HTTP {status} without a session: is this the address of the service?")),
        _ => (false, format!("HTTP {status}: {}", explained(status, body.as_ref()))),
    };
    let try_again = status >= 500 || matches!(status, 408 | 425 | 429);
    Answer { status: Some(status), delivered, try_again, detail }
}

/// The service's own words (RFC 9457 problem details), or ours where it has none.
fn explained(status: u16, body: Option<&Value>) -> String {
    let member = |name: &str| body.and_then(|body| body.get(name)).and_then(Value::as_str);
    let ours = match status {
        300..=399 => "the service wants to send us elsewhere; is this its address?",
        401 => "the token is missing, unknown or revoked",
        403 => "the token may not do this",
        404 => "no such address; is this the service?",
        409 => "the service has another recording of this session",
        413 => "the recording is larger than the service allows",
        422 => "the service cannot use this recording",
        429 => "the service asks us to slow down",
        500.. => "the service failed",
        _ => "not what the service should say",
    };
    match (member("title"), member("detail")) {
        (Some(title), Some(detail)) if title != detail => format!("{title}: {detail}"),
        (_, Some(text)) | (Some(text), None) => text.to_owned(),
        (None, None) => ours.to_owned(),
    }
}

fn no_answer(address: &str, error: &ureq::Error) -> Answer {
    // An address that names no host or no protocol we speak will not do so later either.
    let hopeless = matches!(error, ureq::Error::BadUri(_) | ureq::Error::InvalidProxyUrl | ureq::Error::Tls(_));
    Answer { status: None, delivered: false, try_again: !hopeless, detail: format!("{address}: {error}") }
}
