//! State of the rate limits on sign-in, codes and pairing, and of the addresses known from earlier
//! sign-ins; counts of sign-ins with unknown email addresses.

use model::Moment;
use sqlx::FromRow;

use crate::{Connection, Executor, Result};

/// Returns the time until which the attempts recorded for a key use up its rate limit.
pub async fn find_brake(executor: impl Executor<'_>, key_sha256: &[u8; 32]) -> Result<Option<Moment>> {
    sqlx::query_scalar("SELECT until FROM brakes WHERE key_sha256 = $1")
        .bind(key_sha256.as_slice())
        .fetch_optional(executor)
        .await
}

/// Records the time until which the attempts for a key use up its rate limit.
pub async fn put_brake(writer: &mut Connection, key_sha256: &[u8; 32], until: Moment) -> Result<()> {
    sqlx::query(
        "INSERT INTO brakes (key_sha256, until) VALUES ($1, $2) ON CONFLICT (key_sha256) DO UPDATE SET until = $2",
    )
    .bind(key_sha256.as_slice())
    .bind(until)
    .execute(writer)
    .await
    .map(drop)
}

/// Deletes rate-limit entries that have expired.
pub async fn forget_brakes(writer: &mut Connection, now: Moment) -> Result<()> {
    sqlx::query("DELETE FROM brakes WHERE until < $1").bind(now).execute(writer).await.map(drop)
}

/// One hour, in µs.
const HOUR_US: i64 = 3600 * 1_000_000;

/// Number of sign-in attempts with unknown email addresses in one hour.
#[derive(Clone, Copy, Debug, PartialEq, Eq, FromRow)]
pub struct UnknownSignIns {
    /// Start of the hour.
    pub begins_at: Moment,
    /// Number of attempts.
    pub tries: i64,
}

fn hour_of(now: Moment) -> Moment {
    Moment::from_micros(now.micros() - now.micros().rem_euclid(HOUR_US))
}

/// Counts a sign-in attempt with an unknown email address.
pub async fn count_unknown_sign_in(writer: &mut Connection, now: Moment) -> Result<()> {
    sqlx::query(
        "INSERT INTO unknown_sign_ins (begins_at, tries) VALUES ($1, 1)
         ON CONFLICT (begins_at) DO UPDATE SET tries = unknown_sign_ins.tries + 1",
    )
    .bind(hour_of(now))
    .execute(writer)
    .await
    .map(drop)
}

/// Removes and returns the counts of completed hours, earliest first.
pub async fn take_unknown_sign_ins(writer: &mut Connection, now: Moment) -> Result<Vec<UnknownSignIns>> {
    let over = sqlx::query_as("DELETE FROM unknown_sign_ins WHERE begins_at < $1 RETURNING begins_at, tries");
    let mut over: Vec<UnknownSignIns> = over.bind(hour_of(now)).fetch_all(writer).await?;
    over.sort_by_key(|hour| hour.begins_at);
    Ok(over)
}
