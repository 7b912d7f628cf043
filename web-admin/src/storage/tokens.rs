//! Bearer tokens of the API: only their hashes are here.

use sqlx::{FromRow, SqliteConnection, SqliteExecutor};
use uuid::Uuid;

use super::Result;
use crate::domain::{Moment, new_id};

/// Whom a token stands for.
#[derive(Clone, Debug, PartialEq, Eq, FromRow)]
pub struct TokenHolder {
    /// School.
    pub school_id: Uuid,
    /// The person, or
    pub person_id: Option<Uuid>,
    /// the station, by name.
    pub station: Option<String>,
}

/// A token that is valid.
#[derive(Clone, Debug, PartialEq, Eq, FromRow)]
pub struct Token {
    /// Its own id.
    pub id: Uuid,
    /// School.
    pub school_id: Uuid,
    /// The person it stands for, or
    pub person_id: Option<Uuid>,
    /// the station, by name.
    pub station: Option<String>,
    /// When a station last used it.
    pub last_seen_at: Option<Moment>,
}

/// Keeps the hash of a new token.
///
/// # Errors
/// When the database fails.
pub async fn add(
    writer: &mut SqliteConnection,
    holder: &TokenHolder,
    token_sha256: &[u8; 32],
    now: Moment,
) -> Result<Uuid> {
    sqlx::query_scalar(
        "INSERT INTO api_tokens (id, school_id, person_id, station, token_sha256, created_at)
         VALUES ($1, $2, $3, $4, $5, $6) RETURNING id",
    )
    .bind(new_id(now))
    .bind(holder.school_id)
    .bind(holder.person_id)
    .bind(&holder.station)
    .bind(token_sha256.as_slice())
    .bind(now)
    .fetch_one(writer)
    .await
}

/// The token with this hash, unless it was revoked.
///
/// # Errors
/// When the database fails.
pub async fn valid(executor: impl SqliteExecutor<'_>, token_sha256: &[u8; 32]) -> Result<Option<Token>> {
    sqlx::query_as(
        "SELECT id, school_id, person_id, station, last_seen_at FROM api_tokens
         WHERE token_sha256 = $1 AND revoked_at IS NULL",
    )
    .bind(token_sha256.as_slice())
    .fetch_optional(executor)
    .await
}

/// Revokes every token of a person; says how many there were.
///
/// # Errors
/// When the database fails.
pub async fn revoke_all(writer: &mut SqliteConnection, person: Uuid, now: Moment) -> Result<u64> {
    sqlx::query("UPDATE api_tokens SET revoked_at = $2 WHERE person_id = $1 AND revoked_at IS NULL")
        .bind(person)
        .bind(now)
        .execute(writer)
        .await
        .map(|done| done.rows_affected())
}
