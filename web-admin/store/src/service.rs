//! The service as a whole: for whoever keeps it running.

use model::Moment;
use sqlx::FromRow;

use super::tries::MOST_DEATHS;
use super::{Executor, Result};

/// Every school together.
#[derive(Clone, Debug, PartialEq, Eq, FromRow)]
pub struct Totals {
    /// People who may sign in, by role.
    pub trainees: i64,
    /// As `trainees`.
    pub instructors: i64,
    /// As `trainees`.
    pub administrators: i64,
    /// Stations whose token is valid.
    pub stations: i64,
    /// Uploads in pieces that are not whole yet.
    pub uploads: i64,
    /// Attempts whose recording waits to be scored.
    pub pending: i64,
    /// Scored attempts.
    pub scored: i64,
    /// Attempts whose recording could not be scored.
    pub refused: i64,
    /// Recordings in the queue.
    pub waiting: i64,
    /// Of them, those that failed at least once.
    pub failing: i64,
    /// Of them, those that are tried no more, and uploads that are read no more.
    pub set_aside: i64,
    /// When the first of the queue is due.
    pub due_at: Option<Moment>,
    /// Rows of the audit log.
    pub audit_rows: i64,
    /// The database, in bytes.
    pub database_bytes: i64,
}

/// Counts of everything.
pub async fn count_totals(executor: impl Executor<'_>) -> Result<Totals> {
    sqlx::query_as(
        "SELECT (SELECT count(*) FROM people WHERE role = 'trainee' AND disabled_at IS NULL) AS trainees,
           (SELECT count(*) FROM people WHERE role = 'instructor' AND disabled_at IS NULL) AS instructors,
           (SELECT count(*) FROM people WHERE role = 'administrator' AND disabled_at IS NULL) AS administrators,
           (SELECT count(*) FROM api_tokens WHERE station IS NOT NULL AND revoked_at IS NULL) AS stations,
           (SELECT count(*) FROM uploads WHERE session_id IS NULL) AS uploads,
           (SELECT count(*) FROM sessions WHERE state = 'pending') AS pending,
           (SELECT CAST(coalesce(sum(attempts), 0) AS BIGINT) FROM tallies WHERE cohort_id = zeroblob(16)) AS scored,
           (SELECT count(*) FROM sessions WHERE state = 'refused') AS refused,
           (SELECT count(*) FROM jobs) AS waiting,
           (SELECT count(*) FROM jobs WHERE attempts > 0) AS failing,
           (SELECT count(*) FROM jobs WHERE deaths >= $1) + (SELECT count(*) FROM uploads WHERE deaths >= $1)
             + (SELECT count(*) FROM readings WHERE deaths >= $1) AS set_aside,
           (SELECT min(next_run_at) FROM jobs WHERE deaths < $1) AS due_at,
           (SELECT coalesce(max(seq), 0) FROM audit_log) AS audit_rows,
           (SELECT page_count FROM pragma_page_count) * (SELECT page_size FROM pragma_page_size) AS database_bytes",
    )
    .bind(MOST_DEATHS)
    .fetch_one(executor)
    .await
}

/// The size of the database, in bytes.
pub async fn database_bytes(executor: impl Executor<'_>) -> Result<i64> {
    sqlx::query_scalar("SELECT (SELECT page_count FROM pragma_page_count) * (SELECT page_size FROM pragma_page_size)")
        .fetch_one(executor)
        .await
}
