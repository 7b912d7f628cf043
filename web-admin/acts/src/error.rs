//! Why something is not done, and how it is said.

use std::io::ErrorKind;

use model::CurrentPerson;
use tower_sessions::{session, session_store};

use crate::recording_store::StoreError;
use crate::web_sessions::AWAY;

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
    /// Too many sign in at this moment.
    #[error("too many sign in at this moment; try again in {retry_after_s} s")]
    Crowded {
        /// When to try again, in s.
        retry_after_s: u64,
    },
    /// The scanner for malware has said nothing of it. The cause goes to the log.
    #[error("the scanner for malware says nothing of this now, so it was not taken in; send it again later")]
    Unscanned(#[source] anyhow::Error),
    /// Whoever worked on it has died of it, or took too long; how. The cause goes to the log.
    #[error("this could not be worked on to its end; it is tried once more when it is sent again, and then set aside")]
    Deadly(String),
    /// The helper crashed twice on this recording. It is not read again until the operator runs `web-admin retry`.
    #[error(
        "whoever read this recording has died of it twice: it is read no more, and whoever runs the service was told; keep it until they have let it be tried again"
    )]
    SetAside,
    /// The person was erased, has withdrawn or never consented: the recording must be deleted, also at the station.
    #[error("{0}")]
    Unwanted(&'static str),
    /// More was begun than one may have begun at once.
    #[error("{0}")]
    OverQuota(String),
    /// The disk is full. The cause goes to the log.
    #[error("{NO_ROOM}")]
    NoRoom(#[source] anyhow::Error),
    /// The store of the recordings does not answer. The cause goes to the log.
    #[error("{STORE_AWAY}")]
    StoreAway(#[source] anyhow::Error),
    /// The database does not answer. The cause goes to the log.
    #[error("{DATABASE_AWAY}")]
    DatabaseAway(#[source] anyhow::Error),
    /// Our fault. The cause goes to the log, never to the user.
    #[error("something went wrong here; it has been noted")]
    Internal(#[source] anyhow::Error),
}

/// What is said of one.
const NO_ROOM: &str =
    "this service has no room left on its disk, so nothing was changed; tell whoever runs it, and try again later";

/// What is said where the store of the recordings does not answer.
const STORE_AWAY: &str = "recordings cannot be reached now, so this was not done; try again later";

/// What is said where the database does not answer. What was being committed may be there all the same.
const DATABASE_AWAY: &str = "the database does not answer now; try again later, and where something was to be changed, look first whether it was";

/// An error and all that it came of, for the log: users are told the first of it alone.
#[must_use]
pub fn tell_in_full(error: &(dyn std::error::Error + 'static)) -> String {
    let causes: Vec<String> = anyhow::Chain::new(error).map(ToString::to_string).collect();
    causes.join(": ")
}

/// Whether work came to nothing because the database does not answer.
#[must_use]
pub fn is_database_away(cause: &anyhow::Error) -> bool {
    let is_away = |error: &(dyn std::error::Error + 'static)| {
        let of_store = error.downcast_ref().is_some_and(store::is_database_away);
        of_store || matches!(error.downcast_ref(), Some(Error::DatabaseAway(_)))
    };
    cause.chain().any(is_away)
}

impl Error {
    /// What storage said, by whether there is room.
    fn of_storage(full: bool, cause: anyhow::Error) -> Self {
        if full { Self::NoRoom(cause) } else { Self::Internal(cause) }
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
            Self::Crowded { retry_after_s } => {
                tr!("too many sign in at this moment; try again in {wait} s", wait = retry_after_s)
            }
            Self::Busy { retry_after_s } => {
                tr!("others of this school are before this; try again in {wait} s", wait = retry_after_s)
            }
            Self::NoRoom(_) => {
                tr!("this service has no room left on its disk, so nothing was changed; tell whoever runs it, and try again later").to_owned()
            }
            Self::StoreAway(_) => {
                tr!("recordings cannot be reached now, so this was not done; try again later").to_owned()
            }
            Self::DatabaseAway(_) => tr!(
                "the database does not answer now; try again later, and where something was to be changed, look first whether it was"
            )
            .to_owned(),
            Self::Internal(_) => tr!("something went wrong here; it has been noted").to_owned(),
            other => other.to_string(),
        }
    }
}

/// Some acts are for those who teach, whoever asks for them.
///
/// # Errors
/// [`Error::Forbidden`] for a trainee.
pub fn refuse_trainees(person: &CurrentPerson) -> Result<(), Error> {
    match person.role.teaches() {
        true => Ok(()),
        false => Err(Error::Forbidden(tr!("this page is for those who teach"))),
    }
}

impl From<store::Error> for Error {
    fn from(error: store::Error) -> Self {
        let (full, away) = (store::is_disk_full(&error), store::is_database_away(&error));
        let cause = anyhow::Error::new(error).context("database");
        if away { Self::DatabaseAway(cause) } else { Self::of_storage(full, cause) }
    }
}

impl From<anyhow::Error> for Error {
    fn from(error: anyhow::Error) -> Self {
        if is_database_away(&error) { Self::DatabaseAway(error) } else { Self::Internal(error) }
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
            StoreError::Away(cause) => Self::StoreAway(cause),
            StoreError::Full(cause) => Self::NoRoom(cause),
        }
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
        if away { Self::DatabaseAway(cause) } else { Self::Internal(cause) }
    }
}
