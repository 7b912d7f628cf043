//! Pending WebAuthn challenges.

use model::Moment;
use model::ids::{CeremonyId, PersonId};
use serde::Serialize;
use serde::de::DeserializeOwned;
use sqlx::FromRow;

use crate::{Connection, Json, Result};

/// A pending WebAuthn challenge. `T` is the state needed to verify the response.
#[derive(Clone, Debug, FromRow)]
pub struct PendingCeremony<T> {
    /// Person who was challenged.
    pub person_id: PersonId,
    /// Expiry time.
    pub until: Moment,
    /// State needed to verify the response.
    pub asked: Json<T>,
}

/// Stores a challenge. A person has at most `most` pending challenges; the one that expires first
/// is replaced.
pub async fn add_ceremony<T: Serialize + Send + Sync>(
    writer: &mut Connection,
    id: CeremonyId,
    ceremony: &PendingCeremony<T>,
    most: i64,
) -> Result<()> {
    sqlx::query(
        "DELETE FROM ceremonies WHERE person_id = $1 AND id NOT IN (
             SELECT id FROM ceremonies WHERE person_id = $1 ORDER BY until DESC, id LIMIT $2 + 0)",
    )
    .bind(ceremony.person_id)
    .bind(most - 1)
    .execute(&mut *writer)
    .await?;
    sqlx::query("INSERT INTO ceremonies (id, person_id, until, asked) VALUES ($1, $2, $3, $4)")
        .bind(id)
        .bind(ceremony.person_id)
        .bind(ceremony.until)
        .bind(&ceremony.asked)
        .execute(writer)
        .await
        .map(drop)
}

/// Removes and returns a challenge, so that it can be answered only once.
pub async fn take_ceremony<T: DeserializeOwned + Send + Unpin>(
    writer: &mut Connection,
    id: CeremonyId,
) -> Result<Option<PendingCeremony<T>>> {
    sqlx::query_as("DELETE FROM ceremonies WHERE id = $1 RETURNING person_id, until, asked")
        .bind(id)
        .fetch_optional(writer)
        .await
}

/// Deletes expired challenges.
pub async fn forget_ceremonies(writer: &mut Connection, now: Moment) -> Result<()> {
    sqlx::query("DELETE FROM ceremonies WHERE until < $1").bind(now).execute(writer).await.map(drop)
}
