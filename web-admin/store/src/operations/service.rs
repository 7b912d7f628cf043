//! Figures of the whole service, for its operators.

use model::Moment;
use sqlx::FromRow;

use crate::recordings::parse_attempts::MAX_CRASHES;
use crate::{Executor, Result};

/// Figures of all schools together.
#[derive(Clone, Debug, PartialEq, Eq, FromRow)]
pub struct Totals {
    /// Trainees with an enabled account.
    pub trainees: i64,
    /// Instructors with an enabled account.
    pub instructors: i64,
    /// Administrators with an enabled account.
    pub administrators: i64,
    /// Stations with a valid token.
    pub stations: i64,
    /// Incomplete uploads.
    pub uploads: i64,
    /// Attempts whose recording is waiting to be scored.
    pub pending: i64,
    /// Scored attempts.
    pub scored: i64,
    /// Attempts whose recording could not be scored.
    pub refused: i64,
    /// Jobs in the queue.
    pub waiting: i64,
    /// Jobs that failed at least once.
    pub failing: i64,
    /// Quarantined jobs, uploads and parse attempts.
    pub set_aside: i64,
    /// Time at which the first job is due, without quarantined ones.
    pub due_at: Option<Moment>,
    /// Rows in the audit log.
    pub audit_rows: i64,
    /// Size of the database, in bytes.
    pub database_bytes: i64,
}

/// Returns the figures of the service.
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
    .bind(MAX_CRASHES)
    .fetch_one(executor)
    .await
}

/// Returns the size of the database, in bytes.
pub async fn database_bytes(executor: impl Executor<'_>) -> Result<i64> {
    sqlx::query_scalar("SELECT (SELECT page_count FROM pragma_page_count) * (SELECT page_size FROM pragma_page_size)")
        .fetch_one(executor)
        .await
}
