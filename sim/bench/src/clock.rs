//! The bench's only clock: what takes how long is what it measures.

use std::time::Instant;

/// Monotonic time, to measure how long something takes.
#[expect(clippy::disallowed_methods, reason = "what is measured is a time")]
pub fn instant() -> Instant {
    Instant::now()
}
