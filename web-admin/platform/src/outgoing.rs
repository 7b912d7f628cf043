//! Requests to addresses that a school's administrators have entered. Such an address may be
//! hostile, so each request is limited in target, time and size, and no redirect is followed.

use std::collections::BTreeMap;
use std::io::{self, ErrorKind};
use std::net::{IpAddr, Ipv6Addr};
use std::num::NonZeroU32;
use std::sync::{Arc, Mutex, PoisonError, Weak};
use std::time::Duration;

use governor::{DefaultKeyedRateLimiter, RateLimiter};
use http::header::{ACCEPT, AUTHORIZATION, CONTENT_TYPE, LINK, LOCATION};
use http::{Method, Request, Uri};
use model::ids::SchoolId;
use tokio::sync::{Mutex as AsyncMutex, Semaphore};
use ureq::config::Config as AgentConfig;
use ureq::unversioned::resolver::{DefaultResolver, ResolvedSocketAddrs, Resolver};
use ureq::unversioned::transport::{DefaultConnector, NextTimeout};
use ureq::{Agent, Error as HttpError};
use url::{Url, form_urlencoded};

use crate::rate_limit_log::quota;

/// Timeout for a connection.
const CONNECT_TIMEOUT: Duration = Duration::from_secs(5);
/// Timeout for a request, from the lookup of the name to the last byte.
const TIMEOUT: Duration = Duration::from_secs(10);
/// Maximum size of an answer, in bytes.
const LARGEST_ANSWER: u64 = 256 * 1024;
/// Maximum number of concurrent requests.
const MOST_AT_ONCE: usize = 32;
/// Maximum number of documents that a school reads from one host at once; then one every three
/// seconds.
const DOCUMENTS: NonZeroU32 = NonZeroU32::new(20).expect("not zero");
const DOCUMENT_PERIOD: Duration = Duration::from_secs(3);
/// Maximum number of requests of a school to the services of one host at once; then five a second.
const SERVICE_REQUESTS: NonZeroU32 = NonZeroU32::new(100).expect("not zero");
const SERVICE_PERIOD: Duration = Duration::from_millis(200);

/// Permitted targets of outgoing requests. By default only `https` and public addresses.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct OutgoingRules {
    /// Hosts, as `HOST:PORT`, to which requests without TLS are permitted.
    pub plain_http: Vec<String>,
    /// Requests to loopback, private and link-local addresses are permitted.
    pub private_addresses: bool,
}

impl OutgoingRules {
    /// Checks an address.
    ///
    /// # Errors
    /// Returns [`CallFailed::Address`] with the reason, in English.
    pub fn check(&self, address: &str) -> Result<Url, CallFailed> {
        let url = Url::parse(address).map_err(|error| CallFailed::Address(error.to_string()))?;
        let host = url.host_str().ok_or_else(|| CallFailed::Address("no host".to_owned()))?;
        let port = url.port_or_known_default().unwrap_or_default();
        let is_permitted = match url.scheme() {
            "https" => true,
            "http" => self.plain_http.contains(&format!("{host}:{port}")),
            _ => false,
        };
        match is_permitted && url.username().is_empty() && url.password().is_none() {
            true => Ok(url),
            false => Err(CallFailed::Address("only https is permitted, without a user name".to_owned())),
        }
    }
}

/// A request.
#[derive(Clone, Debug)]
pub struct Call {
    /// Address, checked by [`OutgoingRules::check`].
    pub url: Url,
    /// Value of the header `Authorization`.
    pub authorization: Option<String>,
    /// Media type of the answer: the header `Accept`.
    pub accept: &'static str,
    /// Another header.
    pub header: Option<(&'static str, String)>,
    /// What to post; `None` for a GET request.
    pub content: Option<Content>,
    /// Maximum size of the answer, in bytes.
    pub largest_answer: u64,
}

impl Call {
    /// Creates a GET request for JSON.
    #[must_use]
    pub const fn get(url: Url) -> Self {
        let accept = "application/json";
        Self { url, authorization: None, accept, header: None, content: None, largest_answer: LARGEST_ANSWER }
    }

    /// Creates a POST request.
    #[must_use]
    pub fn post(url: Url, content: Content) -> Self {
        Self { content: Some(content), ..Self::get(url) }
    }

    /// Sets the header `Authorization`.
    #[must_use]
    pub fn with_authorization(self, authorization: Option<String>) -> Self {
        Self { authorization, ..self }
    }

    /// Adds a header.
    #[must_use]
    pub fn with_header(self, name: &'static str, value: String) -> Self {
        Self { header: Some((name, value)), ..self }
    }
}

/// The body of a request.
#[derive(Clone, Debug)]
pub struct Content {
    /// Media type.
    pub media_type: &'static str,
    /// Body.
    pub body: Vec<u8>,
}

impl Content {
    /// Encodes the fields of a form.
    #[must_use]
    pub fn of_form(fields: &[(&str, String)]) -> Self {
        let body = form_urlencoded::Serializer::new(String::new()).extend_pairs(fields).finish().into_bytes();
        Self { media_type: "application/x-www-form-urlencoded", body }
    }
}

/// An answer.
#[derive(Clone, Debug)]
pub struct Answer {
    /// HTTP status.
    pub status: u16,
    /// Target of a redirect, which was not followed.
    pub location: Option<String>,
    /// Links to other pages: the headers `Link`, separated by commas.
    pub link: Option<String>,
    /// Whether the body is declared to be JSON.
    pub is_json: bool,
    /// Body.
    pub body: Vec<u8>,
}

/// Why a request was not answered.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum CallFailed {
    /// The address is not permitted.
    #[error("the address is not permitted: {0}")]
    Address(String),
    /// Too many requests to this host.
    #[error("too many requests to this host; try again in a minute")]
    TooMany,
    /// No complete answer in time and within the limit of size.
    #[error("{0}")]
    NoAnswer(String),
}

/// Sends requests.
#[derive(Clone, Debug)]
pub struct OutgoingClient {
    agent: Agent,
    rules: OutgoingRules,
    places: Arc<Semaphore>,
    documents: Arc<DefaultKeyedRateLimiter<CalledHost>>,
    service_requests: Arc<DefaultKeyedRateLimiter<CalledHost>>,
    turns: Arc<Mutex<BTreeMap<String, Weak<AsyncMutex<()>>>>>,
}

/// Waiting requests for one document: the first fetches it, the others use the result.
pub type DocumentTurn = Arc<AsyncMutex<()>>;

/// A school, and a host to which it sends requests.
type CalledHost = (SchoolId, String);

/// Counts a request to a host.
fn count(limiter: &DefaultKeyedRateLimiter<CalledHost>, school: SchoolId, url: &Url) -> Result<(), CallFailed> {
    let host = url.host_str().unwrap_or_default().to_owned();
    limiter.retain_recent();
    limiter.check_key(&(school, host)).map_err(|_| CallFailed::TooMany)
}

impl OutgoingClient {
    /// Creates a client.
    #[must_use]
    pub fn new(rules: OutgoingRules) -> Self {
        let config = Agent::config_builder()
            .http_status_as_error(false)
            .max_redirects(0)
            .max_redirects_will_error(false)
            // A proxy from the environment would look names up by itself.
            .proxy(None)
            .timeout_connect(Some(CONNECT_TIMEOUT))
            .timeout_global(Some(TIMEOUT))
            .user_agent(concat!("Stylet/", env!("CARGO_PKG_VERSION")))
            .build();
        let resolver = PublicResolver { private_addresses: rules.private_addresses, names: DefaultResolver::default() };
        Self {
            agent: Agent::with_parts(config, DefaultConnector::default(), resolver),
            rules,
            places: Arc::new(Semaphore::new(MOST_AT_ONCE)),
            documents: Arc::new(RateLimiter::keyed(quota(DOCUMENT_PERIOD, DOCUMENTS))),
            service_requests: Arc::new(RateLimiter::keyed(quota(SERVICE_PERIOD, SERVICE_REQUESTS))),
            turns: Arc::default(),
        }
    }

    /// Returns the permitted targets.
    #[must_use]
    pub const fn rules(&self) -> &OutgoingRules {
        &self.rules
    }

    /// Counts a request of a school for a document, such as a key set. Visitors who are not signed in
    /// can cause it.
    ///
    /// # Errors
    /// Returns [`CallFailed::TooMany`] if there were too many to this host.
    pub fn count_document(&self, school: SchoolId, url: &Url) -> Result<(), CallFailed> {
        count(&self.documents, school, url)
    }

    /// Counts a request of a school to a service to which it sends records, one after another.
    ///
    /// # Errors
    /// Returns [`CallFailed::TooMany`] if there were too many to this host.
    pub fn count_service_request(&self, school: SchoolId, url: &Url) -> Result<(), CallFailed> {
        count(&self.service_requests, school, url)
    }

    /// Returns the turn of a document, to be locked while it is fetched.
    #[must_use]
    pub fn document_turn(&self, address: &str) -> DocumentTurn {
        // A poisoned lock is harmless: each operation leaves the map valid.
        let mut turns = self.turns.lock().unwrap_or_else(PoisonError::into_inner);
        turns.retain(|_, turn| turn.strong_count() > 0);
        if let Some(turn) = turns.get(address).and_then(Weak::upgrade) {
            return turn;
        }
        let turn = DocumentTurn::default();
        turns.insert(address.to_owned(), Arc::downgrade(&turn));
        turn
    }

    /// Sends a request and reads the answer, in at most ten seconds.
    ///
    /// # Errors
    /// Returns [`CallFailed`] with the reason, in English. Failures are logged by host, without
    /// the path, which may contain a secret.
    pub async fn send(&self, call: Call) -> Result<Answer, CallFailed> {
        let host = call.url.host_str().unwrap_or_default().to_owned();
        let agent = self.agent.clone();
        let places = Arc::clone(&self.places);
        let waiting = tokio::time::timeout(TIMEOUT, places.acquire_owned());
        let answered = match waiting.await {
            Ok(Ok(place)) => tokio::task::spawn_blocking(move || {
                let _place = place;
                send_blocking(&agent, call)
            })
            .await
            .unwrap_or_else(|error| Err(CallFailed::NoAnswer(error.to_string()))),
            _ => Err(CallFailed::NoAnswer("too many requests are waiting".to_owned())),
        };
        match &answered {
            Ok(answer) if answer.status < 400 => {}
            Ok(answer) => tracing::warn!(host, status = answer.status, "outgoing request refused"),
            Err(error) => tracing::warn!(host, %error, "outgoing request failed"),
        }
        answered
    }
}

fn send_blocking(agent: &Agent, call: Call) -> Result<Answer, CallFailed> {
    let mut request = Request::builder().uri(call.url.as_str()).header(ACCEPT, call.accept);
    if let Some(authorization) = &call.authorization {
        request = request.header(AUTHORIZATION, authorization);
    }
    if let Some((name, value)) = &call.header {
        request = request.header(*name, value);
    }
    let malformed = |error: http::Error| CallFailed::Address(error.to_string());
    let answered = match call.content {
        None => agent.run(request.body(()).map_err(malformed)?),
        Some(content) => {
            let request = request.method(Method::POST).header(CONTENT_TYPE, content.media_type);
            agent.run(request.body(content.body).map_err(malformed)?)
        }
    };
    let mut answer = answered.map_err(|error| failure_of(&error))?;
    let headers = |name| answer.headers().get_all(name).iter().filter_map(|value| value.to_str().ok());
    let location = headers(LOCATION).next().map(str::to_owned);
    let links: Vec<_> = headers(LINK).collect();
    let link = Some(links.join(", ")).filter(|links| !links.is_empty());
    let is_json = headers(CONTENT_TYPE).any(|kind| kind.to_ascii_lowercase().contains("json"));
    let body = answer.body_mut().with_config().limit(call.largest_answer).read_to_vec();
    let body = body.map_err(|error| failure_of(&error))?;
    Ok(Answer { status: answer.status().as_u16(), location, link, is_json, body })
}

fn failure_of(error: &HttpError) -> CallFailed {
    match error {
        HttpError::Io(io) if io.kind() == ErrorKind::PermissionDenied => CallFailed::Address(io.to_string()),
        HttpError::BodyExceedsLimit(limit) => CallFailed::NoAnswer(format!("the answer exceeds {limit} bytes")),
        error => CallFailed::NoAnswer(error.to_string()),
    }
}

/// Looks names up once, and refuses addresses that are not public: the connection goes to an
/// address that was checked.
#[derive(Debug)]
struct PublicResolver {
    private_addresses: bool,
    names: DefaultResolver,
}

impl Resolver for PublicResolver {
    fn resolve(&self, uri: &Uri, config: &AgentConfig, timeout: NextTimeout) -> Result<ResolvedSocketAddrs, HttpError> {
        let found = self.names.resolve(uri, config, timeout)?;
        if self.private_addresses || found.iter().all(|address| is_public(address.ip())) {
            return Ok(found);
        }
        let why = "the name leads to an address that is not public";
        Err(HttpError::Io(io::Error::new(ErrorKind::PermissionDenied, why)))
    }
}

/// Returns whether an address belongs to the public internet (the special-purpose registries of
/// IANA, RFC 6890).
fn is_public(address: IpAddr) -> bool {
    match address {
        IpAddr::V4(v4) => {
            let [a, b, c, _] = v4.octets();
            !(v4.is_private()
                || v4.is_loopback()
                || v4.is_link_local()
                || v4.is_multicast()
                || v4.is_documentation()
                || matches!((a, b, c), (0 | 240..=255, _, _) | (100, 64..=127, _) | (192, 0, 0) | (198, 18 | 19, _)))
        }
        IpAddr::V6(v6) => is_public_v6(v6),
    }
}

fn is_public_v6(v6: Ipv6Addr) -> bool {
    let [a, b, c, d, e, f, g, h] = v6.segments();
    let v4 = |high: u16, low: u16| IpAddr::from((u32::from(high) << 16 | u32::from(low)).to_be_bytes());
    match (a, b) {
        // Mapped, compatible and translated IPv4 addresses, and 6to4.
        (0, 0) if (c, d, e) == (0, 0, 0) && matches!(f, 0 | 0xFFFF) => g != 0 && is_public(v4(g, h)),
        (0x64, 0xFF9B) => is_public(v4(g, h)),
        (0x2002, _) => is_public(v4(b, c)),
        (0x2001, 0xDB8) => false,
        _ => (0x2000..0x4000).contains(&a),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_public_addresses_are_public() {
        for public in ["8.8.8.8", "193.99.144.80", "2a02:2e0:3fe:1001:302::", "::ffff:8.8.8.8", "64:ff9b::8.8.8.8"] {
            assert!(is_public(public.parse().unwrap()), "{public}");
        }
        for other in [
            "127.0.0.1",
            "10.1.2.3",
            "172.16.0.1",
            "192.168.1.1",
            "169.254.169.254",
            "100.64.0.1",
            "0.0.0.0",
            "224.0.0.1",
            "255.255.255.255",
            "198.18.0.1",
            "::1",
            "::",
            "fe80::1",
            "fd00::1",
            "ff02::1",
            "::ffff:127.0.0.1",
            "::127.0.0.1",
            "64:ff9b::10.0.0.1",
            "2002:7f00:1::",
            "2001:db8::1",
        ] {
            assert!(!is_public(other.parse().unwrap()), "{other}");
        }
    }

    #[test]
    fn only_https_and_listed_hosts_are_permitted() {
        let rules = OutgoingRules { plain_http: vec!["127.0.0.1:9000".to_owned()], private_addresses: true };
        for good in ["https://login.example.edu/x", "http://127.0.0.1:9000/keys"] {
            assert!(rules.check(good).is_ok(), "{good}");
        }
        for bad in [
            "http://127.0.0.1:9001/",
            "http://login.example.edu/",
            "file:///etc/passwd",
            "ftp://a.example/",
            "https://user@a.example/",
            "https://a:b@a.example/",
            "login.example.edu",
            "",
        ] {
            assert!(matches!(rules.check(bad), Err(CallFailed::Address(_))), "{bad}");
        }
    }

    #[tokio::test]
    async fn a_name_that_leads_to_loopback_is_refused() {
        let client =
            OutgoingClient::new(OutgoingRules { plain_http: vec!["localhost:9".to_owned()], ..Default::default() });
        let url = client.rules().check("http://localhost:9/").unwrap();
        let refused = client.send(Call::get(url)).await.unwrap_err();
        assert!(matches!(refused, CallFailed::Address(_)), "{refused}");
    }
}
