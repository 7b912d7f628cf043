//! The CSRF token of anonymous visitors, as a double-submit cookie: the cookie and the form must
//! contain the same token. Nothing is stored on the server for them.

use std::sync::{Arc, OnceLock};

use acts::error::Error;
use axum::extract::{FromRequestParts, Request, State};
use axum::http::header::{COOKIE, SET_COOKIE};
use axum::http::request::Parts;
use axum::http::{HeaderMap, HeaderValue};
use axum::middleware::Next;
use axum::response::Response;
use platform::secret;
use tower_sessions::cookie::{Cookie, SameSite};

use crate::AppState;
use crate::error::PageError;

/// Number of hexadecimal digits of a token.
const DIGITS: usize = 64;

/// The token of a browser that is not signed in.
#[derive(Clone, Debug, Default)]
pub struct StrangerToken {
    sent: Option<String>,
    made: Arc<OnceLock<String>>,
}

impl StrangerToken {
    /// Returns the token of the browser's cookie; if it has none, generates one, which the response
    /// then sets.
    ///
    /// # Errors
    /// When the operating system's random source fails.
    pub(super) fn token(&self) -> Result<String, Error> {
        if let Some(known) = self.sent.as_ref().or_else(|| self.made.get()) {
            return Ok(known.clone());
        }
        let made = secret::random_hex()?;
        Ok(self.made.get_or_init(|| made).clone())
    }

    /// Whether a form's token matches that of the cookie.
    pub(super) fn is(&self, sent: &str) -> bool {
        self.sent.as_ref().is_some_and(|known| secret::same(known, sent))
    }
}

/// The token of a browser's cookie: it ties a sign-in at a provider to the browser that began it.
#[derive(Clone, Debug)]
pub struct BrowserToken {
    token: String,
    is_sent: bool,
}

impl BrowserToken {
    /// Returns the token, which the response sets if the browser has none.
    #[must_use]
    pub fn text(&self) -> &str {
        &self.token
    }

    /// Returns the token that the browser has sent.
    #[must_use]
    pub fn sent(&self) -> Option<&str> {
        self.is_sent.then_some(self.token.as_str())
    }
}

impl<S: Send + Sync> FromRequestParts<S> for BrowserToken {
    type Rejection = PageError;

    async fn from_request_parts(parts: &mut Parts, _: &S) -> Result<Self, Self::Rejection> {
        let stranger = parts.extensions.get::<StrangerToken>().cloned().unwrap_or_default();
        Ok(Self { token: stranger.token()?, is_sent: stranger.sent.is_some() })
    }
}

/// Behind TLS bound to this exact host, so that no neighbouring subdomain can set it.
const fn cookie_name(behind_tls: bool) -> &'static str {
    if behind_tls { "__Host-stylet_form" } else { "stylet_form" }
}

/// Reads the cookie, and sets it if a token was generated for a browser without one.
pub async fn settle_stranger(State(state): State<AppState>, mut request: Request, next: Next) -> Response {
    let name = cookie_name(state.config.behind_tls);
    let token = StrangerToken { sent: token_sent(request.headers(), name), ..StrangerToken::default() };
    request.extensions_mut().insert(token.clone());
    let mut response = next.run(request).await;
    if let Some(made) = token.made.get() {
        let cookie = Cookie::build((name, made.as_str()))
            .path("/")
            .http_only(true)
            .same_site(SameSite::Lax)
            .secure(state.config.behind_tls);
        // Hexadecimal digits are always a valid header value.
        if let Ok(cookie) = HeaderValue::from_str(&cookie.to_string()) {
            response.headers_mut().append(SET_COOKIE, cookie);
        }
    }
    response
}

fn token_sent(headers: &HeaderMap, name: &str) -> Option<String> {
    let all = headers.get_all(COOKIE).iter().filter_map(|header| header.to_str().ok());
    let mut cookies = all.flat_map(Cookie::split_parse).flatten();
    let value = cookies.find(|cookie| cookie.name() == name)?.value().to_owned();
    let is_token = value.len() == DIGITS && value.bytes().all(|digit| digit.is_ascii_hexdigit());
    is_token.then_some(value)
}
