//! The only clock of this crate.

use std::time::Instant;

/// Returns the monotonic time, for measuring durations.
#[expect(clippy::disallowed_methods, reason = "what is measured is a time")]
pub fn instant() -> Instant {
    Instant::now()
}
