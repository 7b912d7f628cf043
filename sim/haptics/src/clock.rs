//! The only clock of this crate. All other code receives the time as an argument.

use std::sync::LazyLock;
use std::time::Instant;

/// The origin of [`now_s`]: the first time that this process read the clock.
static START: LazyLock<Instant> = LazyLock::new(instant);

/// Monotonic time, for pacing threads and measuring durations.
#[expect(clippy::disallowed_methods, reason = "this is where the crate reads the monotonic clock")]
pub fn instant() -> Instant {
    Instant::now()
}

/// Monotonic time since the first reading in this process, in s. All devices and threads share this
/// time axis.
pub fn now_s() -> f64 {
    START.elapsed().as_secs_f64()
}
