//! Cross-origin uploads from browsers, for origins that the service or a school allows.
//!
//! Such a page authenticates with a token. Cookies are never accepted from it:
//! `Access-Control-Allow-Credentials` is never sent.

use axum::extract::{Request, State};
use axum::http::{HeaderName, HeaderValue, header};
use axum::middleware::Next;
use axum::response::Response;
use routes_base::AppState;
use store::operations::origins;

/// Headers sent to pages of an allowed origin.
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

/// Lets pages of the allowed origins read the response. Preflight requests (`OPTIONS`) need no
/// authentication.
pub(crate) async fn share_with_origin(State(state): State<AppState>, request: Request, next: Next) -> Response {
    let origin = request.headers().get(header::ORIGIN).cloned();
    let is_shared = match &origin {
        Some(origin) => is_allowed_origin(&state, origin).await,
        None => false,
    };
    let mut response = next.run(request).await;
    let headers = response.headers_mut();
    headers.append(header::VARY, HeaderValue::from_static("origin"));
    if let Some(origin) = origin.filter(|_| is_shared) {
        headers.insert(header::ACCESS_CONTROL_ALLOW_ORIGIN, origin);
        for (name, text) in SHARED {
            headers.insert(name, HeaderValue::from_static(text));
        }
    }
    response
}

/// Whether the service or any school allows an origin. If the database is unavailable, only the
/// origins of the configuration are allowed.
async fn is_allowed_origin(state: &AppState, origin: &HeaderValue) -> bool {
    let Ok(origin) = origin.to_str() else { return false };
    state.config.allowed_origins.iter().any(|allowed| allowed == origin)
        || origins::is_origin_allowed(state.db.reader(), origin).await.unwrap_or(false)
}
