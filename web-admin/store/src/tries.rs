//! Tries at what may end the process that tries it. Each is written down before it begins; one that was begun and never ended is a
//! death, and what has died twice is set aside.

use model::ids::{SchoolId, UploadId};
use model::{Moment, SessionKey, new_id};
use sqlx::FromRow;
use uuid::Uuid;

use super::{Connection, Result};

/// Deaths after which something is tried no more.
pub const MOST_DEATHS: i64 = 2;

/// What the error of a job says whose try the service did not live to end.
const DIED: &str = "the service ended while it worked on this recording";

/// Notes that a job is begun.
pub async fn begin_job_try(writer: &mut Connection, session: SessionKey) -> Result<()> {
    sqlx::query("UPDATE jobs SET begun = TRUE WHERE school_id = $1 AND session_id = $2")
        .bind(session.school_id)
        .bind(session.id)
        .execute(writer)
        .await
        .map(drop)
}

/// Notes that whoever worked on a job has died of it.
pub async fn note_job_death(writer: &mut Connection, session: SessionKey, why: &str) -> Result<()> {
    sqlx::query(
        "UPDATE jobs SET begun = FALSE, deaths = deaths + 1, attempts = attempts + 1, error = $3
         WHERE school_id = $1 AND session_id = $2",
    )
    .bind(session.school_id)
    .bind(session.id)
    .bind(why)
    .execute(writer)
    .await
    .map(drop)
}

/// Notes that an upload is about to be read, or that whoever read it has lived on.
pub async fn mark_upload_begun(writer: &mut Connection, id: UploadId, begun: bool) -> Result<()> {
    sqlx::query("UPDATE uploads SET begun = $2 WHERE id = $1").bind(id).bind(begun).execute(writer).await.map(drop)
}

/// Notes that whoever read an upload has died of it.
pub async fn note_upload_death(writer: &mut Connection, id: UploadId) -> Result<()> {
    sqlx::query("UPDATE uploads SET begun = FALSE, deaths = deaths + 1 WHERE id = $1")
        .bind(id)
        .execute(writer)
        .await
        .map(drop)
}

/// Notes that bytes that came at once are about to be read; how often that was fatal before.
pub async fn begin_reading(writer: &mut Connection, school: SchoolId, sha256: &str, now: Moment) -> Result<i64> {
    sqlx::query_scalar(
        "INSERT INTO readings (id, school_id, sha256, begun, noted_at) VALUES ($1, $2, $3, 1, $4)
         ON CONFLICT (school_id, sha256) DO UPDATE SET begun = readings.begun + 1, noted_at = $4 RETURNING deaths",
    )
    .bind(new_id(now))
    .bind(school)
    .bind(sha256)
    .bind(now)
    .fetch_one(writer)
    .await
}

/// Notes that a reader has lived.
pub async fn end_reading_try(writer: &mut Connection, school: SchoolId, sha256: &str) -> Result<()> {
    sqlx::query("DELETE FROM readings WHERE school_id = $1 AND sha256 = $2 AND begun <= 1")
        .bind(school)
        .bind(sha256)
        .execute(&mut *writer)
        .await?;
    sqlx::query("UPDATE readings SET begun = begun - 1 WHERE school_id = $1 AND sha256 = $2")
        .bind(school)
        .bind(sha256)
        .execute(writer)
        .await
        .map(drop)
}

/// Notes that a reader has died.
pub async fn note_reading_death(writer: &mut Connection, school: SchoolId, sha256: &str) -> Result<()> {
    sqlx::query(
        "UPDATE readings SET begun = max(begun - 1, 0), deaths = deaths + 1 WHERE school_id = $1 AND sha256 = $2",
    )
    .bind(school)
    .bind(sha256)
    .execute(writer)
    .await
    .map(drop)
}

/// Forgets deaths at reading that were noted before a moment.
pub async fn forget_readings(writer: &mut Connection, before: Moment) -> Result<()> {
    sqlx::query("DELETE FROM readings WHERE noted_at < $1 AND begun = 0").bind(before).execute(writer).await.map(drop)
}

/// What was set aside.
#[derive(Clone, Debug, PartialEq, Eq, FromRow)]
pub struct SetAside {
    /// `recording`, `upload`, or `reading` of what came at once.
    pub kind: String,
    /// Id of the session, of the upload, or of the reading.
    pub id: Uuid,
}

/// Counts what was begun and never ended as deaths: at the start, before anything is begun. All that is set aside.
pub async fn count_deaths(writer: &mut Connection) -> Result<Vec<SetAside>> {
    sqlx::query(
        "UPDATE jobs SET begun = FALSE, deaths = deaths + 1, attempts = attempts + 1, error = $1 WHERE begun = 1",
    )
    .bind(DIED)
    .execute(&mut *writer)
    .await?;
    sqlx::query("UPDATE uploads SET begun = FALSE, deaths = deaths + 1 WHERE begun = 1").execute(&mut *writer).await?;
    sqlx::query("UPDATE readings SET begun = 0, deaths = deaths + 1 WHERE begun > 0").execute(&mut *writer).await?;
    sqlx::query_as(
        "SELECT 'recording' AS kind, session_id AS id FROM jobs WHERE deaths >= $1
         UNION ALL SELECT 'upload', id FROM uploads WHERE deaths >= $1
         UNION ALL SELECT 'reading', id FROM readings WHERE deaths >= $1",
    )
    .bind(MOST_DEATHS)
    .fetch_all(writer)
    .await
}

/// Takes back what was begun: the service stops because it was asked to.
pub async fn take_back_tries(writer: &mut Connection) -> Result<()> {
    sqlx::query("UPDATE jobs SET begun = FALSE WHERE begun = 1").execute(&mut *writer).await?;
    sqlx::query("DELETE FROM readings WHERE begun > 0 AND deaths = 0").execute(&mut *writer).await?;
    sqlx::query("UPDATE readings SET begun = 0 WHERE begun > 0").execute(&mut *writer).await?;
    sqlx::query("UPDATE uploads SET begun = FALSE WHERE begun = 1").execute(writer).await.map(drop)
}

/// Forgets every death, so that what was set aside is tried again; uploads are kept until a moment. How many recordings and uploads
/// that are.
pub async fn forgive_deaths(writer: &mut Connection, until: Moment) -> Result<u64> {
    let jobs = sqlx::query("UPDATE jobs SET deaths = 0, attempts = 0, next_run_at = 0 WHERE deaths >= $1");
    let jobs = jobs.bind(MOST_DEATHS).execute(&mut *writer).await?.rows_affected();
    let uploads = sqlx::query("UPDATE uploads SET deaths = 0, expires_at = $2 WHERE deaths >= $1");
    let readings = sqlx::query("DELETE FROM readings WHERE deaths >= $1");
    let readings = readings.bind(MOST_DEATHS).execute(&mut *writer).await?.rows_affected();
    Ok(jobs + readings + uploads.bind(MOST_DEATHS).bind(until).execute(writer).await?.rows_affected())
}
