//! Bearer tokens of the API. Only their hashes are stored.

use model::ids::{PersonId, SchoolId, TokenId};
use model::{Moment, PersonKey};
use sqlx::FromRow;

use crate::{Connection, Executor, Result};

/// Owner of a token.
#[derive(Clone, Debug, PartialEq, Eq, FromRow)]
pub struct TokenHolder {
    /// School.
    pub school_id: SchoolId,
    /// The person, or
    pub person_id: Option<PersonId>,
    /// the name of the station.
    pub station: Option<String>,
}

/// A token that was not revoked.
#[derive(Clone, Debug, PartialEq, Eq, FromRow)]
pub struct Token {
    /// Id.
    pub id: TokenId,
    /// School.
    pub school_id: SchoolId,
    /// The person, or
    pub person_id: Option<PersonId>,
    /// the name of the station.
    pub station: Option<String>,
    /// Time of last use.
    pub last_seen_at: Option<Moment>,
    /// Expiry time.
    pub expires_at: Option<Moment>,
}

/// A token for a person, with a name and an expiry time.
#[derive(Clone, Copy, Debug)]
pub struct NewToken<'a> {
    /// Owner.
    pub owner: PersonKey,
    /// Name given by the owner.
    pub name: &'a str,
    /// Expiry time.
    pub expires_at: Moment,
}

/// A token, as shown to its owner.
#[derive(Clone, Debug, PartialEq, Eq, FromRow)]
pub struct OwnToken {
    /// Id.
    pub id: TokenId,
    /// Name given by the owner; `None` for tokens made by earlier versions.
    pub name: Option<String>,
    /// Time of creation.
    pub created_at: Moment,
    /// Time of last use, with a resolution of one hour.
    pub last_seen_at: Option<Moment>,
    /// Expiry time; `None` for tokens made by earlier versions.
    pub expires_at: Option<Moment>,
}

/// Stores the hash of a new token that does not expire.
pub async fn add_station_token(
    writer: &mut Connection,
    holder: &TokenHolder,
    token_sha256: &[u8; 32],
    now: Moment,
) -> Result<TokenId> {
    sqlx::query_scalar(
        "INSERT INTO api_tokens (id, school_id, person_id, station, token_sha256, created_at)
         VALUES ($1, $2, $3, $4, $5, $6) RETURNING id",
    )
    .bind(TokenId::made_at(now))
    .bind(holder.school_id)
    .bind(holder.person_id)
    .bind(&holder.station)
    .bind(token_sha256.as_slice())
    .bind(now)
    .fetch_one(writer)
    .await
}

/// Stores the hash of a new token for a person.
pub async fn add_personal_token(
    writer: &mut Connection,
    new: NewToken<'_>,
    token_sha256: &[u8; 32],
    now: Moment,
) -> Result<TokenId> {
    sqlx::query_scalar(
        "INSERT INTO api_tokens (id, school_id, person_id, name, expires_at, token_sha256, created_at)
         VALUES ($1, $2, $3, $4, $5, $6, $7) RETURNING id",
    )
    .bind(TokenId::made_at(now))
    .bind(new.owner.school_id)
    .bind(new.owner.person_id)
    .bind(new.name)
    .bind(new.expires_at)
    .bind(token_sha256.as_slice())
    .bind(now)
    .fetch_one(writer)
    .await
}

/// Returns the token with this hash, unless it was revoked. It may have expired.
pub async fn find_token(executor: impl Executor<'_>, token_sha256: &[u8; 32]) -> Result<Option<Token>> {
    sqlx::query_as(
        "SELECT id, school_id, person_id, station, last_seen_at, expires_at FROM api_tokens
         WHERE token_sha256 = $1 AND revoked_at IS NULL",
    )
    .bind(token_sha256.as_slice())
    .fetch_optional(executor)
    .await
}

/// Returns a person's tokens that were not revoked, newest first.
pub async fn list_tokens_of_person(executor: impl Executor<'_>, owner: PersonKey) -> Result<Vec<OwnToken>> {
    sqlx::query_as(
        "SELECT id, name, created_at, last_seen_at, expires_at FROM api_tokens
         WHERE person_id = $1 AND school_id = $2 AND revoked_at IS NULL ORDER BY created_at DESC, id DESC",
    )
    .bind(owner.person_id)
    .bind(owner.school_id)
    .fetch_all(executor)
    .await
}

/// Revokes a token of a person. Returns false if it does not exist or was already revoked.
pub async fn revoke_token(writer: &mut Connection, owner: PersonKey, id: TokenId, now: Moment) -> Result<bool> {
    sqlx::query(
        "UPDATE api_tokens SET revoked_at = $4
         WHERE id = $3 AND person_id = $1 AND school_id = $2 AND revoked_at IS NULL",
    )
    .bind(owner.person_id)
    .bind(owner.school_id)
    .bind(id)
    .bind(now)
    .execute(writer)
    .await
    .map(|done| done.rows_affected() == 1)
}

/// Revokes all tokens of a person. Returns their number.
pub async fn revoke_all_tokens(writer: &mut Connection, person: PersonId, now: Moment) -> Result<u64> {
    sqlx::query("UPDATE api_tokens SET revoked_at = $2 WHERE person_id = $1 AND revoked_at IS NULL")
        .bind(person)
        .bind(now)
        .execute(writer)
        .await
        .map(|done| done.rows_affected())
}

/// Deletes the names of a person's tokens.
pub async fn forget_names(writer: &mut Connection, owner: PersonKey) -> Result<()> {
    sqlx::query("UPDATE api_tokens SET name = NULL WHERE person_id = $1 AND school_id = $2")
        .bind(owner.person_id)
        .bind(owner.school_id)
        .execute(writer)
        .await
        .map(drop)
}
