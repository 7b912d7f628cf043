//! What passkeys were asked and have not answered yet.

use model::Moment;
use model::ids::{CeremonyId, PersonId};
use serde::Serialize;
use serde::de::DeserializeOwned;
use sqlx::FromRow;

use super::{Connection, Json, Result};

/// A question to somebody's passkeys: `T` is what the answer is held to.
#[derive(Clone, Debug, FromRow)]
pub struct PendingCeremony<T> {
    /// Who was asked.
    pub person_id: PersonId,
    /// How long an answer is waited for.
    pub until: Moment,
    /// What the answer is held to.
    pub asked: Json<T>,
}

/// Waits for an answer, in place of the person's oldest question where there are `most`.
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

/// What was asked by an id, this once.
pub async fn take_ceremony<T: DeserializeOwned + Send + Unpin>(
    writer: &mut Connection,
    id: CeremonyId,
) -> Result<Option<PendingCeremony<T>>> {
    sqlx::query_as("DELETE FROM ceremonies WHERE id = $1 RETURNING person_id, until, asked")
        .bind(id)
        .fetch_optional(writer)
        .await
}

/// Forgets questions that are answered too late by now.
pub async fn forget_ceremonies(writer: &mut Connection, now: Moment) -> Result<()> {
    sqlx::query("DELETE FROM ceremonies WHERE until < $1").bind(now).execute(writer).await.map(drop)
}
