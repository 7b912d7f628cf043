//! Access to the service: its address, its responses, and their meaning for a delivery.

use std::fmt::Display;
use std::io::Read;
use std::time::Duration;

use serde_json::Value;
use ureq::Agent;
use ureq::http::{HeaderMap, HeaderValue, Response, Uri};

/// Maximum number of bytes read of a response: a session or a problem is far smaller.
const LARGEST_ANSWER: u64 = 1 << 20;
/// Timeout for a connection, for each write, and for the response after the request is sent.
const PATIENCE: Duration = Duration::from_secs(30);

/// A service, and this station's token for it.
#[derive(Clone)]
pub struct Service {
    pub agent: Agent,
    /// Address without a trailing slash.
    pub address: String,
    pub token: HeaderValue,
}

impl Service {
    /// A service at an address.
    pub fn new(address: &str, token: HeaderValue) -> Self {
        Self { agent: http_agent(), address: address.trim_end_matches('/').to_owned(), token }
    }
}

/// Whether a retry may succeed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Outlook {
    /// A retry may succeed soon.
    Soon,
    /// A retry can succeed only after a change by the user or an administrator; the recording
    /// itself is not at fault.
    Later,
    /// The service will never accept this recording.
    Never,
    /// This recording must not be kept: the person was erased, has withdrawn, or never consented.
    Unwanted,
}

/// Why a delivery failed.
#[derive(Clone, Debug)]
pub struct Trouble {
    /// Whether a retry may succeed.
    pub outlook: Outlook,
    /// HTTP status; `None` without a response.
    pub status: Option<u16>,
    /// Explanation for the user.
    pub detail: String,
}

impl Trouble {
    /// An error without a response.
    pub fn new(outlook: Outlook, detail: impl Display) -> Self {
        Self { outlook, status: None, detail: detail.to_string() }
    }
}

/// A response with its body.
pub struct Reply {
    /// HTTP status.
    pub status: u16,
    headers: HeaderMap,
    text: String,
}

impl Reply {
    /// Returns the text of a header.
    pub fn header(&self, name: &str) -> Option<&str> {
        self.headers.get(name)?.to_str().ok()
    }

    /// Returns the body, if it is a JSON object.
    pub fn json(&self) -> Option<Value> {
        serde_json::from_str(&self.text).ok().filter(Value::is_object)
    }

    /// Describes the response for the user.
    pub fn words(&self) -> String {
        format!("HTTP {}: {}", self.status, explain_refusal(self.status, self.json().as_ref()))
    }

    /// Whether the service reports that the token has expired.
    fn says_expired(&self) -> bool {
        let detail = self.json().and_then(|body| body.get("detail").and_then(Value::as_str).map(str::to_owned));
        detail.is_some_and(|detail| detail.contains("expired"))
    }

    /// Converts an unexpected response to an error.
    pub fn trouble(&self) -> Trouble {
        let outlook = match self.status {
            // 460 is a checksum mismatch in tus.
            408 | 423 | 425 | 429 | 460 | 500.. => Outlook::Soon,
            409 | 413 | 415 | 422 => Outlook::Never,
            451 => Outlook::Unwanted,
            _ => Outlook::Later,
        };
        let advice = match self.status {
            401 if self.says_expired() => "; recordings are kept here until you provide another token (--token-file)",
            401 => "; pair this station again (stylet pair), or use another token",
            409 | 413 | 415 | 422 => "; rejected permanently",
            451 => "; deleted here",
            _ => "",
        };
        Trouble { outlook, status: Some(self.status), detail: self.words() + advice }
    }
}

/// Reads the response to a request.
pub fn ask_service(address: &str, asked: Result<Response<ureq::Body>, ureq::Error>) -> Result<Reply, Trouble> {
    let mut response = asked.map_err(|error| no_answer(address, &error))?;
    let mut text = String::new();
    // An explanation that cannot be read to its end is cut.
    let _ = response.body_mut().as_reader().take(LARGEST_ANSWER).read_to_string(&mut text);
    Ok(Reply { status: response.status().as_u16(), headers: response.headers().clone(), text })
}

/// Creates the HTTP agent. It follows no redirects: a redirect to a sign-in page is a response, not
/// an address for recordings or tokens.
pub fn http_agent() -> Agent {
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
    config.into()
}

/// Returns the service's explanation (RFC 9457 problem details), or our own if it has none.
fn explain_refusal(status: u16, body: Option<&Value>) -> String {
    let member = |name: &str| body.and_then(|body| body.get(name)).and_then(Value::as_str);
    let ours = match status {
        200..=299 => "unexpected response; is this the address of the service?",
        300..=399 => "the service redirects to another address; is this the address of the service?",
        401 => "the token is missing, unknown, expired or revoked",
        403 => "the token has no permission for this",
        404 | 405 => "not found; is this the address of the service?",
        409 => "the service already has another recording of this session",
        413 => "the recording is larger than the service allows",
        422 => "the service cannot process this recording",
        424 => "the service has quarantined this recording",
        423 => "another program is sending this recording",
        429 => "too many requests; the service asks for a pause",
        451 => "this recording must not be stored",
        460 => "the chunk was damaged in transit",
        500.. => "the service has an internal error",
        _ => "unexpected response",
    };
    match (member("title"), member("detail")) {
        (Some(title), Some(detail)) if title != detail => format!("{title}: {detail}"),
        (_, Some(text)) | (Some(text), None) => text.to_owned(),
        (None, None) => ours.to_owned(),
    }
}

fn no_answer(address: &str, error: &ureq::Error) -> Trouble {
    // An invalid address or a TLS error will not resolve itself soon.
    let hopeless = matches!(error, ureq::Error::BadUri(_) | ureq::Error::InvalidProxyUrl | ureq::Error::Tls(_));
    Trouble::new(if hopeless { Outlook::Later } else { Outlook::Soon }, format_args!("{address}: {error}"))
}

/// Parses an address with a scheme and a host, to which `/api/v1/…` can be appended.
pub fn parse_server_address(text: &str) -> Result<Uri, String> {
    let uri: Uri = text.parse().map_err(|error| format!("{error}; allowed: an address such as https://example.org"))?;
    match (uri.scheme_str(), uri.host(), uri.query()) {
        (Some("http" | "https"), Some(_), None) => Ok(uri),
        _ => Err("allowed: http://HOST or https://HOST, optionally with :PORT and a path".to_owned()),
    }
}

/// Whether secrets sent to this address leave the machine unencrypted.
pub fn is_in_the_clear(server: &Uri) -> bool {
    let local = matches!(server.host(), Some("localhost" | "127.0.0.1" | "[::1]"));
    server.scheme_str() == Some("http") && !local
}

/// A bearer token as a header value; `None` if it is not one word of printable ASCII.
pub fn bearer_header(token: &str) -> Option<HeaderValue> {
    let valid = !token.is_empty() && token.chars().all(|c| c.is_ascii_graphic());
    let mut value = HeaderValue::from_str(&format!("Bearer {token}")).ok().filter(|_| valid)?;
    value.set_sensitive(true);
    Some(value)
}

#[cfg(test)]
mod tests {
    //! Fails if an error of a pending entry does not explain what the user can do about it.

    use super::*;

    #[test]
    fn an_expired_token_is_told_and_nothing_is_lost() {
        let said = |detail: &str| {
            let text = serde_json::json!({ "title": "Unauthorized", "status": 401, "detail": detail }).to_string();
            Reply { status: 401, headers: HeaderMap::new(), text }.trouble()
        };
        let ended = said("this token expired at 2026-01-01T00:00:00Z");
        assert_eq!(ended.outlook, Outlook::Later, "the recording waits");
        assert!(
            ended.detail.contains("expired at 2026-01-01") && ended.detail.contains("--token-file"),
            "{}",
            ended.detail
        );
        assert!(!ended.detail.contains("pair"), "{}", ended.detail);
        assert!(said("a bearer token is needed").detail.contains("stylet pair"));
    }
}
