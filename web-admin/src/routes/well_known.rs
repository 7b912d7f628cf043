//! What anybody may ask of a service whose address they know (RFC 8615).

use axum::extract::State;
use axum::http::header::CONTENT_TYPE;
use axum::response::IntoResponse;
use axum::routing::get;

use super::Routes;
use crate::AppState;
use crate::error::ApiError;
use acts::certificates;

/// Their addresses.
#[must_use]
pub fn router() -> Routes {
    Routes::new().route("/.well-known/stylet-certificate-key", get(certificate_key))
}

/// The public key that certificates are signed with, in hexadecimal: `docs/certificates.md`.
async fn certificate_key(State(state): State<AppState>) -> Result<impl IntoResponse, ApiError> {
    let key = certificates::public_key(&state.config.data_dir)?;
    Ok(([(CONTENT_TYPE, "text/plain; charset=utf-8")], format!("{key}\n")))
}
