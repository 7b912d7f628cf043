//! Converts errors to responses: a page, or `application/problem+json`.

use acts::Error;
use axum::Json;
use axum::http::header::{CONTENT_TYPE, RETRY_AFTER};
use axum::http::{HeaderValue, StatusCode};
use axum::response::{IntoResponse, Response};
use pages::error::ErrorPage;
use serde::Serialize;

/// Response extension that marks a refused or missing object, for the log of refused requests.
#[derive(Clone, Copy, Debug)]
pub struct Denied;

/// `Retry-After` for an upload whose processing has crashed, in s.
const AFTER_DEATH_S: u64 = 10;
/// `Retry-After` while the recording store is unavailable, in s.
const STORE_AWAY_S: u64 = 10;
/// `Retry-After` while the database is unavailable, in s.
const DATABASE_AWAY_S: u64 = 5;
/// `Retry-After` for an upload that could not be scanned, in s.
const UNSCANNED_S: u64 = 60;

/// Returns the HTTP status of an error.
#[must_use]
pub fn status_of(error: &Error) -> StatusCode {
    match error {
        Error::NotFound | Error::Unscored(_) => StatusCode::NOT_FOUND,
        Error::Gone(_) => StatusCode::GONE,
        Error::Unwanted(_) => StatusCode::UNAVAILABLE_FOR_LEGAL_REASONS,
        Error::Quarantined => StatusCode::FAILED_DEPENDENCY,
        Error::Unauthorized | Error::Expired(_) => StatusCode::UNAUTHORIZED,
        Error::Forbidden(_) => StatusCode::FORBIDDEN,
        Error::BadRequest(_) => StatusCode::BAD_REQUEST,
        Error::Conflict(_) => StatusCode::CONFLICT,
        Error::Locked => StatusCode::LOCKED,
        Error::WrongVersion(_) => StatusCode::PRECONDITION_FAILED,
        // Defined by tus but not by HTTP; `from_u16` accepts any number from 100 to 999.
        Error::ChecksumMismatch => StatusCode::from_u16(460).unwrap_or(StatusCode::BAD_REQUEST),
        Error::TooLarge { .. } => StatusCode::PAYLOAD_TOO_LARGE,
        Error::UnsupportedMedia(_) => StatusCode::UNSUPPORTED_MEDIA_TYPE,
        Error::Unprocessable(_) => StatusCode::UNPROCESSABLE_ENTITY,
        Error::Timeout => StatusCode::REQUEST_TIMEOUT,
        Error::TooMany { .. } | Error::OverQuota(_) => StatusCode::TOO_MANY_REQUESTS,
        Error::Busy { .. }
        | Error::Crowded { .. }
        | Error::WorkerCrashed(_)
        | Error::Unscanned(_)
        | Error::StoreUnavailable(_)
        | Error::DatabaseUnavailable(_) => StatusCode::SERVICE_UNAVAILABLE,
        Error::NoRoom(_) => StatusCode::INSUFFICIENT_STORAGE,
        Error::Internal(_) => StatusCode::INTERNAL_SERVER_ERROR,
    }
}

/// Completes an error response: adds `Retry-After`, marks refusals, and logs an internal error
/// once.
pub fn finish_answer(error: &Error, mut response: Response) -> Response {
    let retry_after_s = match error {
        Error::TooMany { retry_after_s } | Error::Busy { retry_after_s } | Error::Crowded { retry_after_s } => {
            Some(*retry_after_s)
        }
        Error::WorkerCrashed(_) => Some(AFTER_DEATH_S),
        Error::Unscanned(_) => Some(UNSCANNED_S),
        Error::StoreUnavailable(_) => Some(STORE_AWAY_S),
        Error::DatabaseUnavailable(_) => Some(DATABASE_AWAY_S),
        _ => None,
    };
    if let Some(retry_after_s) = retry_after_s {
        response.headers_mut().insert(RETRY_AFTER, HeaderValue::from(retry_after_s));
    }
    if matches!(error, Error::Forbidden(_) | Error::NotFound) {
        response.extensions_mut().insert(Denied);
    }
    if let Error::WorkerCrashed(how) = error {
        tracing::error!(how, "sandboxed process crashed");
    }
    if let Error::Unscanned(cause) = error {
        tracing::error!(cause = format!("{cause:#}"), "malware scanner unavailable; recording not accepted");
    }
    if let Error::StoreUnavailable(cause) = error {
        tracing::error!(cause = format!("{cause:#}"), "recording store unavailable");
    }
    if let Error::DatabaseUnavailable(cause) = error {
        tracing::error!(cause = format!("{cause:#}"), "the database does not respond");
    }
    if let Error::Internal(cause) | Error::NoRoom(cause) = error {
        tracing::error!(cause = format!("{cause:#}"), "request failed");
    }
    response
}

/// An error, as a problem document (RFC 9457).
#[derive(Debug, Serialize, utoipa::ToSchema)]
#[schema(as = Problem)]
pub struct ProblemDocument {
    /// The reason phrase of the status.
    pub title: String,
    /// HTTP status.
    pub status: u16,
    /// Explanation of this error.
    pub detail: String,
}

/// An error of the API.
#[derive(Debug)]
pub struct ApiError(pub Error);

impl<E: Into<Error>> From<E> for ApiError {
    fn from(error: E) -> Self {
        Self(error.into())
    }
}

impl IntoResponse for ApiError {
    fn into_response(self) -> Response {
        let status = status_of(&self.0);
        let title = status.canonical_reason().unwrap_or("Checksum Mismatch").to_owned();
        let problem = ProblemDocument { title, status: status.as_u16(), detail: self.0.to_string() };
        let mut response = (status, Json(problem)).into_response();
        response.headers_mut().insert(CONTENT_TYPE, HeaderValue::from_static("application/problem+json"));
        if status == StatusCode::UNAUTHORIZED {
            response.headers_mut().insert("www-authenticate", HeaderValue::from_static("Bearer"));
        }
        finish_answer(&self.0, response)
    }
}

/// An error of a page.
#[derive(Debug)]
pub struct PageError(pub Error);

impl<E: Into<Error>> From<E> for PageError {
    fn from(error: E) -> Self {
        Self(error.into())
    }
}

impl IntoResponse for PageError {
    fn into_response(self) -> Response {
        let status = status_of(&self.0);
        let page = ErrorPage { status: status.as_u16(), message: self.0.said() };
        finish_answer(&self.0, (status, page).into_response())
    }
}
