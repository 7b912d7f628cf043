//! Replicas: processes that serve the same database. Leases and duties refer to them.

use model::ids::ReplicaId;
use sqlx::FromRow;

use crate::{Connection, Executor, Result};

/// Heartbeat counter of a replica.
#[derive(Clone, Copy, Debug, PartialEq, Eq, FromRow)]
pub struct ReplicaBeats {
    /// Id.
    pub id: ReplicaId,
    /// Number of heartbeats.
    pub beats: i64,
}

/// Registers a replica if it is missing: before its first lease, or after it was wrongly declared
/// dead.
pub async fn enrol_replica(writer: &mut Connection, id: ReplicaId) -> Result<()> {
    sqlx::query("INSERT INTO replicas (id) VALUES ($1) ON CONFLICT (id) DO NOTHING")
        .bind(id)
        .execute(writer)
        .await
        .map(drop)
}

/// Records a heartbeat.
pub async fn beat_replica(writer: &mut Connection, id: ReplicaId) -> Result<()> {
    sqlx::query(
        "INSERT INTO replicas (id, beats) VALUES ($1, 1) ON CONFLICT (id) DO UPDATE SET beats = replicas.beats + 1",
    )
    .bind(id)
    .execute(writer)
    .await
    .map(drop)
}

/// Returns all registered replicas.
pub async fn list_replicas(executor: impl Executor<'_>) -> Result<Vec<ReplicaBeats>> {
    sqlx::query_as("SELECT id, beats FROM replicas ORDER BY id").fetch_all(executor).await
}

/// Releases all leases and duties of a replica and removes it.
pub(crate) async fn remove_replica(writer: &mut Connection, id: ReplicaId) -> Result<()> {
    sqlx::query("DELETE FROM replicas WHERE id = $1").bind(id).execute(writer).await.map(drop)
}

/// Returns the replica that performs a duty, if there is one.
pub async fn find_duty_holder(executor: impl Executor<'_>, duty: &str) -> Result<Option<ReplicaId>> {
    sqlx::query_scalar("SELECT replica_id FROM duties WHERE name = $1").bind(duty).fetch_optional(executor).await
}

/// Assigns a duty to a replica, unless another one has it.
pub async fn take_duty(writer: &mut Connection, duty: &str, replica: ReplicaId) -> Result<()> {
    enrol_replica(&mut *writer, replica).await?;
    sqlx::query("INSERT INTO duties (name, replica_id) VALUES ($1, $2) ON CONFLICT (name) DO NOTHING")
        .bind(duty)
        .bind(replica)
        .execute(writer)
        .await
        .map(drop)
}
