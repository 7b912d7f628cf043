//! Conditional requests (RFC 9110, section 13).

use axum::http::header::{CACHE_CONTROL, ETAG, IF_NONE_MATCH};
use axum::http::{HeaderMap, StatusCode};
use axum::response::{IntoResponse, Response};

/// Returns 304 if the client has the content with this entity tag.
#[must_use]
pub fn answer_not_modified(asked: &HeaderMap, tag: &str, caching: &str) -> Option<Response> {
    let is_known = asked.get(IF_NONE_MATCH).is_some_and(|known| known.as_bytes() == tag.as_bytes());
    is_known.then(|| (StatusCode::NOT_MODIFIED, [(ETAG, tag), (CACHE_CONTROL, caching)]).into_response())
}
