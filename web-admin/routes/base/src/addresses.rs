//! Addresses: ids in them, texts in them, and the address of the service.

use acts::error::Error;
use axum::extract::{FromRequestParts, Path};
use axum::http::request::Parts;
use axum::http::{HeaderMap, header};
use percent_encoding::{NON_ALPHANUMERIC, PercentEncode, utf8_percent_encode};
use serde::de::DeserializeOwned;

use crate::AppState;
use crate::error::PageError;

/// A text as a part of an address: nothing in it ends its place.
#[must_use]
pub fn encode_in_query(text: &str) -> PercentEncode<'_> {
    utf8_percent_encode(text, NON_ALPHANUMERIC)
}

/// How this service is called from outside: as it was told, or else as the visitor calls it.
#[must_use]
pub fn own_address(state: &AppState, headers: &HeaderMap) -> String {
    if let Some(told) = &state.config.public_url {
        return told.clone();
    }
    let scheme = if state.config.behind_tls { "https" } else { "http" };
    let host = headers.get(header::HOST).and_then(|host| host.to_str().ok()).unwrap_or("localhost");
    format!("{scheme}://{host}")
}

/// The id in an address. What is no id names nothing: 404, as an id that nobody has.
#[derive(Clone, Copy, Debug)]
pub struct PathId<T>(pub T);

impl<T: DeserializeOwned + Send, S: Send + Sync> FromRequestParts<S> for PathId<T> {
    type Rejection = PageError;

    async fn from_request_parts(parts: &mut Parts, state: &S) -> Result<Self, Self::Rejection> {
        let path = Path::<T>::from_request_parts(parts, state).await;
        path.map(|Path(id)| Self(id)).map_err(|_| PageError(Error::NotFound))
    }
}
