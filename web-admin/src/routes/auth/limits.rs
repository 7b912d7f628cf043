//! Brakes on guessing passwords, by account and by address, and pairing codes.

use std::net::IpAddr;
use std::num::NonZeroU32;
use std::time::Duration;

use governor::clock::{Clock, DefaultClock};
use governor::{DefaultKeyedRateLimiter, Quota, RateLimiter};

use crate::error::Error;
use crate::secret;

/// Tries in a row for one account, and the pace afterwards.
const ACCOUNT_BURST: NonZeroU32 = NonZeroU32::new(10).unwrap();
const ACCOUNT_PERIOD: Duration = Duration::from_secs(30);
/// Tries in a row from one address: a class that signs in at once through one router passes.
const ADDRESS_BURST: NonZeroU32 = NonZeroU32::new(100).unwrap();
const ADDRESS_PERIOD: Duration = Duration::from_secs(2);

/// Counts tries to sign in, right or wrong: a right password waits its turn too, else the brake would tell which it is.
#[derive(Debug)]
pub struct LoginLimits {
    accounts: DefaultKeyedRateLimiter<[u8; 32]>,
    addresses: DefaultKeyedRateLimiter<IpAddr>,
}

impl Default for LoginLimits {
    fn default() -> Self {
        Self {
            accounts: RateLimiter::keyed(quota(ACCOUNT_PERIOD, ACCOUNT_BURST)),
            addresses: RateLimiter::keyed(quota(ADDRESS_PERIOD, ADDRESS_BURST)),
        }
    }
}

/// Pairing codes tried in a row from one address, and the pace afterwards.
const PAIRING_BURST: NonZeroU32 = NonZeroU32::new(10).unwrap();
const PAIRING_PERIOD: Duration = Duration::from_secs(30);

/// Counts pairing codes tried, right or wrong, by address.
#[derive(Debug)]
pub struct PairingLimits(DefaultKeyedRateLimiter<IpAddr>);

impl Default for PairingLimits {
    fn default() -> Self {
        Self(RateLimiter::keyed(quota(PAIRING_PERIOD, PAIRING_BURST)))
    }
}

impl PairingLimits {
    /// Takes a try.
    ///
    /// # Errors
    /// When there is none left, with the time until there is.
    pub fn take(&self, address: IpAddr) -> Result<(), Error> {
        self.0.check_key(&address).map_err(wait)
    }

    /// Forgets whoever has not tried for a while.
    pub fn tidy(&self) {
        self.0.retain_recent();
        self.0.shrink_to_fit();
    }
}

fn wait(until: governor::NotUntil<<DefaultClock as Clock>::Instant>) -> Error {
    Error::TooMany { retry_after_s: until.wait_time_from(DefaultClock::default().now()).as_secs() + 1 }
}

fn quota(period: Duration, burst: NonZeroU32) -> Quota {
    Quota::with_period(period).unwrap_or_else(|| Quota::per_minute(burst)).allow_burst(burst)
}

impl LoginLimits {
    /// Takes a try.
    ///
    /// # Errors
    /// When there is none left, with the time until there is.
    pub fn take(&self, address: IpAddr, email: &str) -> Result<(), Error> {
        self.addresses.check_key(&address).map_err(wait)?;
        // Hashed, so that what a stranger types takes the same room whatever its length.
        self.accounts.check_key(&secret::token_sha256(&email.to_lowercase())).map_err(wait)
    }

    /// Forgets whoever has not tried for a while.
    pub fn tidy(&self) {
        self.accounts.retain_recent();
        self.addresses.retain_recent();
        self.accounts.shrink_to_fit();
        self.addresses.shrink_to_fit();
    }
}
