//! Keys with which this service authenticates as a client.

use model::Moment;
use serde_json::Value;
use sqlx::FromRow;

use crate::{Connection, Executor, Json, Result};

/// A key pair. It signs from `signs_from` until the next one does.
#[derive(Clone, Debug, FromRow)]
pub struct StoredClientKey {
    /// Id.
    pub kid: String,
    /// The private key, encrypted.
    pub private_sealed: Vec<u8>,
    /// The public key.
    pub public_jwk: Json<Value>,
    /// Time from which it signs.
    pub signs_from: Moment,
}

/// Returns all keys, by the time from which they sign.
pub async fn list_client_keys(executor: impl Executor<'_>) -> Result<Vec<StoredClientKey>> {
    sqlx::query_as("SELECT kid, private_sealed, public_jwk, signs_from FROM client_keys ORDER BY signs_from, kid")
        .fetch_all(executor)
        .await
}

/// Stores a key, unless another one signs from `after` on or later.
pub async fn add_client_key(writer: &mut Connection, key: &StoredClientKey, after: Moment) -> Result<()> {
    sqlx::query(
        "INSERT INTO client_keys (kid, private_sealed, public_jwk, signs_from)
         SELECT $1, $2, $3, $4 WHERE NOT EXISTS (SELECT 1 FROM client_keys WHERE signs_from >= $5)",
    )
    .bind(&key.kid)
    .bind(&key.private_sealed)
    .bind(&key.public_jwk)
    .bind(key.signs_from)
    .bind(after)
    .execute(writer)
    .await
    .map(drop)
}

/// Deletes a key.
pub async fn delete_client_key(writer: &mut Connection, kid: &str) -> Result<()> {
    sqlx::query("DELETE FROM client_keys WHERE kid = $1").bind(kid).execute(writer).await.map(drop)
}
