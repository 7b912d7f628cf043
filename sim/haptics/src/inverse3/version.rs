//! The service's version, which determines the spelling of a force command. The service reports it
//! over plain HTTP: on the port of its WebSocket according to the documentation of 3.5, on 10000
//! according to that of 3.0.

use std::io::{Read, Write};
use std::net::{SocketAddr, TcpStream};
use std::time::Duration;

use serde::Deserialize;

use super::command::Dialect;

/// Time-out of the request.
const PATIENCE: Duration = Duration::from_millis(500);
/// Maximum size of the response, more than a version needs.
const MOST_BYTES: u64 = 16 << 10;

/// A version of the service.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Version {
    /// The version text as reported.
    pub text: String,
    major: u32,
    minor: u32,
}

#[derive(Default, Deserialize)]
#[serde(default)]
struct Said {
    git_tag: String,
    git_describe: String,
    project_version: String,
    data: Option<Box<Said>>,
}

impl Said {
    fn words(self) -> Option<String> {
        let own = [self.git_tag, self.git_describe, self.project_version].into_iter().find(|words| !words.is_empty());
        own.or_else(|| self.data.and_then(|data| data.words()))
    }
}

impl Version {
    /// Requests the version on the port of the WebSocket and then on another; `None` if neither
    /// responds with one.
    pub fn ask(address: SocketAddr, other_port: u16) -> Option<Self> {
        Self::asked(address).or_else(|| Self::asked(SocketAddr::new(address.ip(), other_port)))
    }

    fn asked(address: SocketAddr) -> Option<Self> {
        let mut stream = TcpStream::connect_timeout(&address, PATIENCE).ok()?;
        stream.set_read_timeout(Some(PATIENCE)).ok()?;
        stream.write_all(b"GET /version HTTP/1.0\r\nHost: localhost\r\nConnection: close\r\n\r\n").ok()?;
        let mut answer = Vec::new();
        // A response is valid even if the server keeps the connection open after it.
        let _kept_open = stream.take(MOST_BYTES).read_to_end(&mut answer);
        Self::in_answer(&String::from_utf8_lossy(&answer))
    }

    fn in_answer(answer: &str) -> Option<Self> {
        let (head, body) = answer.split_once("\r\n\r\n")?;
        let ok = head.lines().next()?.contains(" 200");
        let json = body.get(body.find('{')?..=body.rfind('}')?)?;
        let said: Said = serde_json::from_str(json).ok()?;
        said.words().filter(|_| ok).and_then(|words| Self::parse(&words))
    }

    /// Parses `3.5.0`, `v3.4.1-2-gce34c39e` and similar.
    fn parse(words: &str) -> Option<Self> {
        let mut numbers = words.trim_start_matches('v').split(['.', '-']).map(str::parse);
        let (major, minor) = (numbers.next()?.ok()?, numbers.next()?.ok()?);
        Some(Self { text: words.to_owned(), major, minor })
    }

    /// The spelling of a force command; `None` if the protocol is incompatible.
    pub fn dialect(&self) -> Option<Dialect> {
        match (self.major, self.minor) {
            (0..=2, _) => None,
            (3, 0..=4) => Some(Dialect::Values),
            _ => Some(Dialect::Vector),
        }
    }
}
