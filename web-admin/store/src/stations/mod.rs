//! Training stations: pairing codes, last activity, and failed sign-ins at the station. A station
//! is a row of `api_tokens`.

pub mod sign_in_codes;

use model::Moment;
use model::ids::{PersonId, SchoolId, StationId, TokenId};
use sqlx::FromRow;

use crate::{Connection, Executor, Result};

/// A station, with a valid or revoked token.
#[derive(Clone, Debug, PartialEq, Eq, FromRow)]
pub struct Station {
    /// Id of its token.
    pub id: StationId,
    /// Name.
    pub station: String,
    /// Time of pairing.
    pub created_at: Moment,
    /// Time of the last request.
    pub last_seen_at: Option<Moment>,
    /// The token was revoked.
    pub revoked: bool,
    /// It has a key and signs its recordings.
    pub signs: bool,
}

/// A code for pairing a station.
#[derive(Clone, Copy, Debug)]
pub struct PairingCode {
    /// School.
    pub school_id: SchoolId,
    /// Administrator who made it.
    pub made_by: PersonId,
    /// Expiry time.
    pub expires_at: Moment,
}

/// Wrong sign-in codes entered at a station.
#[derive(Clone, Copy, Debug, FromRow)]
pub struct WrongCodes {
    /// Number of wrong codes …
    #[sqlx(try_from = "i64")]
    pub wrong_codes: u32,
    /// … since this time.
    pub wrong_since: Option<Moment>,
}

/// Returns the stations of a school, sorted by name.
pub async fn list_stations(executor: impl Executor<'_>, school: SchoolId) -> Result<Vec<Station>> {
    sqlx::query_as(
        "SELECT id, station, created_at, last_seen_at, revoked_at IS NOT NULL AS revoked,
           public_key IS NOT NULL AS signs FROM api_tokens
         WHERE school_id = $1 AND station IS NOT NULL ORDER BY station, created_at",
    )
    .bind(school)
    .fetch_all(executor)
    .await
}

/// Returns the name of a station of a school, revoked or not.
pub async fn find_station_name(executor: impl Executor<'_>, school: SchoolId, id: StationId) -> Result<Option<String>> {
    sqlx::query_scalar("SELECT station FROM api_tokens WHERE school_id = $1 AND id = $2 AND station IS NOT NULL")
        .bind(school)
        .bind(id)
        .fetch_optional(executor)
        .await
}

/// A station that can sign recordings.
#[derive(Clone, Debug, PartialEq, Eq, FromRow)]
pub struct Signer {
    /// Id of its token.
    pub id: StationId,
    /// Time of pairing.
    pub created_at: Moment,
    /// Ed25519 public key, 64 hexadecimal digits.
    pub public_key: String,
}

/// Returns a station of a school if it is paired and has a key.
pub async fn find_station_signer(
    executor: impl Executor<'_>,
    school: SchoolId,
    id: StationId,
) -> Result<Option<Signer>> {
    sqlx::query_as(
        "SELECT id, created_at, public_key FROM api_tokens
         WHERE school_id = $1 AND id = $2 AND station IS NOT NULL AND revoked_at IS NULL AND public_key IS NOT NULL",
    )
    .bind(school)
    .bind(id)
    .fetch_optional(executor)
    .await
}

/// Stores the key of a newly paired station.
pub async fn set_station_key(writer: &mut Connection, school: SchoolId, id: StationId, public_key: &str) -> Result<()> {
    sqlx::query("UPDATE api_tokens SET public_key = $3 WHERE school_id = $1 AND id = $2")
        .bind(school)
        .bind(id)
        .bind(public_key)
        .execute(writer)
        .await
        .map(drop)
}

/// Returns whether a station of a school with a valid token has this name.
pub async fn is_station_name_taken(executor: impl Executor<'_>, school: SchoolId, name: &str) -> Result<bool> {
    sqlx::query_scalar(
        "SELECT EXISTS (SELECT 1 FROM api_tokens WHERE school_id = $1 AND station = $2 AND revoked_at IS NULL)",
    )
    .bind(school)
    .bind(name)
    .fetch_one(executor)
    .await
}

/// Records the time at which a token of a station or a person was used.
pub async fn note_station_seen(writer: &mut Connection, school: SchoolId, id: TokenId, now: Moment) -> Result<()> {
    sqlx::query("UPDATE api_tokens SET last_seen_at = $3 WHERE school_id = $1 AND id = $2")
        .bind(school)
        .bind(id)
        .bind(now)
        .execute(writer)
        .await
        .map(drop)
}

/// Revokes the token of a station. Returns false if it does not exist or was already revoked.
pub async fn revoke_station(writer: &mut Connection, school: SchoolId, id: StationId, now: Moment) -> Result<bool> {
    sqlx::query(
        "UPDATE api_tokens SET revoked_at = $3
         WHERE school_id = $1 AND id = $2 AND station IS NOT NULL AND revoked_at IS NULL",
    )
    .bind(school)
    .bind(id)
    .bind(now)
    .execute(writer)
    .await
    .map(|done| done.rows_affected() == 1)
}

/// Stores the hash of a pairing code, and deletes expired ones.
pub async fn add_pairing_code(
    writer: &mut Connection,
    code: &PairingCode,
    code_sha256: &[u8; 32],
    now: Moment,
) -> Result<()> {
    sqlx::query("DELETE FROM pairing_codes WHERE expires_at <= $1").bind(now).execute(&mut *writer).await?;
    sqlx::query("INSERT INTO pairing_codes (code_sha256, school_id, made_by, expires_at) VALUES ($1, $2, $3, $4)")
        .bind(code_sha256.as_slice())
        .bind(code.school_id)
        .bind(code.made_by)
        .bind(code.expires_at)
        .execute(writer)
        .await
        .map(drop)
}

/// Uses up a valid pairing code. Returns the school that it belongs to.
pub async fn use_pairing_code(
    writer: &mut Connection,
    code_sha256: &[u8; 32],
    now: Moment,
) -> Result<Option<SchoolId>> {
    sqlx::query_scalar("DELETE FROM pairing_codes WHERE code_sha256 = $1 AND expires_at > $2 RETURNING school_id")
        .bind(code_sha256.as_slice())
        .bind(now)
        .fetch_optional(writer)
        .await
}

/// Returns the number of wrong sign-in codes entered at a station.
pub async fn find_wrong_codes(executor: impl Executor<'_>, school: SchoolId, id: StationId) -> Result<WrongCodes> {
    sqlx::query_as("SELECT wrong_codes, wrong_since FROM api_tokens WHERE school_id = $1 AND id = $2")
        .bind(school)
        .bind(id)
        .fetch_one(executor)
        .await
}

/// Sets the number of wrong sign-in codes entered at a station.
pub async fn set_wrong_codes(
    writer: &mut Connection,
    school: SchoolId,
    id: StationId,
    wrong: WrongCodes,
) -> Result<()> {
    sqlx::query("UPDATE api_tokens SET wrong_codes = $3, wrong_since = $4 WHERE school_id = $1 AND id = $2")
        .bind(school)
        .bind(id)
        .bind(i64::from(wrong.wrong_codes))
        .bind(wrong.wrong_since)
        .execute(writer)
        .await
        .map(drop)
}

/// Decrements the number of wrong sign-in codes, after a code that turned out to be correct.
pub async fn forgive_wrong_codes(writer: &mut Connection, school: SchoolId, id: StationId) -> Result<()> {
    sqlx::query(
        "UPDATE api_tokens SET wrong_codes = wrong_codes - 1 WHERE school_id = $1 AND id = $2 AND wrong_codes > 0",
    )
    .bind(school)
    .bind(id)
    .execute(writer)
    .await
    .map(drop)
}
