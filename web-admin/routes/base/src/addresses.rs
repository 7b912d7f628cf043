//! Addresses: ids and text in them, and the public address of the service.

use acts::error::Error;
use axum::extract::{FromRequestParts, Path};
use axum::http::request::Parts;
use axum::http::{HeaderMap, header};
use percent_encoding::{NON_ALPHANUMERIC, PercentEncode, utf8_percent_encode};
use serde::de::DeserializeOwned;

use crate::AppState;
use crate::error::PageError;

/// Encodes a text for use in a query: every reserved character is escaped.
#[must_use]
pub fn encode_in_query(text: &str) -> PercentEncode<'_> {
    utf8_percent_encode(text, NON_ALPHANUMERIC)
}

/// Returns the public address of this service: the configured one, else that of the visitor's
/// request.
#[must_use]
pub fn own_address(state: &AppState, headers: &HeaderMap) -> String {
    if let Some(told) = &state.config.public_url {
        return told.clone();
    }
    let scheme = if state.config.behind_tls { "https" } else { "http" };
    let host = headers.get(header::HOST).and_then(|host| host.to_str().ok()).unwrap_or("localhost");
    format!("{scheme}://{host}")
}

/// The id in an address. A malformed id is answered like an unknown one, with 404.
#[derive(Clone, Copy, Debug)]
pub struct PathId<T>(pub T);

impl<T: DeserializeOwned + Send, S: Send + Sync> FromRequestParts<S> for PathId<T> {
    type Rejection = PageError;

    async fn from_request_parts(parts: &mut Parts, state: &S) -> Result<Self, Self::Rejection> {
        let path = Path::<T>::from_request_parts(parts, state).await;
        path.map(|Path(id)| Self(id)).map_err(|_| PageError(Error::NotFound))
    }
}
