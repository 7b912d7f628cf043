//! Time and id of an attempt if the caller gives none. No other module of this crate reads a clock.

use time::OffsetDateTime;
use uuid::Uuid;

/// Returns the wall-clock time, in UTC.
#[expect(clippy::disallowed_methods, reason = "a recording says when it was made, unless the caller does")]
pub fn now() -> OffsetDateTime {
    OffsetDateTime::now_utc()
}

/// Generates a session id: a UUIDv7, which contains its creation time.
pub fn new_session_id() -> Uuid {
    Uuid::now_v7()
}
