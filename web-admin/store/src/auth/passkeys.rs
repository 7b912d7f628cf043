//! Passkeys of people: WebAuthn credentials, each with a name.

use model::ids::PasskeyId;
use model::{Moment, PersonKey};
use sqlx::FromRow;

use crate::{Connection, Executor, Result};

/// A stored passkey.
#[derive(Clone, Debug, FromRow)]
pub struct KeptPasskey {
    /// Id.
    pub id: PasskeyId,
    /// Name given by its owner.
    pub name: String,
    /// Public key and signature counter, in the relying party's JSON format.
    pub public_key: String,
    /// Time of registration.
    pub made_at: Moment,
    /// Time of the last sign-in; `None` if it was never used.
    pub last_used_at: Option<Moment>,
}

/// A passkey to be stored.
#[derive(Clone, Copy, Debug)]
pub struct NewPasskey<'a> {
    /// Id.
    pub id: PasskeyId,
    /// Name given by its owner.
    pub name: &'a str,
    /// Id of the WebAuthn credential.
    pub credential_id: &'a [u8],
    /// Public key and signature counter, in the relying party's JSON format.
    pub public_key: &'a str,
    /// Time of registration.
    pub made_at: Moment,
}

/// A verified signature of a passkey.
#[derive(Clone, Copy, Debug)]
pub struct PasskeySignature<'a> {
    /// Id of the WebAuthn credential.
    pub credential_id: &'a [u8],
    /// Public key and counter after the signature, in the relying party's JSON format.
    pub public_key: &'a str,
    /// Signature counter of the authenticator; 0 if it does not count.
    pub count: u32,
    /// Time of the signature.
    pub at: Moment,
}

/// Returns a person's passkeys, oldest first.
///
/// # Errors
/// If the database fails.
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

/// Returns one of a person's passkeys.
///
/// # Errors
/// If the database fails.
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

/// Stores a passkey. Returns false if the credential is already registered, to any person.
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

/// Renames a passkey. Returns false if it does not exist.
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

/// Deletes a passkey. Returns false if it does not exist.
pub async fn remove_passkey(writer: &mut Connection, key: PersonKey, id: PasskeyId) -> Result<bool> {
    sqlx::query("DELETE FROM passkeys WHERE id = $3 AND person_id = $1 AND school_id = $2")
        .bind(key.person_id)
        .bind(key.school_id)
        .bind(id)
        .execute(writer)
        .await
        .map(|done| done.rows_affected() == 1)
}

/// Records a signature. Returns false if its counter is not higher than the last one, or the
/// passkey no longer exists: if two authenticators share a cloned key, at least one of them has a
/// lower counter.
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
