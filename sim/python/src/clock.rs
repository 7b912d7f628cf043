//! When an attempt is made, where the caller does not say. Nothing else here reads a clock.

use time::OffsetDateTime;
use uuid::Uuid;

/// Wall-clock time, in UTC.
#[expect(clippy::disallowed_methods, reason = "a recording says when it was made, unless the caller does")]
pub fn now() -> OffsetDateTime {
    OffsetDateTime::now_utc()
}

/// A new session's identifier: a UUIDv7, which carries the time it was made.
pub fn new_session_id() -> Uuid {
    Uuid::now_v7()
}
