//! Public endpoints: the keys of this service at well-known URIs (RFC 8615), the check of a
//! certificate, and the revoked badges.

use acts::auth::federation::client_keys;
use acts::error::Error;
use acts::training::{badges, certificates};
use axum::Json;
use axum::extract::{Path, Query, State};
use axum::http::header::{ACCESS_CONTROL_ALLOW_ORIGIN, CACHE_CONTROL, CONTENT_TYPE};
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

/// Returns the routes below `/.well-known`, `/certificate`, and those below `/badges`.
#[must_use]
pub fn well_known_routes() -> Routes {
    Routes::new()
        .route("/.well-known/stylet-certificate-key", get(serve_certificate_key))
        .route("/.well-known/jwks.json", get(serve_client_keys))
        .route("/.well-known/did.json", get(serve_did_document))
        .route("/badges/status/{list}", get(serve_status_list))
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

/// Returns the document with the key that signs badges (`did:web`). Programs in a browser may read
/// it.
async fn serve_did_document(State(state): State<AppState>) -> Result<impl IntoResponse, ApiError> {
    let document = badges::did_document(&state)?.to_string();
    let headers = [
        (CONTENT_TYPE, "application/did+ld+json"),
        (CACHE_CONTROL, "public, max-age=3600"),
        (ACCESS_CONTROL_ALLOW_ORIGIN, "*"),
    ];
    Ok((headers, document))
}

/// Returns which badges of a list were revoked, one bit each. Programs in a browser may read it.
async fn serve_status_list(
    State(state): State<AppState>,
    Path(list): Path<String>,
) -> Result<impl IntoResponse, ApiError> {
    let list = list.parse().map_err(|_| Error::NotFound)?;
    let published = badges::publish_status_list(&state, list).await?.ok_or(Error::NotFound)?;
    let headers =
        [(CONTENT_TYPE, "application/vc"), (CACHE_CONTROL, "public, max-age=600"), (ACCESS_CONTROL_ALLOW_ORIGIN, "*")];
    Ok((headers, published.to_string()))
}
