//! Second factors: sealed secrets of apps that make codes, hashes of recovery codes, and of whom a school asks for one.

use model::ids::SchoolId;
use model::{FactorRule, Moment, PersonKey};
use sqlx::FromRow;

use super::{Connection, Executor, Result};

/// A secret that an app makes codes of.
#[derive(Clone, Debug, PartialEq, Eq, FromRow)]
pub struct SecondFactor {
    /// The secret, sealed.
    pub sealed_secret: Vec<u8>,
    /// When it was offered.
    pub made_at: Moment,
    /// Since when codes are asked for; absent while it is only offered.
    pub confirmed_at: Option<Moment>,
}

/// Somebody's second factor, on or only offered.
pub async fn find_second_factor(executor: impl Executor<'_>, key: PersonKey) -> Result<Option<SecondFactor>> {
    sqlx::query_as(
        "SELECT sealed_secret, made_at, confirmed_at FROM second_factors WHERE person_id = $1 AND school_id = $2",
    )
    .bind(key.person_id)
    .bind(key.school_id)
    .fetch_optional(executor)
    .await
}

/// Whether more than the password is asked for when somebody signs in: an app's code, or a passkey.
pub async fn is_second_factor_on(executor: impl Executor<'_>, key: PersonKey) -> Result<bool> {
    sqlx::query_scalar(
        "SELECT EXISTS (SELECT 1 FROM second_factors WHERE person_id = $1 AND school_id = $2 AND confirmed_at IS NOT NULL)
             OR EXISTS (SELECT 1 FROM passkeys WHERE person_id = $1 AND school_id = $2)",
    )
    .bind(key.person_id)
    .bind(key.school_id)
    .fetch_one(executor)
    .await
}

/// A statement around the condition that a person `p` of a school `s` must have a second factor by the school's rule, and has none.
macro_rules! with_factor_owed {
    ($before:literal, $after:literal) => {
        concat!(
            $before,
            "(s.second_factor_of = 'everybody' OR s.second_factor_of = 'teachers' AND p.role <> 'trainee')
             AND NOT EXISTS (SELECT 1 FROM second_factors f WHERE f.person_id = p.id AND f.confirmed_at IS NOT NULL)
             AND NOT EXISTS (SELECT 1 FROM passkeys k WHERE k.person_id = p.id AND k.school_id = p.school_id)",
            $after
        )
    };
}
pub(crate) use with_factor_owed;

/// Whether a person must have a second factor by their school's rule, and has none.
pub async fn is_second_factor_owed(executor: impl Executor<'_>, key: PersonKey) -> Result<bool> {
    sqlx::query_scalar(with_factor_owed!(
        "SELECT EXISTS (SELECT 1 FROM people p JOIN schools s ON s.id = p.school_id
                        WHERE p.id = $1 AND p.school_id = $2 AND ",
        ")"
    ))
    .bind(key.person_id)
    .bind(key.school_id)
    .fetch_one(executor)
    .await
}

/// Offers a secret in place of one that was offered before. False where one is on already.
pub async fn offer_second_factor(
    writer: &mut Connection,
    key: PersonKey,
    sealed_secret: &[u8],
    now: Moment,
) -> Result<bool> {
    sqlx::query(
        "INSERT INTO second_factors (person_id, school_id, sealed_secret, made_at) VALUES ($1, $2, $3, $4)
         ON CONFLICT (person_id) DO UPDATE SET sealed_secret = excluded.sealed_secret, made_at = excluded.made_at
         WHERE second_factors.confirmed_at IS NULL",
    )
    .bind(key.person_id)
    .bind(key.school_id)
    .bind(sealed_secret)
    .bind(now)
    .execute(writer)
    .await
    .map(|done| done.rows_affected() == 1)
}

/// Turns the offered secret on, by the code of a time step. False where none is offered.
pub async fn confirm_second_factor(writer: &mut Connection, key: PersonKey, step: i64, now: Moment) -> Result<bool> {
    sqlx::query(
        "UPDATE second_factors SET confirmed_at = $3, last_step = $4
         WHERE person_id = $1 AND school_id = $2 AND confirmed_at IS NULL",
    )
    .bind(key.person_id)
    .bind(key.school_id)
    .bind(now)
    .bind(step)
    .execute(writer)
    .await
    .map(|done| done.rows_affected() == 1)
}

/// Takes the code of a time step. False where it, or one after it, was taken before: each is good once.
pub async fn take_step(writer: &mut Connection, key: PersonKey, step: i64) -> Result<bool> {
    sqlx::query(
        "UPDATE second_factors SET last_step = $3
         WHERE person_id = $1 AND school_id = $2 AND confirmed_at IS NOT NULL AND last_step < $3",
    )
    .bind(key.person_id)
    .bind(key.school_id)
    .bind(step)
    .execute(writer)
    .await
    .map(|done| done.rows_affected() == 1)
}

/// Forgets the secret of somebody's app. False where none was on.
pub async fn remove_app(writer: &mut Connection, key: PersonKey) -> Result<bool> {
    sqlx::query("DELETE FROM second_factors WHERE person_id = $1 AND school_id = $2 AND confirmed_at IS NOT NULL")
        .bind(key.person_id)
        .bind(key.school_id)
        .execute(writer)
        .await
        .map(|done| done.rows_affected() == 1)
}

/// Forgets all of somebody's second factors, app and passkeys, and their recovery codes. False where none was on.
pub async fn remove_second_factor(writer: &mut Connection, key: PersonKey) -> Result<bool> {
    let was_on = is_second_factor_on(&mut *writer, key).await?;
    for statement in [
        "DELETE FROM recovery_codes WHERE person_id = $1 AND school_id = $2",
        "DELETE FROM second_factors WHERE person_id = $1 AND school_id = $2",
        "DELETE FROM passkeys WHERE person_id = $1 AND school_id = $2",
    ] {
        sqlx::query(statement).bind(key.person_id).bind(key.school_id).execute(&mut *writer).await?;
    }
    Ok(was_on)
}

/// Keeps the hashes of recovery codes, in place of those of before.
pub async fn put_recovery_codes(writer: &mut Connection, key: PersonKey, hashes: &[[u8; 32]]) -> Result<()> {
    sqlx::query("DELETE FROM recovery_codes WHERE person_id = $1 AND school_id = $2")
        .bind(key.person_id)
        .bind(key.school_id)
        .execute(&mut *writer)
        .await?;
    for hash in hashes {
        sqlx::query("INSERT INTO recovery_codes (school_id, person_id, code_hash) VALUES ($1, $2, $3)")
            .bind(key.school_id)
            .bind(key.person_id)
            .bind(hash.as_slice())
            .execute(&mut *writer)
            .await?;
    }
    Ok(())
}

/// Uses a recovery code up. False where it is none of somebody's.
pub async fn use_recovery_code(writer: &mut Connection, key: PersonKey, hash: &[u8; 32]) -> Result<bool> {
    sqlx::query("DELETE FROM recovery_codes WHERE person_id = $1 AND school_id = $2 AND code_hash = $3")
        .bind(key.person_id)
        .bind(key.school_id)
        .bind(hash.as_slice())
        .execute(writer)
        .await
        .map(|done| done.rows_affected() == 1)
}

/// How many recovery codes somebody has left.
pub async fn recovery_codes_left(executor: impl Executor<'_>, key: PersonKey) -> Result<i64> {
    sqlx::query_scalar("SELECT count(*) FROM recovery_codes WHERE person_id = $1 AND school_id = $2")
        .bind(key.person_id)
        .bind(key.school_id)
        .fetch_one(executor)
        .await
}

/// Of whom a school asks for a second factor.
///
/// # Errors
/// When there is no such school, or the database fails.
pub async fn find_factor_rule(executor: impl Executor<'_>, school: SchoolId) -> Result<FactorRule> {
    sqlx::query_scalar("SELECT second_factor_of FROM schools WHERE id = $1").bind(school).fetch_one(executor).await
}

/// Sets of whom a school asks for a second factor.
pub async fn set_factor_rule(writer: &mut Connection, school: SchoolId, rule: FactorRule) -> Result<()> {
    sqlx::query("UPDATE schools SET second_factor_of = $2 WHERE id = $1")
        .bind(school)
        .bind(rule)
        .execute(writer)
        .await
        .map(drop)
}
