//! The token in a stranger's forms. Nothing of it is kept here: it stands in a cookie and in the form, and both must say the same
//! (double submit). Whoever only looks writes no row.

use std::sync::{Arc, OnceLock};

use acts::error::Error;
use acts::secret;
use axum::extract::{Request, State};
use axum::http::header::{COOKIE, SET_COOKIE};
use axum::http::{HeaderMap, HeaderValue};
use axum::middleware::Next;
use axum::response::Response;
use tower_sessions::cookie::{Cookie, SameSite};

use crate::AppState;

/// Digits of a token.
const DIGITS: usize = 64;

/// The token of a browser in which nobody is signed in.
#[derive(Clone, Debug, Default)]
pub struct StrangerToken {
    sent: Option<String>,
    made: Arc<OnceLock<String>>,
}

impl StrangerToken {
    /// That of the browser's cookie; made where there is none, which the answer then sets.
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

    /// Whether a form holds what the cookie does.
    pub(super) fn is(&self, sent: &str) -> bool {
        self.sent.as_ref().is_some_and(|known| secret::same(known, sent))
    }
}

/// Of this very host, behind TLS: no neighbouring name can plant it.
const fn cookie_name(behind_tls: bool) -> &'static str {
    if behind_tls { "__Host-stylet_form" } else { "stylet_form" }
}

/// Reads the cookie, and sets it where a form was made for a browser that had none.
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
        // Hexadecimal digits are always a header.
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
