//! Errors of requests and their user-facing messages.

use std::io::ErrorKind;

use model::CurrentPerson;
use platform::bounded_queue::QueueTimeout;
use platform::recording_store::StoreError;
use tower_sessions::{session, session_store};

/// Prefix of the session store's error messages when the database is unavailable. The error type of the
/// session crate contains only a text, so the prefix is how callers recognize this case.
pub(crate) const AWAY: &str = "the database does not respond";

/// Error of a request.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// It does not exist, or belongs to another school.
    #[error("nothing was found at this address")]
    NotFound,
    /// It existed and was removed.
    #[error("{0}")]
    Gone(&'static str),
    /// The request is not authenticated.
    #[error("a bearer token is needed")]
    Unauthorized,
    /// The credential has expired.
    #[error("{0}")]
    Expired(String),
    /// The person may not do this.
    #[error("{0}")]
    Forbidden(&'static str),
    /// The request is malformed.
    #[error("{0}")]
    BadRequest(String),
    /// The request conflicts with the stored state.
    #[error("{0}")]
    Conflict(String),
    /// Another request holds the lock.
    #[error("another request is writing to this upload; try again when it has finished")]
    Locked,
    /// The protocol version is not supported.
    #[error("{0}")]
    WrongVersion(&'static str),
    /// The body does not match its checksum.
    #[error("the chunk does not match Upload-Checksum: it was discarded")]
    ChecksumMismatch,
    /// The body exceeds the size limit.
    #[error("the request body is larger than the limit of {limit_bytes} bytes")]
    TooLarge {
        /// Size limit, in bytes.
        limit_bytes: u64,
    },
    /// The media type is not supported.
    #[error("{0}")]
    UnsupportedMedia(&'static str),
    /// The attempt has no score and will not get one.
    #[error("this attempt was not scored: {0}")]
    Unscored(String),
    /// The body was parsed but is invalid.
    #[error("{0}")]
    Unprocessable(String),
    /// The body did not arrive in time.
    #[error("the transfer of the request body was interrupted")]
    Timeout,
    /// Rate limit exceeded.
    #[error("too many attempts; try again in {retry_after_s} s")]
    TooMany {
        /// When to retry, in s.
        retry_after_s: u64,
    },
    /// Earlier requests of the same school are still in the queue.
    #[error("other drafts of this school are checked first; try again in {retry_after_s} s")]
    Busy {
        /// When to retry, in s.
        retry_after_s: u64,
    },
    /// Too many concurrent sign-ins.
    #[error("too many people are signing in right now; try again in {retry_after_s} s")]
    Crowded {
        /// When to retry, in s.
        retry_after_s: u64,
    },
    /// The malware scanner did not return a verdict. The cause is logged.
    #[error("the malware scanner is unavailable, so the recording was not accepted; send it again later")]
    Unscanned(#[source] anyhow::Error),
    /// The helper process crashed or timed out on this file; contains how it ended. The cause is
    /// logged.
    #[error("processing did not finish; if you send it again, it is retried once and then quarantined")]
    WorkerCrashed(String),
    /// The helper crashed twice on this recording. It is not read again until the operator runs
    /// `web-admin retry`.
    #[error(
        "this recording has crashed its reader twice and is quarantined; the operator was notified: keep the recording until the operator releases it"
    )]
    Quarantined,
    /// The person was erased, withdrew or never consented: the recording must be deleted at the
    /// station, too.
    #[error("{0}")]
    Unwanted(&'static str),
    /// Too many unfinished uploads, or too much accepted within a day.
    #[error("{0}")]
    OverQuota(String),
    /// The disk is full. The cause is logged.
    #[error("{NO_ROOM}")]
    NoRoom(#[source] anyhow::Error),
    /// The recording store is unavailable. The cause is logged.
    #[error("{STORE_AWAY}")]
    StoreUnavailable(#[source] anyhow::Error),
    /// The database is unavailable. The cause is logged.
    #[error("{DATABASE_AWAY}")]
    DatabaseUnavailable(#[source] anyhow::Error),
    /// An internal error. The cause is logged and never shown to the user.
    #[error("an internal error occurred and was logged; try again later")]
    Internal(#[source] anyhow::Error),
}

/// Message of [`Error::NoRoom`].
const NO_ROOM: &str =
    "this service has run out of disk space, so nothing was changed; tell its operator, and try again later";

/// Message of [`Error::StoreUnavailable`].
const STORE_AWAY: &str = "the recording store is unavailable, so the request was not carried out; try again later";

/// Message of [`Error::DatabaseUnavailable`]. A commit that was in progress may have succeeded.
const DATABASE_AWAY: &str =
    "the database is unavailable; your change may not have been saved: check before you try again";

/// Formats an error with its chain of causes, for the log. Users only see the outermost message.
#[must_use]
pub fn error_chain(error: &(dyn std::error::Error + 'static)) -> String {
    let causes: Vec<String> = anyhow::Chain::new(error).map(ToString::to_string).collect();
    causes.join(": ")
}

/// Returns whether the cause of an error is an unavailable database.
#[must_use]
pub fn is_database_unavailable(cause: &anyhow::Error) -> bool {
    let is_away = |error: &(dyn std::error::Error + 'static)| {
        let of_store = error.downcast_ref().is_some_and(store::is_database_unavailable);
        of_store || matches!(error.downcast_ref(), Some(Error::DatabaseUnavailable(_)))
    };
    cause.chain().any(is_away)
}

impl Error {
    /// Converts a storage error, depending on whether the disk is full.
    fn of_storage(full: bool, cause: anyhow::Error) -> Self {
        if full { Self::NoRoom(cause) } else { Self::Internal(cause) }
    }

    /// Returns the message in the current language. Variants that carry a text were translated when
    /// they were created.
    #[must_use]
    pub fn said(&self) -> String {
        match self {
            Self::NotFound => tr!("nothing was found at this address").to_owned(),
            Self::TooLarge { limit_bytes } => {
                tr!("the request body is larger than the limit of {limit} bytes", limit = limit_bytes)
            }
            Self::Unscored(why) => tr!("this attempt was not scored: {why}", why = why),
            Self::Timeout => tr!("the transfer of the request body was interrupted").to_owned(),
            Self::TooMany { retry_after_s } => tr!("too many attempts; try again in {wait} s", wait = retry_after_s),
            Self::Crowded { retry_after_s } => {
                tr!("too many people are signing in right now; try again in {wait} s", wait = retry_after_s)
            }
            Self::Busy { retry_after_s } => {
                tr!("other drafts of this school are checked first; try again in {wait} s", wait = retry_after_s)
            }
            Self::NoRoom(_) => tr!(
                "this service has run out of disk space, so nothing was changed; tell its operator, and try again later"
            )
            .to_owned(),
            Self::StoreUnavailable(_) => {
                tr!("the recording store is unavailable, so the request was not carried out; try again later")
                    .to_owned()
            }
            Self::DatabaseUnavailable(_) => {
                tr!("the database is unavailable; your change may not have been saved: check before you try again")
                    .to_owned()
            }
            Self::Internal(_) => tr!("an internal error occurred and was logged; try again later").to_owned(),
            other => other.to_string(),
        }
    }
}

/// Rejects trainees.
///
/// # Errors
/// Returns [`Error::Forbidden`] for a trainee.
pub fn refuse_trainees(person: &CurrentPerson) -> Result<(), Error> {
    match person.role.teaches() {
        true => Ok(()),
        false => Err(Error::Forbidden(tr!("this page is for instructors"))),
    }
}

impl From<store::Error> for Error {
    fn from(error: store::Error) -> Self {
        let (full, away) = (store::is_disk_full(&error), store::is_database_unavailable(&error));
        let cause = anyhow::Error::new(error).context("database");
        if away { Self::DatabaseUnavailable(cause) } else { Self::of_storage(full, cause) }
    }
}

impl From<anyhow::Error> for Error {
    fn from(error: anyhow::Error) -> Self {
        if is_database_unavailable(&error) { Self::DatabaseUnavailable(error) } else { Self::Internal(error) }
    }
}

impl From<std::io::Error> for Error {
    fn from(error: std::io::Error) -> Self {
        let full = matches!(error.kind(), ErrorKind::StorageFull | ErrorKind::QuotaExceeded);
        Self::of_storage(full, anyhow::Error::new(error).context("file system"))
    }
}

impl From<StoreError> for Error {
    fn from(error: StoreError) -> Self {
        match error {
            StoreError::Disk(error) => error.into(),
            StoreError::Missing => Self::Internal(StoreError::Missing.into()),
            StoreError::Away(cause) => Self::StoreUnavailable(cause),
            StoreError::Full(cause) => Self::NoRoom(cause),
        }
    }
}

impl From<QueueTimeout> for Error {
    fn from(QueueTimeout(waited): QueueTimeout) -> Self {
        Self::Busy { retry_after_s: waited.as_secs() }
    }
}

impl From<tokio::task::JoinError> for Error {
    fn from(error: tokio::task::JoinError) -> Self {
        Self::Internal(anyhow::Error::new(error).context("background task"))
    }
}

impl From<session::Error> for Error {
    fn from(error: session::Error) -> Self {
        let away =
            matches!(&error, session::Error::Store(session_store::Error::Backend(said)) if said.starts_with(AWAY));
        let cause = anyhow::Error::new(error).context("web session");
        if away { Self::DatabaseUnavailable(cause) } else { Self::Internal(cause) }
    }
}
