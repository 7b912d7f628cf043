//! The only clock of this crate. Everything else is told the time.

use std::sync::LazyLock;
use std::time::Instant;

/// When this program first asked for the time.
static START: LazyLock<Instant> = LazyLock::new(instant);

/// Monotonic time, to pace threads and to measure how long something takes.
#[expect(clippy::disallowed_methods, reason = "this is where the crate reads the monotonic clock")]
pub fn instant() -> Instant {
    Instant::now()
}

/// Monotonic time since this program first asked, in s: one axis for every device and thread.
pub fn now_s() -> f64 {
    START.elapsed().as_secs_f64()
}
