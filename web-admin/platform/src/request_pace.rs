//! A limit on the requests of each caller.

use std::num::NonZeroU32;

use governor::{DefaultKeyedRateLimiter, Quota, RateLimiter};
use uuid::Uuid;

/// A number of requests per second for each caller, per process.
#[derive(Debug)]
pub struct RequestPace(DefaultKeyedRateLimiter<Uuid>);

impl RequestPace {
    /// Permits so many requests per second.
    #[must_use]
    pub fn per_second(requests: NonZeroU32) -> Self {
        Self(RateLimiter::keyed(Quota::per_second(requests)))
    }

    /// Counts a request. Returns whether it is permitted.
    pub fn take(&self, caller: Uuid) -> bool {
        self.0.check_key(&caller).is_ok()
    }
}
