//! Rate limits on guessing passwords, codes and pairing codes, by account and by address. They are
//! stored in the database, so that attackers gain nothing from spreading attempts over replicas.

use std::net::IpAddr;

use model::Moment;
use model::ids::{PersonId, PlatformId};
use model::people::email::normalize_email;
use platform::secret;
use store::auth::rate_limits;
use store::{Connection, Executor};

use crate::error::Error;
use crate::service::Service;

/// A rate limit: a burst of attempts, then one per period (GCRA).
#[derive(Clone, Copy, Debug)]
struct BrakePace {
    burst: i64,
    period_s: i64,
}

/// Attempts on one account from one address.
const PAIR: BrakePace = BrakePace { burst: 10, period_s: 30 };
/// Attempts on one account from all addresses that have never signed in to it. High, so that a
/// single address cannot use it up.
const STRANGERS: BrakePace = BrakePace { burst: 100, period_s: 5 };
/// Attempts from one address. High enough for a class that signs in at once behind one router.
const ADDRESS: BrakePace = BrakePace { burst: 100, period_s: 2 };
/// Launches begun from one address. High enough for several lectures behind one router.
const LAUNCH_ADDRESS: BrakePace = BrakePace { burst: 500, period_s: 1 };
/// Launches that one learning platform has confirmed. High enough for an examination of a whole year.
const LAUNCH: BrakePace = BrakePace { burst: 600, period_s: 1 };
/// Second-factor codes tried for one person. Three of the 10⁶ codes are valid at any time.
const CODE: BrakePace = BrakePace { burst: 10, period_s: 120 };
/// Pairing codes, and wrong secrets of calendars, tried from one address.
const PAIRING: BrakePace = BrakePace { burst: 10, period_s: 30 };
/// How long an address counts as known after a correct password, in s.
const KNOWN_S: i64 = 90 * 24 * 3600;

impl BrakePace {
    /// Counts one attempt against `until`, the time up to which earlier attempts extend. Returns
    /// the new time, or the wait in s if no attempt is left.
    fn count(self, until: Option<Moment>, now: Moment) -> Result<Moment, u64> {
        let most = now.plus_s(self.burst * self.period_s);
        // A time further ahead was counted by a clock that has since been set back.
        let next = until.map_or(now, |until| until.clamp(now, most)).plus_s(self.period_s);
        if next <= most { Ok(next) } else { Err(next.duration_since(most).as_secs() + 1) }
    }
}

/// A rate limit for one key.
struct Brake {
    key_sha256: [u8; 32],
    pace: BrakePace,
}

impl Brake {
    /// Hashes the key, so that arbitrary input has a fixed size and no address is stored in plain
    /// text.
    fn new(pace: BrakePace, of: &str) -> Self {
        Self { key_sha256: secret::token_sha256(of), pace }
    }

    /// Returns the time up to which attempts would extend after one more.
    async fn count(&self, executor: impl Executor<'_>, now: Moment) -> Result<Moment, Error> {
        let until = rate_limits::find_brake(executor, &self.key_sha256).await?;
        self.pace.count(until, now).map_err(refuse)
    }

    async fn press(&self, tx: &mut Connection, now: Moment) -> Result<(), Error> {
        let next = self.count(&mut *tx, now).await?;
        Ok(rate_limits::put_brake(tx, &self.key_sha256, next).await?)
    }
}

const fn refuse(retry_after_s: u64) -> Error {
    Error::TooMany { retry_after_s }
}

/// Counts an attempt against all limits, or against none if one of them is exhausted.
async fn press_all(service: &Service, brakes: &[Brake]) -> Result<(), Error> {
    let now = service.clock.now();
    // Check first without writing, so that a rejected attempt costs no write transaction.
    for brake in brakes {
        brake.count(service.db.reader(), now).await?;
    }
    let mut tx = service.db.write().await?;
    for brake in brakes {
        brake.press(&mut tx, now).await?;
    }
    Ok(tx.commit().await?)
}

fn pair(address: IpAddr, email: &str) -> String {
    format!("{address} {}", normalize_email(email))
}

fn known_key(address: IpAddr, account: PersonId) -> [u8; 32] {
    secret::token_sha256(&format!("known {address} {account}"))
}

/// The accounts that an attempt to sign in may reach.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SignInReach {
    /// Accounts whose password may be compared.
    pub accounts: Vec<PersonId>,
    /// The correct password of one of them came from the address within the last 90 days.
    pub is_known: bool,
}

/// Counts an attempt to sign in, whether the password is right or wrong. Were right passwords
/// exempt, the limit would reveal them.
///
/// An attacker uses up their own attempts, and at most those of all unknown addresses: the owner
/// can still sign in from an address that they have used before. `accounts` are those with the email
/// address, one per school at most. Where an address is known to some of them only, an account at one
/// school must not give more attempts at the others: after too many, only those to which it is known
/// are reached.
///
/// # Errors
/// Fails if no attempt is left, with the time until the next one.
pub async fn take_sign_in(
    service: &Service,
    address: IpAddr,
    email: &str,
    accounts: Vec<PersonId>,
) -> Result<SignInReach, Error> {
    let mut known = Vec::new();
    for &account in &accounts {
        let until = rate_limits::find_brake(service.db.reader(), &known_key(address, account)).await?;
        known.extend(until.filter(|&until| until > service.clock.now()).map(|_| account));
    }
    let is_known = !known.is_empty();
    let own = || {
        vec![
            Brake::new(ADDRESS, &format!("address {address}")),
            Brake::new(PAIR, &format!("pair {}", pair(address, email))),
        ]
    };
    if !is_known || known.len() < accounts.len() {
        let mut all = own();
        all.push(Brake::new(STRANGERS, &format!("strangers {}", normalize_email(email))));
        match press_all(service, &all).await {
            Err(Error::TooMany { .. }) if is_known => {}
            pressed => return pressed.map(|()| SignInReach { accounts, is_known }),
        }
    }
    press_all(service, &own()).await?;
    Ok(SignInReach { accounts: known, is_known })
}

/// Records that the correct password of an account came from an address.
///
/// # Errors
/// Fails if the database fails.
pub async fn welcome(service: &Service, address: IpAddr, account: PersonId) -> Result<(), Error> {
    let mut tx = service.db.write().await?;
    rate_limits::put_brake(&mut tx, &known_key(address, account), service.clock.now().plus_s(KNOWN_S)).await?;
    Ok(tx.commit().await?)
}

/// Counts a sign-in by a provider that is begun from an address.
///
/// # Errors
/// Fails if no attempt is left, with the time until the next one.
pub async fn take_provider_sign_in(service: &Service, address: IpAddr) -> Result<(), Error> {
    press_all(service, &[Brake::new(ADDRESS, &format!("provider {address}"))]).await
}

/// Counts a launch from a learning platform that is begun from an address.
///
/// # Errors
/// Fails if no attempt is left, with the time until the next one.
pub async fn take_launch_start(service: &Service, address: IpAddr) -> Result<(), Error> {
    press_all(service, &[Brake::new(LAUNCH_ADDRESS, &format!("launch {address}"))]).await
}

/// Counts a launch that a learning platform has confirmed. Unconfirmed launches do not use up its limit.
///
/// # Errors
/// Fails if no launch is left, with the time until the next one.
pub async fn take_launch(service: &Service, platform: PlatformId) -> Result<(), Error> {
    press_all(service, &[Brake::new(LAUNCH, &format!("platform {platform}"))]).await
}

/// Counts an attempt by a signed-in person to confirm their own password.
///
/// # Errors
/// Fails if no attempt is left, with the time until the next one.
pub async fn take_own(service: &Service, person: PersonId) -> Result<(), Error> {
    press_all(service, &[Brake::new(PAIR, &format!("own {person}"))]).await
}

/// Counts an attempt with a second-factor code, from any address: the caller already knows the
/// password.
///
/// # Errors
/// Fails if no attempt is left, with the time until the next one.
pub async fn take_code(service: &Service, person: PersonId) -> Result<(), Error> {
    press_all(service, &[Brake::new(CODE, &format!("code {person}"))]).await
}

/// Counts an attempt with a pairing code, right or wrong.
///
/// # Errors
/// Fails if no attempt is left, with the time until the next one.
pub async fn take_pairing(service: &Service, address: IpAddr) -> Result<(), Error> {
    press_all(service, &[Brake::new(PAIRING, &format!("pairing {address}"))]).await
}

/// Counts a wrong secret of a calendar. Right ones do not count, because programs read calendars often.
///
/// # Errors
/// Fails if no attempt is left, with the time until the next one.
pub async fn take_calendar_guess(service: &Service, address: IpAddr) -> Result<(), Error> {
    press_all(service, &[Brake::new(PAIRING, &format!("calendar {address}"))]).await
}

#[cfg(test)]
mod tests {
    //! A limit must not let one more attempt through in each round, and a clock that jumps must not
    //! lock a person out for ever.

    use super::*;

    #[test]
    fn so_many_are_taken_in_a_row_and_then_one_in_each_period() {
        let start = Moment::from_micros(1_700_000_000_000_000);
        let mut until = None;
        for _ in 0..PAIR.burst {
            until = Some(PAIR.count(until, start).unwrap());
        }
        assert_eq!(PAIR.count(until, start), Err(31));
        assert_eq!(PAIR.count(until, start.plus_s(29)), Err(2));
        until = Some(PAIR.count(until, start.plus_s(30)).unwrap());
        assert!(PAIR.count(until, start.plus_s(30)).is_err(), "one, and no more");
        let later = start.plus_s(3600);
        for _ in 0..PAIR.burst {
            until = Some(PAIR.count(until, later).unwrap());
        }
        assert!(PAIR.count(until, later).is_err(), "who has waited for long has no more than at first");
    }

    #[test]
    fn a_clock_that_is_set_back_locks_nobody_out() {
        let start = Moment::from_micros(1_700_000_000_000_000);
        let until = Some(start.plus_s(1_000_000));
        let wait_s = PAIR.count(until, start).unwrap_err();
        assert!(PAIR.count(until.map(|_| start.plus_s(300)), start.plus_s(i64::try_from(wait_s).unwrap())).is_ok());
    }
}
