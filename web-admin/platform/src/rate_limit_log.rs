//! Limits how often the log reports rate-limited addresses.

use std::net::IpAddr;
use std::num::NonZeroU32;
use std::time::Duration;

use governor::{DefaultKeyedRateLimiter, Quota, RateLimiter};

/// Minimum time between two log lines about one address.
const NOTE_PERIOD: Duration = Duration::from_secs(60);

/// Returns a quota of `burst` cells at once, then one per `period`.
pub fn quota(period: Duration, burst: NonZeroU32) -> Quota {
    Quota::with_period(period).unwrap_or_else(|| Quota::per_minute(burst)).allow_burst(burst)
}

/// Throttle for log lines about rate-limited addresses, per process, so that a flood of requests
/// does not fill the log.
#[derive(Debug)]
pub struct RateLimitLog(DefaultKeyedRateLimiter<IpAddr>);

impl Default for RateLimitLog {
    fn default() -> Self {
        Self(RateLimiter::keyed(quota(NOTE_PERIOD, NonZeroU32::MIN)))
    }
}

impl RateLimitLog {
    /// Returns whether to log that an address is rate-limited.
    pub fn is_worth_noting(&self, address: IpAddr) -> bool {
        self.0.check_key(&address).is_ok()
    }

    /// Drops addresses that have not been rate-limited recently.
    pub fn tidy(&self) {
        self.0.retain_recent();
        self.0.shrink_to_fit();
    }
}
