//! Tries at what may end the process that tries it. Each is written down before it begins; one that was begun and never ended is a
//! death, and what has died twice is set aside.

use sqlx::{FromRow, SqliteConnection};
use uuid::Uuid;

use super::Result;
use super::scores::SessionKey;
use crate::domain::Moment;

/// Deaths after which something is tried no more.
pub const MOST_DEATHS: i64 = 2;

/// What the error of a job says whose try the service did not live to end.
const DIED: &str = "the service ended while it worked on this recording";

/// Notes that a job is begun.
///
/// # Errors
/// When the database fails.
pub async fn begin_job(writer: &mut SqliteConnection, session: SessionKey) -> Result<()> {
    sqlx::query("UPDATE jobs SET begun = 1 WHERE school_id = $1 AND session_id = $2")
        .bind(session.school_id)
        .bind(session.id)
        .execute(writer)
        .await
        .map(drop)
}

/// Notes that whoever worked on a job has died of it.
///
/// # Errors
/// When the database fails.
pub async fn note_death(writer: &mut SqliteConnection, session: SessionKey, why: &str) -> Result<()> {
    sqlx::query(
        "UPDATE jobs SET begun = 0, deaths = deaths + 1, attempts = attempts + 1, error = $3
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
///
/// # Errors
/// When the database fails.
pub async fn mark_upload(writer: &mut SqliteConnection, id: Uuid, begun: bool) -> Result<()> {
    sqlx::query("UPDATE uploads SET begun = $2 WHERE id = $1").bind(id).bind(begun).execute(writer).await.map(drop)
}

/// What was set aside.
#[derive(Clone, Debug, PartialEq, Eq, FromRow)]
pub struct SetAside {
    /// `recording` or `upload`.
    pub kind: String,
    /// Id of the session, or of the upload.
    pub id: Uuid,
}

/// Counts what was begun and never ended as deaths: at the start, before anything is begun. All that is set aside.
///
/// # Errors
/// When the database fails.
pub async fn count_deaths(writer: &mut SqliteConnection) -> Result<Vec<SetAside>> {
    sqlx::query("UPDATE jobs SET begun = 0, deaths = deaths + 1, attempts = attempts + 1, error = $1 WHERE begun = 1")
        .bind(DIED)
        .execute(&mut *writer)
        .await?;
    sqlx::query("UPDATE uploads SET begun = 0, deaths = deaths + 1 WHERE begun = 1").execute(&mut *writer).await?;
    sqlx::query_as(
        "SELECT 'recording' AS kind, session_id AS id FROM jobs WHERE deaths >= $1
         UNION ALL SELECT 'upload', id FROM uploads WHERE deaths >= $1",
    )
    .bind(MOST_DEATHS)
    .fetch_all(writer)
    .await
}

/// Takes back what was begun: the service stops because it was asked to.
///
/// # Errors
/// When the database fails.
pub async fn take_back(writer: &mut SqliteConnection) -> Result<()> {
    sqlx::query("UPDATE jobs SET begun = 0 WHERE begun = 1").execute(&mut *writer).await?;
    sqlx::query("UPDATE uploads SET begun = 0 WHERE begun = 1").execute(writer).await.map(drop)
}

/// Forgets every death, so that what was set aside is tried again; uploads are kept until a moment. How many recordings and uploads
/// that are.
///
/// # Errors
/// When the database fails.
pub async fn forgive(writer: &mut SqliteConnection, until: Moment) -> Result<u64> {
    let jobs = sqlx::query("UPDATE jobs SET deaths = 0, attempts = 0, next_run_at = 0 WHERE deaths >= $1");
    let jobs = jobs.bind(MOST_DEATHS).execute(&mut *writer).await?.rows_affected();
    let uploads = sqlx::query("UPDATE uploads SET deaths = 0, expires_at = $2 WHERE deaths >= $1");
    Ok(jobs + uploads.bind(MOST_DEATHS).bind(until).execute(writer).await?.rows_affected())
}
