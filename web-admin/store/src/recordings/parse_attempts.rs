//! Crash accounting and quarantine for recordings, which may crash the process that parses or
//! scores them. Each attempt is recorded before it starts; one that never ended counts as a crash.
//! After two crashes the recording is quarantined.

use model::ids::{ReaderId, ReplicaId, SchoolId, UploadId};
use model::{Moment, new_id};
use sqlx::FromRow;
use uuid::Uuid;

use crate::replicas::ReplicaBeats;
use crate::{Connection, Executor, Result, replicas};

/// Number of crashes after which a recording is quarantined.
pub const MAX_CRASHES: i64 = 2;

/// Error of a job whose service ended during the attempt.
const DIED: &str = "the service stopped while processing this recording";

/// Leases an upload for parsing it. Returns false if another replica has the lease.
pub async fn hold_upload(writer: &mut Connection, id: UploadId, replica: ReplicaId) -> Result<bool> {
    replicas::enrol_replica(&mut *writer, replica).await?;
    let held = sqlx::query("UPDATE uploads SET held_by = $2 WHERE id = $1 AND held_by IS NULL");
    Ok(held.bind(id).bind(replica).execute(writer).await?.rows_affected() > 0)
}

/// Releases an upload; `died` counts a crash.
pub async fn release_upload(writer: &mut Connection, id: UploadId, replica: ReplicaId, died: bool) -> Result<()> {
    sqlx::query("UPDATE uploads SET held_by = NULL, deaths = deaths + $3 WHERE id = $1 AND held_by = $2")
        .bind(id)
        .bind(replica)
        .bind(i64::from(died))
        .execute(writer)
        .await
        .map(drop)
}

/// An attempt to parse a recording uploaded in one request.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ParseAttempt {
    /// Id of the attempt.
    pub reader: ReaderId,
    /// Number of earlier crashes with the same bytes.
    pub deaths: i64,
}

/// Records the start of parsing a recording uploaded in one request.
pub async fn begin_reading(
    writer: &mut Connection,
    school: SchoolId,
    sha256: &str,
    replica: ReplicaId,
    now: Moment,
) -> Result<ParseAttempt> {
    replicas::enrol_replica(&mut *writer, replica).await?;
    let (reading, deaths): (Uuid, i64) = sqlx::query_as(
        "INSERT INTO readings (id, school_id, sha256, noted_at) VALUES ($1, $2, $3, $4)
         ON CONFLICT (school_id, sha256) DO UPDATE SET noted_at = $4 RETURNING id, deaths",
    )
    .bind(new_id(now))
    .bind(school)
    .bind(sha256)
    .bind(now)
    .fetch_one(&mut *writer)
    .await?;
    let reader = ReaderId::made_at(now);
    sqlx::query("INSERT INTO readers (id, reading_id, replica_id) VALUES ($1, $2, $3)")
        .bind(reader)
        .bind(reading)
        .bind(replica)
        .execute(writer)
        .await?;
    Ok(ParseAttempt { reader, deaths })
}

/// Records the end of parsing; `died` counts a crash.
pub async fn end_reading(writer: &mut Connection, reader: ReaderId, died: bool) -> Result<()> {
    sqlx::query("UPDATE readings SET deaths = deaths + $2 WHERE id = (SELECT reading_id FROM readers WHERE id = $1)")
        .bind(reader)
        .bind(i64::from(died))
        .execute(&mut *writer)
        .await?;
    let reading: Option<Uuid> = sqlx::query_scalar("DELETE FROM readers WHERE id = $1 RETURNING reading_id")
        .bind(reader)
        .fetch_optional(&mut *writer)
        .await?;
    sqlx::query(
        "DELETE FROM readings WHERE id = $1 AND deaths = 0 AND NOT EXISTS (SELECT 1 FROM readers r WHERE r.reading_id = $1)",
    )
    .bind(reading)
    .execute(writer)
    .await
    .map(drop)
}

/// Deletes recorded parse attempts from before a given time that are not in progress.
pub async fn forget_readings(writer: &mut Connection, before: Moment) -> Result<()> {
    sqlx::query(
        "DELETE FROM readings WHERE noted_at < $1 AND NOT EXISTS (SELECT 1 FROM readers r WHERE r.reading_id = readings.id)",
    )
    .bind(before)
    .execute(writer)
    .await
    .map(drop)
}

/// A quarantined recording.
#[derive(Clone, Debug, PartialEq, Eq, FromRow)]
pub struct QuarantinedItem {
    /// `recording` (a job), `upload`, or `reading` (a recording uploaded in one request).
    pub kind: String,
    /// Id of the session, the upload or the reading.
    pub id: Uuid,
}

/// Releases the leases of a dead replica that parsed recordings in its own process, and counts each
/// unfinished one as a crash. For replicas with sandboxed helpers, use [`release_replica`].
pub async fn bury_replica(writer: &mut Connection, id: ReplicaId) -> Result<()> {
    sqlx::query(
        "UPDATE jobs SET begun = FALSE, deaths = deaths + 1, attempts = attempts + 1, error = $2
         WHERE held_by = $1 AND begun = TRUE",
    )
    .bind(id)
    .bind(DIED)
    .execute(&mut *writer)
    .await?;
    sqlx::query("UPDATE uploads SET deaths = deaths + 1 WHERE held_by = $1").bind(id).execute(&mut *writer).await?;
    sqlx::query(
        "UPDATE readings SET deaths = deaths + 1 WHERE id IN (SELECT reading_id FROM readers WHERE replica_id = $1)",
    )
    .bind(id)
    .execute(&mut *writer)
    .await?;
    replicas::remove_replica(writer, id).await
}

/// Releases the leases of a replica without counting crashes: it stops on request, or it died while
/// sandboxed helpers were parsing.
pub async fn release_replica(writer: &mut Connection, id: ReplicaId) -> Result<()> {
    sqlx::query("UPDATE jobs SET begun = FALSE WHERE held_by = $1").bind(id).execute(&mut *writer).await?;
    sqlx::query(
        "DELETE FROM readings WHERE deaths = 0 AND id IN (SELECT reading_id FROM readers WHERE replica_id = $1)
         AND NOT EXISTS (SELECT 1 FROM readers r WHERE r.reading_id = readings.id AND r.replica_id <> $1)",
    )
    .bind(id)
    .execute(&mut *writer)
    .await?;
    replicas::remove_replica(writer, id).await
}

/// Releases all leases, in a copy of a database that no process uses.
pub async fn release_all(writer: &mut Connection) -> Result<()> {
    for ReplicaBeats { id, .. } in replicas::list_replicas(&mut *writer).await? {
        release_replica(writer, id).await?;
    }
    Ok(())
}

/// Returns everything in quarantine.
pub async fn list_quarantined(executor: impl Executor<'_>) -> Result<Vec<QuarantinedItem>> {
    sqlx::query_as(
        "SELECT 'recording' AS kind, session_id AS id FROM jobs WHERE deaths >= $1
         UNION ALL SELECT 'upload', id FROM uploads WHERE deaths >= $1
         UNION ALL SELECT 'reading', id FROM readings WHERE deaths >= $1",
    )
    .bind(MAX_CRASHES)
    .fetch_all(executor)
    .await
}

/// Resets the crash counts of everything in quarantine, so that it is tried again; uploads are kept
/// until `until`. Returns the number of released entries.
pub async fn forgive_deaths(writer: &mut Connection, until: Moment) -> Result<u64> {
    let jobs = sqlx::query("UPDATE jobs SET deaths = 0, attempts = 0, next_run_at = 0 WHERE deaths >= $1");
    let jobs = jobs.bind(MAX_CRASHES).execute(&mut *writer).await?.rows_affected();
    let uploads = sqlx::query("UPDATE uploads SET deaths = 0, expires_at = $2 WHERE deaths >= $1");
    let readings = sqlx::query("DELETE FROM readings WHERE deaths >= $1");
    let readings = readings.bind(MAX_CRASHES).execute(&mut *writer).await?.rows_affected();
    Ok(jobs + readings + uploads.bind(MAX_CRASHES).bind(until).execute(writer).await?.rows_affected())
}
