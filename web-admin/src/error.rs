//! What can go wrong in a request, and how it is said: as a page, or as `application/problem+json`.

use std::io::ErrorKind;

use axum::Json;
use axum::http::header::{CONTENT_TYPE, RETRY_AFTER};
use axum::http::{HeaderValue, StatusCode};
use axum::response::{IntoResponse, Response};
use serde::Serialize;

use crate::views::error::ErrorPage;

/// Why a request was not done.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// There is no such thing, or it is another school's.
    #[error("there is nothing here")]
    NotFound,
    /// It was there, and is no more.
    #[error("{0}")]
    Gone(&'static str),
    /// Nobody is signed in.
    #[error("a bearer token is needed")]
    Unauthorized,
    /// What somebody shows was good once.
    #[error("{0}")]
    Expired(String),
    /// Somebody is signed in who may not do this.
    #[error("{0}")]
    Forbidden(&'static str),
    /// The request makes no sense.
    #[error("{0}")]
    BadRequest(String),
    /// It contradicts what is stored.
    #[error("{0}")]
    Conflict(String),
    /// Another request is at it.
    #[error("another request is writing to this upload; try again when it has ended")]
    Locked,
    /// The request is in a version of a protocol that is not spoken here.
    #[error("{0}")]
    WrongVersion(&'static str),
    /// The body is not what its checksum says.
    #[error("the piece is not what Upload-Checksum says: it was not kept")]
    ChecksumMismatch,
    /// The body is larger than allowed.
    #[error("the body is larger than {limit_bytes} bytes, the largest allowed")]
    TooLarge {
        /// Largest allowed, in bytes.
        limit_bytes: u64,
    },
    /// The body is of a kind that is not taken.
    #[error("{0}")]
    UnsupportedMedia(&'static str),
    /// There is no score, and there will be none.
    #[error("this attempt was not scored: {0}")]
    Unscored(String),
    /// The body was understood and is wrong.
    #[error("{0}")]
    Unprocessable(String),
    /// The body did not arrive in time.
    #[error("the body stopped arriving")]
    Timeout,
    /// Too many attempts.
    #[error("too many attempts; try again in {retry_after_s} s")]
    TooMany {
        /// When to try again, in s.
        retry_after_s: u64,
    },
    /// Others of the same school are before it.
    #[error("others of this school are before this; try again in {retry_after_s} s")]
    Busy {
        /// When to try again, in s.
        retry_after_s: u64,
    },
    /// The scanner for malware has said nothing of it. The cause goes to the log.
    #[error("the scanner for malware says nothing of this now, so it was not taken in; send it again later")]
    Unscanned(#[source] anyhow::Error),
    /// Whoever worked on it has died of it, or took too long; how. The cause goes to the log.
    #[error("this could not be worked on to its end; it is tried once more when it is sent again, and then set aside")]
    Deadly(String),
    /// More was begun than one may have begun at once.
    #[error("{0}")]
    OverQuota(String),
    /// The disk is full. The cause goes to the log.
    #[error("{NO_ROOM}")]
    NoRoom(#[source] anyhow::Error),
    /// Our fault. The cause goes to the log, never to the user.
    #[error("something went wrong here; it has been noted")]
    Internal(#[source] anyhow::Error),
}

/// In an answer that somebody was refused what is not theirs, or is not there: for whoever writes such answers down.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Denied;

/// When to send again what somebody has died of, in s.
const AFTER_DEATH_S: u64 = 10;
/// When to send again what no scanner has looked at, in s.
const UNSCANNED_S: u64 = 60;
/// Result code of SQLite for a full disk.
const SQLITE_FULL: &str = "13";
/// What is said of one.
const NO_ROOM: &str =
    "this service has no room left on its disk, so nothing was changed; tell whoever runs it, and try again later";

impl Error {
    /// What storage said, by whether there is room.
    fn of_storage(full: bool, cause: anyhow::Error) -> Self {
        if full { Self::NoRoom(cause) } else { Self::Internal(cause) }
    }

    /// The HTTP status.
    #[must_use]
    pub fn status(&self) -> StatusCode {
        match self {
            Self::NotFound | Self::Unscored(_) => StatusCode::NOT_FOUND,
            Self::Gone(_) => StatusCode::GONE,
            Self::Unauthorized | Self::Expired(_) => StatusCode::UNAUTHORIZED,
            Self::Forbidden(_) => StatusCode::FORBIDDEN,
            Self::BadRequest(_) => StatusCode::BAD_REQUEST,
            Self::Conflict(_) => StatusCode::CONFLICT,
            Self::Locked => StatusCode::LOCKED,
            Self::WrongVersion(_) => StatusCode::PRECONDITION_FAILED,
            // tus gives it this number, and HTTP none; a number from 100 to 999 is always one.
            Self::ChecksumMismatch => StatusCode::from_u16(460).unwrap_or(StatusCode::BAD_REQUEST),
            Self::TooLarge { .. } => StatusCode::PAYLOAD_TOO_LARGE,
            Self::UnsupportedMedia(_) => StatusCode::UNSUPPORTED_MEDIA_TYPE,
            Self::Unprocessable(_) => StatusCode::UNPROCESSABLE_ENTITY,
            Self::Timeout => StatusCode::REQUEST_TIMEOUT,
            Self::TooMany { .. } | Self::OverQuota(_) => StatusCode::TOO_MANY_REQUESTS,
            Self::Busy { .. } | Self::Deadly(_) | Self::Unscanned(_) => StatusCode::SERVICE_UNAVAILABLE,
            Self::NoRoom(_) => StatusCode::INSUFFICIENT_STORAGE,
            Self::Internal(_) => StatusCode::INTERNAL_SERVER_ERROR,
        }
    }

    /// What is wrong, in the reader's language; whoever refused in words of their own has said them in it.
    #[must_use]
    pub fn said(&self) -> String {
        match self {
            Self::NotFound => tr!("there is nothing here").to_owned(),
            Self::TooLarge { limit_bytes } => {
                tr!("the body is larger than {limit} bytes, the largest allowed", limit = limit_bytes)
            }
            Self::Unscored(why) => tr!("this attempt was not scored: {why}", why = why),
            Self::Timeout => tr!("the body stopped arriving").to_owned(),
            Self::TooMany { retry_after_s } => tr!("too many attempts; try again in {wait} s", wait = retry_after_s),
            Self::Busy { retry_after_s } => {
                tr!("others of this school are before this; try again in {wait} s", wait = retry_after_s)
            }
            Self::NoRoom(_) => {
                tr!("this service has no room left on its disk, so nothing was changed; tell whoever runs it, and try again later").to_owned()
            }
            Self::Internal(_) => tr!("something went wrong here; it has been noted").to_owned(),
            other => other.to_string(),
        }
    }

    /// Finishes an answer: what only its headers can say, that somebody was refused, and the one log line of an internal error.
    pub(crate) fn dress(&self, mut response: Response) -> Response {
        let retry_after_s = match self {
            Self::TooMany { retry_after_s } | Self::Busy { retry_after_s } => Some(*retry_after_s),
            Self::Deadly(_) => Some(AFTER_DEATH_S),
            Self::Unscanned(_) => Some(UNSCANNED_S),
            _ => None,
        };
        if let Some(retry_after_s) = retry_after_s {
            response.headers_mut().insert(RETRY_AFTER, HeaderValue::from(retry_after_s));
        }
        if matches!(self, Self::Forbidden(_) | Self::NotFound) {
            response.extensions_mut().insert(Denied);
        }
        if let Self::Deadly(how) = self {
            tracing::error!(how, "whoever worked on this has died of it");
        }
        if let Self::Unscanned(cause) = self {
            tracing::error!(cause = format!("{cause:#}"), "a recording was not scanned, and not taken in");
        }
        if let Self::Internal(cause) | Self::NoRoom(cause) = self {
            tracing::error!(cause = format!("{cause:#}"), "request failed");
        }
        response
    }
}

impl From<sqlx::Error> for Error {
    fn from(error: sqlx::Error) -> Self {
        let full = matches!(&error, sqlx::Error::Database(told) if told.code().as_deref() == Some(SQLITE_FULL));
        Self::of_storage(full, anyhow::Error::new(error).context("database"))
    }
}

impl From<anyhow::Error> for Error {
    fn from(error: anyhow::Error) -> Self {
        Self::Internal(error)
    }
}

impl From<std::io::Error> for Error {
    fn from(error: std::io::Error) -> Self {
        let full = matches!(error.kind(), ErrorKind::StorageFull | ErrorKind::QuotaExceeded);
        Self::of_storage(full, anyhow::Error::new(error).context("file system"))
    }
}

impl From<tokio::task::JoinError> for Error {
    fn from(error: tokio::task::JoinError) -> Self {
        Self::Internal(anyhow::Error::new(error).context("background task"))
    }
}

impl From<tower_sessions::session::Error> for Error {
    fn from(error: tower_sessions::session::Error) -> Self {
        Self::Internal(anyhow::Error::new(error).context("web session"))
    }
}

/// RFC 9457.
#[derive(Debug, Serialize, utoipa::ToSchema)]
pub struct Problem {
    /// The status in words.
    pub title: String,
    /// HTTP status.
    pub status: u16,
    /// What is wrong with this request.
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
        let status = self.0.status();
        let title = status.canonical_reason().unwrap_or("Checksum Mismatch").to_owned();
        let problem = Problem { title, status: status.as_u16(), detail: self.0.to_string() };
        let mut response = (status, Json(problem)).into_response();
        response.headers_mut().insert(CONTENT_TYPE, HeaderValue::from_static("application/problem+json"));
        if status == StatusCode::UNAUTHORIZED {
            response.headers_mut().insert("www-authenticate", HeaderValue::from_static("Bearer"));
        }
        self.0.dress(response)
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
        let status = self.0.status();
        let page = ErrorPage { status: status.as_u16(), message: self.0.said() };
        self.0.dress((status, page).into_response())
    }
}
