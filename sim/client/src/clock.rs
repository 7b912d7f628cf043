//! The client's only clock. Everything else is told the time.

use std::time::Instant;

use time::OffsetDateTime;
use uuid::Uuid;

/// Wall-clock time, in UTC.
#[expect(clippy::disallowed_methods, reason = "the client is the wiring: this is where it reads the wall clock")]
pub fn now() -> OffsetDateTime {
    OffsetDateTime::now_utc()
}

/// Monotonic time, to measure how long something takes.
#[expect(clippy::disallowed_methods, reason = "the client is the wiring: this is where it reads the monotonic clock")]
pub fn instant() -> Instant {
    Instant::now()
}

/// A new session's identifier: a UUIDv7, which carries the time it was made.
pub fn new_session_id() -> Uuid {
    Uuid::now_v7()
}
