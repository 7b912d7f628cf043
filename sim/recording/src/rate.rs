//! Periodic schedules.

/// Nanoseconds per second.
pub(crate) const NS_PER_S: u64 = 1_000_000_000;

/// Converts a time since the start to whole nanoseconds. Negative times and NaN become 0.
#[must_use]
pub fn nanoseconds(t_s: f64) -> u64 {
    // A float-to-integer cast saturates, which is the desired result for a time out of range.
    (t_s * 1e9).round() as u64
}

/// Schedules events at a fixed rate. Counts whole periods, so that it never drifts.
#[derive(Debug)]
pub struct Ticker {
    rate_hz: u32,
    next: u128,
}

impl Ticker {
    /// Creates a ticker that is first due `first` periods after the start.
    #[must_use]
    pub fn new(rate_hz: u32, first: u32) -> Self {
        Self { rate_hz, next: first.into() }
    }

    /// Returns whether a period has begun since the last call that returned `true`.
    pub fn due(&mut self, elapsed_ns: u64) -> bool {
        let period = u128::from(elapsed_ns) * u128::from(self.rate_hz) / u128::from(NS_PER_S);
        let due = period >= self.next;
        if due {
            self.next = period + 1;
        }
        due
    }
}
