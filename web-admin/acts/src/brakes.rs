//! Brakes on guessing passwords, by account and by address, and pairing codes.

use std::collections::BTreeSet;
use std::net::IpAddr;
use std::num::NonZeroU32;
use std::sync::{Mutex, PoisonError};
use std::time::Duration;

use governor::clock::{Clock, DefaultClock};
use governor::{DefaultKeyedRateLimiter, Quota, RateLimiter};
use model::ids::PersonId;

use crate::error::Error;
use crate::secret;

/// Tries in a row for one account from one address, and the pace afterwards.
const PAIR_BURST: NonZeroU32 = NonZeroU32::new(10).unwrap();
const PAIR_PERIOD: Duration = Duration::from_secs(30);
/// Tries in a row for one account from all addresses that never got in: no single one of them uses them up.
const STRANGERS_BURST: NonZeroU32 = NonZeroU32::new(100).unwrap();
const STRANGERS_PERIOD: Duration = Duration::from_secs(5);
/// Tries in a row from one address: a class that signs in at once through one router passes.
const ADDRESS_BURST: NonZeroU32 = NonZeroU32::new(100).unwrap();
const ADDRESS_PERIOD: Duration = Duration::from_secs(2);
/// Codes of a second factor tried in a row for one person, and the pace afterwards: three of a million are right at a time.
const CODE_BURST: NonZeroU32 = NonZeroU32::new(10).unwrap();
const CODE_PERIOD: Duration = Duration::from_secs(120);
/// Between two notes that an address is held up.
const NOTE_PERIOD: Duration = Duration::from_secs(60);
/// Most pairs of account and address of which it is known that the right password came from there.
const MOST_KNOWN: usize = 100_000;

/// Counts tries to sign in, right or wrong: a right password waits its turn too, else the brake would tell which it is.
///
/// Whoever guesses at an account uses up their own tries, and at the utmost those of all strangers: where its owner has signed
/// in before, they still can.
#[derive(Debug)]
pub struct LoginLimits {
    pairs: DefaultKeyedRateLimiter<[u8; 32]>,
    strangers: DefaultKeyedRateLimiter<[u8; 32]>,
    addresses: DefaultKeyedRateLimiter<IpAddr>,
    codes: DefaultKeyedRateLimiter<PersonId>,
    notes: DefaultKeyedRateLimiter<IpAddr>,
    known: Mutex<BTreeSet<[u8; 32]>>,
}

impl Default for LoginLimits {
    fn default() -> Self {
        Self {
            pairs: RateLimiter::keyed(quota(PAIR_PERIOD, PAIR_BURST)),
            strangers: RateLimiter::keyed(quota(STRANGERS_PERIOD, STRANGERS_BURST)),
            addresses: RateLimiter::keyed(quota(ADDRESS_PERIOD, ADDRESS_BURST)),
            codes: RateLimiter::keyed(quota(CODE_PERIOD, CODE_BURST)),
            notes: RateLimiter::keyed(quota(NOTE_PERIOD, NonZeroU32::MIN)),
            known: Mutex::default(),
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

/// So many at once, and then one in each period.
pub fn quota(period: Duration, burst: NonZeroU32) -> Quota {
    Quota::with_period(period).unwrap_or_else(|| Quota::per_minute(burst)).allow_burst(burst)
}

impl LoginLimits {
    /// Takes a try.
    ///
    /// # Errors
    /// When there is none left, with the time until there is.
    pub fn take(&self, address: IpAddr, email: &str) -> Result<(), Error> {
        self.addresses.check_key(&address).map_err(wait)?;
        let pair = pair(address, email);
        self.pairs.check_key(&pair).map_err(wait)?;
        if self.known.lock().unwrap_or_else(PoisonError::into_inner).contains(&pair) {
            return Ok(());
        }
        // Hashed, so that what a stranger types takes the same room whatever its length.
        self.strangers.check_key(&secret::token_sha256(&email.to_lowercase())).map_err(wait)
    }

    /// Takes a try of somebody who is signed in and is to say their password once more.
    ///
    /// # Errors
    /// When there is none left, with the time until there is.
    pub fn take_own(&self, person: PersonId) -> Result<(), Error> {
        self.pairs.check_key(&secret::token_sha256(&format!("own {person}"))).map_err(wait)
    }

    /// Takes a try of a code of somebody's second factor, wherever it comes from: whoever tries has their password.
    ///
    /// # Errors
    /// When there is none left, with the time until there is.
    pub fn take_code(&self, person: PersonId) -> Result<(), Error> {
        self.codes.check_key(&person).map_err(wait)
    }

    /// Remembers that the right password came from an address.
    pub fn welcome(&self, address: IpAddr, email: &str) {
        let mut known = self.known.lock().unwrap_or_else(PoisonError::into_inner);
        if known.len() >= MOST_KNOWN {
            known.clear();
        }
        known.insert(pair(address, email));
    }

    /// Whether it is to be written down that an address is held up: once in a while, so that a flood fills no log.
    pub fn is_worth_noting(&self, address: IpAddr) -> bool {
        self.notes.check_key(&address).is_ok()
    }

    /// Forgets whoever has not tried for a while.
    pub fn tidy(&self) {
        self.pairs.retain_recent();
        self.strangers.retain_recent();
        self.addresses.retain_recent();
        self.codes.retain_recent();
        self.notes.retain_recent();
        self.pairs.shrink_to_fit();
        self.strangers.shrink_to_fit();
        self.addresses.shrink_to_fit();
        self.codes.shrink_to_fit();
        self.notes.shrink_to_fit();
    }
}

fn pair(address: IpAddr, email: &str) -> [u8; 32] {
    secret::token_sha256(&format!("{address} {}", email.to_lowercase()))
}
