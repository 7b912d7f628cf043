//! Passkeys: public keys that sign for somebody when they sign in, each with its name.

use model::ids::PasskeyId;
use model::{Moment, PersonKey};
use sqlx::FromRow;

use super::{Connection, Executor, Result};

/// A passkey as it is kept.
#[derive(Clone, Debug, FromRow)]
pub struct KeptPasskey {
    /// Id of ours.
    pub id: PasskeyId,
    /// What its owner calls it.
    pub name: String,
    /// The public key, with its counter, in the JSON of the relying party.
    pub public_key: String,
    /// When it was added.
    pub made_at: Moment,
    /// When it last signed; absent while it has not since it was added.
    pub last_used_at: Option<Moment>,
}

/// A passkey that is to be kept.
#[derive(Clone, Copy, Debug)]
pub struct NewPasskey<'a> {
    /// Id of ours.
    pub id: PasskeyId,
    /// What its owner calls it.
    pub name: &'a str,
    /// Id of its credential.
    pub credential_id: &'a [u8],
    /// The public key, with its counter, in the JSON of the relying party.
    pub public_key: &'a str,
    /// When it was added.
    pub made_at: Moment,
}

/// A signature of a passkey.
#[derive(Clone, Copy, Debug)]
pub struct PasskeySignature<'a> {
    /// Id of the passkey's credential.
    pub credential_id: &'a [u8],
    /// The public key after the signature, in the JSON of the relying party.
    pub public_key: &'a str,
    /// How many signatures the authenticator has counted; 0 where it counts none.
    pub count: u32,
    /// When.
    pub at: Moment,
}

/// Somebody's passkeys, the oldest first.
///
/// # Errors
/// When the database fails.
pub async fn list_passkeys(executor: impl Executor<'_>, key: PersonKey) -> Result<Vec<KeptPasskey>> {
    sqlx::query_as(
        "SELECT id, name, public_key, made_at, last_used_at FROM passkeys
         WHERE person_id = $1 AND school_id = $2 ORDER BY made_at, id",
    )
    .bind(key.person_id)
    .bind(key.school_id)
    .fetch_all(executor)
    .await
}

/// One of somebody's passkeys.
///
/// # Errors
/// When the database fails.
pub async fn find_passkey(executor: impl Executor<'_>, key: PersonKey, id: PasskeyId) -> Result<Option<KeptPasskey>> {
    sqlx::query_as(
        "SELECT id, name, public_key, made_at, last_used_at FROM passkeys
         WHERE id = $3 AND person_id = $1 AND school_id = $2",
    )
    .bind(key.person_id)
    .bind(key.school_id)
    .bind(id)
    .fetch_optional(executor)
    .await
}

/// Keeps a passkey. False where it is known already, here or to somebody else.
pub async fn add_passkey(writer: &mut Connection, key: PersonKey, new: NewPasskey<'_>) -> Result<bool> {
    sqlx::query(
        "INSERT INTO passkeys (id, school_id, person_id, name, credential_id, public_key, sign_count, made_at)
         VALUES ($1, $2, $3, $4, $5, $6, 0, $7) ON CONFLICT (credential_id) DO NOTHING",
    )
    .bind(new.id)
    .bind(key.school_id)
    .bind(key.person_id)
    .bind(new.name)
    .bind(new.credential_id)
    .bind(new.public_key)
    .bind(new.made_at)
    .execute(writer)
    .await
    .map(|done| done.rows_affected() == 1)
}

/// Gives a passkey another name. False where there is none.
pub async fn rename_passkey(writer: &mut Connection, key: PersonKey, id: PasskeyId, name: &str) -> Result<bool> {
    sqlx::query("UPDATE passkeys SET name = $4 WHERE id = $3 AND person_id = $1 AND school_id = $2")
        .bind(key.person_id)
        .bind(key.school_id)
        .bind(id)
        .bind(name)
        .execute(writer)
        .await
        .map(|done| done.rows_affected() == 1)
}

/// Forgets a passkey. False where there is none.
pub async fn remove_passkey(writer: &mut Connection, key: PersonKey, id: PasskeyId) -> Result<bool> {
    sqlx::query("DELETE FROM passkeys WHERE id = $3 AND person_id = $1 AND school_id = $2")
        .bind(key.person_id)
        .bind(key.school_id)
        .bind(id)
        .execute(writer)
        .await
        .map(|done| done.rows_affected() == 1)
}

/// Takes a signature. False where its counter does not go on from the last one's, or there is no such passkey any more: of two
/// authenticators that hold one key, at least one counts behind the other.
pub async fn take_signature(writer: &mut Connection, key: PersonKey, signature: PasskeySignature<'_>) -> Result<bool> {
    sqlx::query(
        "UPDATE passkeys SET public_key = $4, sign_count = $5, last_used_at = $6
         WHERE credential_id = $3 AND person_id = $1 AND school_id = $2
             AND (sign_count < $5 OR (sign_count = 0 AND $5 = 0))",
    )
    .bind(key.person_id)
    .bind(key.school_id)
    .bind(signature.credential_id)
    .bind(signature.public_key)
    .bind(i64::from(signature.count))
    .bind(signature.at)
    .execute(writer)
    .await
    .map(|done| done.rows_affected() == 1)
}
