//! What anybody may ask of a service whose address they know (RFC 8615).

use acts::certificates;
use axum::extract::State;
use axum::http::header::CONTENT_TYPE;
use axum::response::IntoResponse;
use axum::routing::get;

use super::Routes;
use crate::AppState;
use crate::error::ApiError;

/// Their addresses.
#[must_use]
pub fn well_known_routes() -> Routes {
    Routes::new().route("/.well-known/stylet-certificate-key", get(serve_certificate_key))
}

/// The public key that certificates are signed with, in hexadecimal: `docs/certificates.md`.
async fn serve_certificate_key(State(state): State<AppState>) -> Result<impl IntoResponse, ApiError> {
    let key = certificates::public_key(&state.config.data_dir)?;
    Ok(([(CONTENT_TYPE, "text/plain; charset=utf-8")], format!("{key}\n")))
}
