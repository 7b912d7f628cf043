//! What falls due when, at a rate of its own.

/// Nanoseconds in a second.
pub(crate) const NS_PER_S: u64 = 1_000_000_000;

/// A time since the start as whole nanoseconds. A time that is no number or negative becomes 0.
#[must_use]
pub fn nanoseconds(t_s: f64) -> u64 {
    // A float-to-integer cast saturates, which is what a time that is off the scale should do.
    (t_s * 1e9).round() as u64
}

/// Says when something of a fixed rate is due. Counts in whole periods, so that it never drifts.
#[derive(Debug)]
pub struct Ticker {
    rate_hz: u32,
    next: u128,
}

impl Ticker {
    /// First due at `first` periods after the start.
    #[must_use]
    pub fn new(rate_hz: u32, first: u32) -> Self {
        Self { rate_hz, next: first.into() }
    }

    /// Whether a period has begun since the last time this was true.
    pub fn due(&mut self, elapsed_ns: u64) -> bool {
        let period = u128::from(elapsed_ns) * u128::from(self.rate_hz) / u128::from(NS_PER_S);
        let due = period >= self.next;
        if due {
            self.next = period + 1;
        }
        due
    }
}
