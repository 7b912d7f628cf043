//! The only place where the client reads the system clocks.

use std::time::Instant;

use time::OffsetDateTime;
use uuid::Uuid;

/// Wall-clock time, in UTC.
#[expect(clippy::disallowed_methods, reason = "the client is the wiring: this is where it reads the wall clock")]
pub fn now() -> OffsetDateTime {
    OffsetDateTime::now_utc()
}

/// Monotonic time, to measure durations.
#[expect(clippy::disallowed_methods, reason = "the client is the wiring: this is where it reads the monotonic clock")]
pub fn instant() -> Instant {
    Instant::now()
}

/// Creates the identifier of a new session: a UUIDv7, which contains its creation time.
pub fn new_session_id() -> Uuid {
    Uuid::now_v7()
}
