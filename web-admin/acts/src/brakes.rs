//! Brakes on guessing passwords, codes and pairings, by account and by address. They are kept in the database: whoever guesses has
//! the same tries at one service or at many.

use std::net::IpAddr;

use model::Moment;
use model::email::normalize_email;
use model::ids::PersonId;
use store::{Connection, Executor, brakes};

use crate::error::Error;
use crate::secret;
use crate::service::Service;

/// Tries in a row, and the pace afterwards.
#[derive(Clone, Copy, Debug)]
struct BrakePace {
    burst: i64,
    period_s: i64,
}

/// Tries for one account from one address.
const PAIR: BrakePace = BrakePace { burst: 10, period_s: 30 };
/// Tries for one account from all addresses that never got in: no single one of them uses them up.
const STRANGERS: BrakePace = BrakePace { burst: 100, period_s: 5 };
/// Tries from one address: a class that signs in at once through one router passes.
const ADDRESS: BrakePace = BrakePace { burst: 100, period_s: 2 };
/// Codes of a second factor tried for one person: three of a million are right at a time.
const CODE: BrakePace = BrakePace { burst: 10, period_s: 120 };
/// Pairing codes tried from one address.
const PAIRING: BrakePace = BrakePace { burst: 10, period_s: 30 };
/// How long it is known that the right password came from an address, in s.
const KNOWN_S: i64 = 90 * 24 * 3600;

impl BrakePace {
    /// Until when a further try counts, with those that count until a moment; where there is none left, how long until there is, in s.
    fn count(self, until: Option<Moment>, now: Moment) -> Result<Moment, u64> {
        let most = now.plus_s(self.burst * self.period_s);
        // Whatever counts for longer was counted by a clock that has been set back since.
        let next = until.map_or(now, |until| until.clamp(now, most)).plus_s(self.period_s);
        if next <= most { Ok(next) } else { Err(next.duration_since(most).as_secs() + 1) }
    }
}

/// What somebody uses up with a try.
struct Brake {
    key_sha256: [u8; 32],
    pace: BrakePace,
}

impl Brake {
    /// Hashed, so that what a stranger types takes the same room whatever its length, and no address lies in the database.
    fn new(pace: BrakePace, of: &str) -> Self {
        Self { key_sha256: secret::token_sha256(of), pace }
    }

    /// Until when a further try counts.
    async fn count(&self, executor: impl Executor<'_>, now: Moment) -> Result<Moment, Error> {
        let until = brakes::find_brake(executor, &self.key_sha256).await?;
        self.pace.count(until, now).map_err(refuse)
    }

    async fn press(&self, tx: &mut Connection, now: Moment) -> Result<(), Error> {
        let next = self.count(&mut *tx, now).await?;
        Ok(brakes::put_brake(tx, &self.key_sha256, next).await?)
    }
}

const fn refuse(retry_after_s: u64) -> Error {
    Error::TooMany { retry_after_s }
}

/// Takes a try: all of what it uses up, or nothing where one of them is used up.
async fn press_all(service: &Service, brakes: &[Brake]) -> Result<(), Error> {
    let now = service.clock.now();
    // Whoever is held up writes nothing.
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

fn known_key(address: IpAddr, email: &str) -> [u8; 32] {
    secret::token_sha256(&format!("known {}", pair(address, email)))
}

/// Takes a try to sign in, right or wrong: a right password waits its turn too, else the brake would tell which it is.
///
/// Whoever guesses at an account uses up their own tries, and at the utmost those of all strangers: where its owner has signed
/// in before, they still can.
///
/// # Errors
/// When there is none left, with the time until there is.
pub async fn take_sign_in(service: &Service, address: IpAddr, email: &str) -> Result<(), Error> {
    let mut used = vec![
        Brake::new(ADDRESS, &format!("address {address}")),
        Brake::new(PAIR, &format!("pair {}", pair(address, email))),
    ];
    if !is_known(service, address, email).await? {
        used.push(Brake::new(STRANGERS, &format!("strangers {}", normalize_email(email))));
    }
    press_all(service, &used).await
}

/// Whether the right password of an account came from an address before.
///
/// # Errors
/// When the database fails.
pub async fn is_known(service: &Service, address: IpAddr, email: &str) -> Result<bool, Error> {
    let until = brakes::find_brake(service.db.reader(), &known_key(address, email)).await?;
    Ok(until.is_some_and(|until| until > service.clock.now()))
}

/// Remembers that the right password came from an address.
///
/// # Errors
/// When the database fails.
pub async fn welcome(service: &Service, address: IpAddr, email: &str) -> Result<(), Error> {
    let mut tx = service.db.write().await?;
    brakes::put_brake(&mut tx, &known_key(address, email), service.clock.now().plus_s(KNOWN_S)).await?;
    Ok(tx.commit().await?)
}

/// Takes a try of somebody who is signed in and is to say their password once more.
///
/// # Errors
/// When there is none left, with the time until there is.
pub async fn take_own(service: &Service, person: PersonId) -> Result<(), Error> {
    press_all(service, &[Brake::new(PAIR, &format!("own {person}"))]).await
}

/// Takes a try of a code of somebody's second factor, wherever it comes from: whoever tries has their password.
///
/// # Errors
/// When there is none left, with the time until there is.
pub async fn take_code(service: &Service, person: PersonId) -> Result<(), Error> {
    press_all(service, &[Brake::new(CODE, &format!("code {person}"))]).await
}

/// Takes a try of a pairing code, right or wrong.
///
/// # Errors
/// When there is none left, with the time until there is.
pub async fn take_pairing(service: &Service, address: IpAddr) -> Result<(), Error> {
    press_all(service, &[Brake::new(PAIRING, &format!("pairing {address}"))]).await
}

#[cfg(test)]
mod tests {
    //! A brake that lets one more through in each round, or that a clock locks for ever, is none.

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
