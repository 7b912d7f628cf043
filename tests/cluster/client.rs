//! Somebody who speaks HTTP with a school, by way of a small proxy: requests go to the services in turn, and one that does not take a
//! connection is passed over.

use std::collections::BTreeMap;
use std::io::ErrorKind;
use std::sync::Arc;
use std::sync::atomic::AtomicUsize;
use std::sync::atomic::Ordering::SeqCst;
use std::thread;
use std::time::Duration;

use anyhow::{Context, bail};
use platform::clock;
use ureq::http;

use crate::ledger::Ledger;

/// Longest that a client waits for an answer.
pub const LONGEST_ANSWER: Duration = Duration::from_secs(60);
/// Most requests that a client makes of one before it gives up.
const MOST_TRIES: u32 = 100;
/// How long a client waits that is asked to come again, at most: their word is a guess, and a test has no time.
const LONGEST_WAIT: Duration = Duration::from_secs(1);

/// A request.
#[derive(Clone, Debug)]
pub struct Request<'a> {
    /// For the ledger: what is asked.
    pub what: &'static str,
    /// The method.
    pub method: &'static str,
    /// From the root.
    pub path: &'a str,
    /// Besides those that say who asks.
    pub headers: Vec<(&'static str, String)>,
    /// What is sent along.
    pub body: &'a [u8],
    /// Whether it may be sent again when nobody knows what has become of it.
    pub repeatable: bool,
}

impl<'a> Request<'a> {
    /// What only reads.
    pub const fn get(what: &'static str, path: &'a str) -> Self {
        Self { what, method: "GET", path, headers: Vec::new(), body: &[], repeatable: true }
    }
}

/// An answer.
#[derive(Debug)]
pub struct Answer {
    /// HTTP status.
    pub status: u16,
    /// Its head.
    pub headers: http::HeaderMap,
    /// Its body.
    pub body: Vec<u8>,
    /// How long it took, in s.
    pub seconds: f64,
}

impl Answer {
    /// The body as text.
    pub fn text(&self) -> String {
        String::from_utf8_lossy(&self.body).into_owned()
    }

    /// A header; empty where it is missing.
    pub fn header(&self, name: &str) -> &str {
        self.headers.get(name).and_then(|value| value.to_str().ok()).unwrap_or_default()
    }
}

/// What became of a request.
#[derive(Debug)]
pub enum Outcome {
    /// It was answered.
    Answered(Answer),
    /// No service took the connection: nothing was done.
    Refused,
    /// The connection broke, or nothing came in time: nobody knows what was done.
    Broken {
        /// How.
        why: String,
        /// After how long, in s.
        seconds: f64,
    },
}

/// The proxy: which services there are.
#[derive(Debug)]
pub struct Proxy {
    ports: Vec<u16>,
    next: AtomicUsize,
    agent: ureq::Agent,
}

impl Proxy {
    /// Before these.
    pub fn before(ports: Vec<u16>) -> Self {
        let agent = ureq::Agent::config_builder()
            .timeout_global(Some(LONGEST_ANSWER))
            .http_status_as_error(false)
            .max_redirects(0)
            // A connection that waits may be that of a service that has died since.
            .max_idle_connections(0)
            .max_idle_connections_per_host(0)
            .build()
            .into();
        Self { ports, next: AtomicUsize::new(0), agent }
    }

    /// Whose turn it is, as a place among the services.
    fn turn(&self) -> usize {
        self.next.fetch_add(1, SeqCst)
    }

    /// The service at a place; after the last comes the first.
    fn port(&self, place: usize) -> u16 {
        self.ports[place % self.ports.len()]
    }

    /// Asks one service.
    pub fn ask(&self, port: u16, request: &Request<'_>, who: &[(&'static str, String)]) -> anyhow::Result<Outcome> {
        let mut head =
            http::Request::builder().method(request.method).uri(format!("http://127.0.0.1:{port}{}", request.path));
        for (name, value) in request.headers.iter().chain(who) {
            head = head.header(*name, value);
        }
        let begun = clock::instant();
        let answered = match request.body {
            [] if matches!(request.method, "GET" | "HEAD") => self.agent.run(head.body(())?),
            body => self.agent.run(head.body(body)?),
        };
        let broken = |why: String| Ok(Outcome::Broken { why, seconds: begun.elapsed().as_secs_f64() });
        match answered {
            Ok(response) => {
                let (parts, mut body) = response.into_parts();
                let body = match body.with_config().limit(u64::MAX).read_to_vec() {
                    Ok(body) => body,
                    Err(error) => return broken(error.to_string()),
                };
                let (status, seconds) = (parts.status.as_u16(), begun.elapsed().as_secs_f64());
                Ok(Outcome::Answered(Answer { status, headers: parts.headers, body, seconds }))
            }
            Err(ureq::Error::ConnectionFailed) => Ok(Outcome::Refused),
            Err(ureq::Error::Io(error)) if error.kind() == ErrorKind::ConnectionRefused => Ok(Outcome::Refused),
            Err(error) => broken(error.to_string()),
        }
    }
}

/// Somebody with a token, or with a browser's cookies.
#[derive(Clone, Debug)]
pub struct Client {
    proxy: Arc<Proxy>,
    ledger: Arc<Ledger>,
    address: String,
    /// A bearer token.
    pub token: Option<String>,
    cookies: BTreeMap<String, String>,
}

impl Client {
    /// Somebody at an address of their own.
    pub fn new(proxy: &Arc<Proxy>, ledger: &Arc<Ledger>, number: usize) -> Self {
        let address = format!("192.0.2.{}", number % 250 + 1);
        Self { proxy: Arc::clone(proxy), ledger: Arc::clone(ledger), address, token: None, cookies: BTreeMap::new() }
    }

    fn who(&self) -> Vec<(&'static str, String)> {
        // An answer to HEAD says how its body would be packed, and has none to unpack.
        let mut who = vec![("x-forwarded-for", self.address.clone()), ("accept-encoding", "identity".to_owned())];
        who.extend(self.token.as_ref().map(|token| ("authorization", format!("Bearer {token}"))));
        if !self.cookies.is_empty() {
            let cookies: Vec<String> = self.cookies.iter().map(|(name, value)| format!("{name}={value}")).collect();
            who.push(("cookie", cookies.join("; ")));
        }
        who
    }

    /// Forgets who they were.
    pub fn forget_cookies(&mut self) {
        self.cookies.clear();
    }

    /// Asks the service at a place, once.
    fn try_at(&mut self, place: usize, request: &Request<'_>) -> anyhow::Result<Outcome> {
        let outcome = self.proxy.ask(self.proxy.port(place), request, &self.who())?;
        if let Outcome::Answered(answer) = &outcome {
            for set in answer.headers.get_all("set-cookie") {
                let pair = set.to_str().unwrap_or_default().split(';').next().unwrap_or_default();
                if let Some((name, value)) = pair.split_once('=') {
                    self.cookies.insert(name.to_owned(), value.to_owned());
                }
            }
        }
        self.ledger.note_outcome(request.what, &outcome);
        Ok(outcome)
    }

    /// Asks until there is an answer that says more than to come again. None where the connection broke over what may not be sent
    /// twice.
    pub fn ask(&mut self, request: &Request<'_>) -> anyhow::Result<Option<Answer>> {
        let (mut refused, mut place) = (0, self.proxy.turn());
        for retries in 0..MOST_TRIES {
            let outcome = self.try_at(place, request)?;
            // Who comes again comes to the next.
            place += 1;
            match outcome {
                Outcome::Answered(answer) if !is_passing(answer.status) => {
                    self.ledger.note_retries(request.what, retries);
                    return Ok(Some(answer));
                }
                // Where the database does not answer, what was being committed may be there.
                Outcome::Answered(answer) if answer.status == 503 && !request.repeatable => {
                    thread::sleep(LONGEST_WAIT);
                    self.ledger.note_retries(request.what, retries);
                    return Ok(None);
                }
                Outcome::Answered(answer) => {
                    let asked = answer.header("retry-after").parse().map_or(LONGEST_WAIT, Duration::from_secs);
                    thread::sleep(asked.min(LONGEST_WAIT));
                }
                Outcome::Refused => {
                    refused += 1;
                    // All of them are away: a proxy would wait, too.
                    if self.proxy.ports.len() <= refused {
                        thread::sleep(Duration::from_millis(200));
                    }
                }
                Outcome::Broken { .. } if request.repeatable => {}
                Outcome::Broken { .. } => {
                    self.ledger.note_retries(request.what, retries);
                    return Ok(None);
                }
            }
        }
        bail!(
            "{} {} is not answered after {MOST_TRIES} tries: {}",
            request.method,
            request.path,
            self.ledger.latest(request.what)
        )
    }

    /// Asks for what only reads.
    pub fn get(&mut self, what: &'static str, path: &str) -> anyhow::Result<Answer> {
        self.ask(&Request::get(what, path))?.context("what only reads is asked for until it is answered")
    }

    /// Sends a form as a page of the service would.
    pub fn press(
        &mut self,
        what: &'static str,
        page: &str,
        form: (&str, &[(&str, &str)]),
    ) -> anyhow::Result<Option<Answer>> {
        let csrf = self.get("page", page)?.text();
        let csrf = csrf.split("name=\"csrf\" value=\"").nth(1).and_then(|rest| rest.split('"').next());
        let csrf = csrf.with_context(|| format!("{page} has no form"))?.to_owned();
        let (path, fields) = form;
        let mut body = format!("csrf={csrf}");
        for (name, value) in fields {
            body += &format!("&{name}={}", encode(value));
        }
        let headers = vec![("content-type", "application/x-www-form-urlencoded".to_owned())];
        self.ask(&Request { what, method: "POST", path, headers, body: body.as_bytes(), repeatable: false })
    }
}

/// Answers by which nothing was done and that ask for patience: another request is at it, or what is needed does not answer.
const fn is_passing(status: u16) -> bool {
    matches!(status, 423 | 429 | 502 | 503 | 504 | 507)
}

/// A value within a form.
fn encode(value: &str) -> String {
    let mut encoded = String::new();
    for byte in value.bytes() {
        match byte {
            b'a'..=b'z' | b'A'..=b'Z' | b'0'..=b'9' | b'-' | b'_' | b'.' => encoded.push(char::from(byte)),
            _ => encoded += &format!("%{byte:02X}"),
        }
    }
    encoded
}
