//! Second factors: encrypted secrets of authenticator apps (TOTP), hashes of recovery codes, and
//! the schools' rules.

use model::ids::SchoolId;
use model::{FactorRule, Moment, PersonKey};
use sqlx::FromRow;

use crate::{Connection, Executor, Result};

/// The secret of an authenticator app.
#[derive(Clone, Debug, PartialEq, Eq, FromRow)]
pub struct SecondFactor {
    /// The secret, encrypted.
    pub sealed_secret: Vec<u8>,
    /// Time at which it was offered.
    pub made_at: Moment,
    /// Time at which it was confirmed; `None` while it is only offered.
    pub confirmed_at: Option<Moment>,
}

/// Returns a person's second factor, confirmed or only offered.
pub async fn find_second_factor(executor: impl Executor<'_>, key: PersonKey) -> Result<Option<SecondFactor>> {
    sqlx::query_as(
        "SELECT sealed_secret, made_at, confirmed_at FROM second_factors WHERE person_id = $1 AND school_id = $2",
    )
    .bind(key.person_id)
    .bind(key.school_id)
    .fetch_optional(executor)
    .await
}

/// Returns whether sign-in needs more than the password: a code of an app, or a passkey.
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

/// Wraps a statement around the condition that person `p` of school `s` is required to have a
/// second factor and has none.
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

/// Returns whether a person is required by their school to have a second factor and has none.
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

/// Offers a secret and replaces an unconfirmed one. Returns false if one is already confirmed.
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

/// Confirms the offered secret with the code of a time step. Returns false without such a secret.
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

/// Records the use of the code of a time step. Returns false if this step or a later one was
/// already used, because each code is valid once.
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

/// Deletes a person's confirmed secret. Returns false if it does not exist.
pub async fn remove_app(writer: &mut Connection, key: PersonKey) -> Result<bool> {
    sqlx::query("DELETE FROM second_factors WHERE person_id = $1 AND school_id = $2 AND confirmed_at IS NOT NULL")
        .bind(key.person_id)
        .bind(key.school_id)
        .execute(writer)
        .await
        .map(|done| done.rows_affected() == 1)
}

/// Deletes all second factors of a person: app, passkeys and recovery codes. Returns false if
/// neither an app nor a passkey was active.
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

/// Replaces the hashes of a person's recovery codes.
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

/// Deletes a used recovery code. Returns false if the person has no such code.
pub async fn use_recovery_code(writer: &mut Connection, key: PersonKey, hash: &[u8; 32]) -> Result<bool> {
    sqlx::query("DELETE FROM recovery_codes WHERE person_id = $1 AND school_id = $2 AND code_hash = $3")
        .bind(key.person_id)
        .bind(key.school_id)
        .bind(hash.as_slice())
        .execute(writer)
        .await
        .map(|done| done.rows_affected() == 1)
}

/// Returns the number of a person's unused recovery codes.
pub async fn recovery_codes_left(executor: impl Executor<'_>, key: PersonKey) -> Result<i64> {
    sqlx::query_scalar("SELECT count(*) FROM recovery_codes WHERE person_id = $1 AND school_id = $2")
        .bind(key.person_id)
        .bind(key.school_id)
        .fetch_one(executor)
        .await
}

/// Returns a school's rule on who needs a second factor.
///
/// # Errors
/// If there is no such school, or the database fails.
pub async fn find_factor_rule(executor: impl Executor<'_>, school: SchoolId) -> Result<FactorRule> {
    sqlx::query_scalar("SELECT second_factor_of FROM schools WHERE id = $1").bind(school).fetch_one(executor).await
}

/// Sets a school's rule on who needs a second factor.
pub async fn set_factor_rule(writer: &mut Connection, school: SchoolId, rule: FactorRule) -> Result<()> {
    sqlx::query("UPDATE schools SET second_factor_of = $2 WHERE id = $1")
        .bind(school)
        .bind(rule)
        .execute(writer)
        .await
        .map(drop)
}
