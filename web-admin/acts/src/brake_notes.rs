//! How often the log repeats that somebody is held up.

use std::net::IpAddr;
use std::num::NonZeroU32;
use std::time::Duration;

use governor::{DefaultKeyedRateLimiter, Quota, RateLimiter};

/// Between two notes that an address is held up.
const NOTE_PERIOD: Duration = Duration::from_secs(60);

/// So many at once, and then one in each period.
pub fn quota(period: Duration, burst: NonZeroU32) -> Quota {
    Quota::with_period(period).unwrap_or_else(|| Quota::per_minute(burst)).allow_burst(burst)
}

/// How often this process notes that an address is held up: once in a while, so that a flood fills no log.
#[derive(Debug)]
pub struct BrakeNotes(DefaultKeyedRateLimiter<IpAddr>);

impl Default for BrakeNotes {
    fn default() -> Self {
        Self(RateLimiter::keyed(quota(NOTE_PERIOD, NonZeroU32::MIN)))
    }
}

impl BrakeNotes {
    /// Whether it is to be written down that an address is held up.
    pub fn is_worth_noting(&self, address: IpAddr) -> bool {
        self.0.check_key(&address).is_ok()
    }

    /// Forgets whoever has not been held up for a while.
    pub fn tidy(&self) {
        self.0.retain_recent();
        self.0.shrink_to_fit();
    }
}
