//! Processes that are at work on one database, and what each of them has in hand.

use model::ids::ReplicaId;
use sqlx::FromRow;

use super::{Connection, Executor, Result};

/// How often a replica has said that it is alive.
#[derive(Clone, Copy, Debug, PartialEq, Eq, FromRow)]
pub struct ReplicaBeats {
    /// Who.
    pub id: ReplicaId,
    /// How often.
    pub beats: i64,
}

/// Enters a replica among those at work, where it is not: before its first hold, or once it was taken for dead and is not.
pub async fn enrol_replica(writer: &mut Connection, id: ReplicaId) -> Result<()> {
    sqlx::query("INSERT INTO replicas (id) VALUES ($1) ON CONFLICT (id) DO NOTHING")
        .bind(id)
        .execute(writer)
        .await
        .map(drop)
}

/// Notes that a replica is alive.
pub async fn beat_replica(writer: &mut Connection, id: ReplicaId) -> Result<()> {
    sqlx::query(
        "INSERT INTO replicas (id, beats) VALUES ($1, 1) ON CONFLICT (id) DO UPDATE SET beats = replicas.beats + 1",
    )
    .bind(id)
    .execute(writer)
    .await
    .map(drop)
}

/// Everybody who is at work.
pub async fn list_replicas(executor: impl Executor<'_>) -> Result<Vec<ReplicaBeats>> {
    sqlx::query_as("SELECT id, beats FROM replicas ORDER BY id").fetch_all(executor).await
}

/// Lets go of everything that a replica holds and takes it from among those at work.
pub(crate) async fn remove_replica(writer: &mut Connection, id: ReplicaId) -> Result<()> {
    sqlx::query("DELETE FROM replicas WHERE id = $1").bind(id).execute(writer).await.map(drop)
}

/// Who does something for all, if anybody.
pub async fn find_duty_holder(executor: impl Executor<'_>, duty: &str) -> Result<Option<ReplicaId>> {
    sqlx::query_scalar("SELECT replica_id FROM duties WHERE name = $1").bind(duty).fetch_optional(executor).await
}

/// Takes over what one does for all, where nobody does it.
pub async fn take_duty(writer: &mut Connection, duty: &str, replica: ReplicaId) -> Result<()> {
    enrol_replica(&mut *writer, replica).await?;
    sqlx::query("INSERT INTO duties (name, replica_id) VALUES ($1, $2) ON CONFLICT (name) DO NOTHING")
        .bind(duty)
        .bind(replica)
        .execute(writer)
        .await
        .map(drop)
}
