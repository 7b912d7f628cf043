//! Public endpoints: the keys of this service at well-known URIs (RFC 8615), and the check of a
//! certificate.

use acts::auth::federation::client_keys;
use acts::training::certificates;
use axum::Json;
use axum::extract::{Query, State};
use axum::http::header::{CACHE_CONTROL, CONTENT_TYPE};
use axum::middleware::from_fn;
use axum::response::IntoResponse;
use axum::routing::get;
use model::training::certificate_note::CertificateNote;
use pages::training::certificate::{CertificateCheckPage, CheckOutcome};
use routes_base::error::{ApiError, PageError};
use routes_base::language::settle_language;
use routes_base::{AppState, Routes};
use serde::Deserialize;
use serde_json::json;

/// Returns the routes below `/.well-known`, and `/certificate`.
#[must_use]
pub fn well_known_routes() -> Routes {
    Routes::new()
        .route("/.well-known/stylet-certificate-key", get(serve_certificate_key))
        .route("/.well-known/jwks.json", get(serve_client_keys))
        .merge(
            Routes::new()
                .route("/certificate", get(check_certificate))
                .around(|page| page.layer(from_fn(settle_language))),
        )
}

/// Parameters of the code printed on a certificate.
#[derive(Debug, Default, Deserialize)]
#[serde(default)]
struct NoteQuery {
    of: String,
    by: String,
}

/// Shows whether this service signed the code printed on a certificate.
async fn check_certificate(
    State(state): State<AppState>,
    Query(query): Query<NoteQuery>,
) -> Result<CertificateCheckPage, PageError> {
    let key = certificates::signing_key(&state.config.keys_dir)?;
    let outcome = match (query.of.as_str(), query.by.as_str()) {
        ("", "") => CheckOutcome::NothingAsked,
        (of, by) => CertificateNote::check(of, by, &key).map_or(CheckOutcome::Refused, CheckOutcome::Genuine),
    };
    Ok(CertificateCheckPage { outcome, address: state.config.address() })
}

/// Returns the public key that signs certificates, in hexadecimal: `docs/certificates.md`.
async fn serve_certificate_key(State(state): State<AppState>) -> Result<impl IntoResponse, ApiError> {
    let key = certificates::public_key(&state.config.keys_dir)?;
    Ok(([(CONTENT_TYPE, "text/plain; charset=utf-8")], format!("{key}\n")))
}

/// Returns the public keys with which this service authenticates at other systems (RFC 7517).
async fn serve_client_keys(State(state): State<AppState>) -> Result<impl IntoResponse, ApiError> {
    let keys = client_keys::list_public_keys(&state).await?;
    Ok(([(CACHE_CONTROL, "public, max-age=600")], Json(json!({ "keys": keys }))))
}
