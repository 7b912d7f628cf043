//! A limit on the requests of each caller.

use std::num::NonZeroU32;

use governor::{DefaultKeyedRateLimiter, Quota, RateLimiter};
use uuid::Uuid;

/// Requests that may come at once, in seconds of the permitted pace.
const BURST_S: NonZeroU32 = NonZeroU32::new(10).expect("not zero");

/// A number of requests per second for each caller, per process.
#[derive(Debug)]
pub struct RequestPace(DefaultKeyedRateLimiter<Uuid>);

impl RequestPace {
    /// Permits so many requests per second, and ten times as many at once after a pause.
    #[must_use]
    pub fn per_second(requests: NonZeroU32) -> Self {
        let burst = requests.saturating_mul(BURST_S);
        Self(RateLimiter::keyed(Quota::per_second(requests).allow_burst(burst)))
    }

    /// Counts a request. Returns whether it is permitted.
    pub fn take(&self, caller: Uuid) -> bool {
        self.0.check_key(&caller).is_ok()
    }
}
