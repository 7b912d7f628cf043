//! Uploads from a browser, by pages of another origin that the service was told to allow.
//!
//! Such a page brings a token. No cookie is ever taken from it: `Access-Control-Allow-Credentials` is never said.

use axum::extract::{Request, State};
use axum::http::{HeaderName, HeaderValue, header};
use axum::middleware::Next;
use axum::response::Response;

use crate::AppState;

/// What a page may be told of an allowed origin.
const SHARED: [(HeaderName, &str); 4] = [
    (header::ACCESS_CONTROL_ALLOW_METHODS, "POST, HEAD, PATCH, DELETE"),
    (
        header::ACCESS_CONTROL_ALLOW_HEADERS,
        "authorization, content-type, tus-resumable, upload-checksum, upload-length, upload-metadata, upload-offset, \
         x-http-method-override, x-requested-with",
    ),
    (
        header::ACCESS_CONTROL_EXPOSE_HEADERS,
        "location, stylet-session, tus-checksum-algorithm, tus-extension, tus-max-size, tus-resumable, tus-version, \
         upload-expires, upload-length, upload-metadata, upload-offset",
    ),
    (header::ACCESS_CONTROL_MAX_AGE, "600"),
];

/// Lets pages of the allowed origins read the answer. What a browser asks before it sends, `OPTIONS`, is answered to anybody.
pub(super) async fn share(State(state): State<AppState>, request: Request, next: Next) -> Response {
    let allowed = &state.config.allowed_origins;
    let origin = request.headers().get(header::ORIGIN);
    let origin = origin.filter(|origin| allowed.iter().any(|allowed| *origin == allowed.as_str())).cloned();
    let mut response = next.run(request).await;
    let headers = response.headers_mut();
    if !allowed.is_empty() {
        headers.append(header::VARY, HeaderValue::from_static("origin"));
    }
    if let Some(origin) = origin {
        headers.insert(header::ACCESS_CONTROL_ALLOW_ORIGIN, origin);
        for (name, text) in SHARED {
            headers.insert(name, HeaderValue::from_static(text));
        }
    }
    response
}
