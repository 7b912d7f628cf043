//! Overview of a school: exercises, counts, failing jobs.

use model::Moment;
use model::ids::{SchoolId, SessionId};
use sqlx::FromRow;

use crate::recordings::parse_attempts::MAX_CRASHES;
use crate::{Executor, Result};

/// Summary of the current revision of an exercise.
#[derive(Clone, Debug, PartialEq, FromRow)]
pub struct ExerciseInShort {
    /// Exercise id.
    pub exercise_id: String,
    /// Score needed to pass, 0–100.
    pub pass_mark: f64,
    /// Difficulty, 1–5.
    #[sqlx(try_from = "i64")]
    pub difficulty: u8,
}

/// Returns the current exercises of a school.
pub async fn exercises(executor: impl Executor<'_>, school: SchoolId) -> Result<Vec<ExerciseInShort>> {
    sqlx::query_as(
        "SELECT e.exercise_id, r.pass_mark, r.difficulty FROM exercises e
         JOIN exercise_revisions r ON r.id = e.revision_id WHERE e.school_id = $1",
    )
    .bind(school)
    .fetch_all(executor)
    .await
}

/// Counts of a school.
#[derive(Clone, Debug, PartialEq, Eq, FromRow)]
pub struct SchoolCounts {
    /// Name of the school.
    pub school: String,
    /// Trainees with an enabled account.
    pub trainees: i64,
    /// Instructors with an enabled account.
    pub instructors: i64,
    /// Administrators with an enabled account.
    pub administrators: i64,
    /// Scored attempts.
    pub attempts: i64,
    /// Trainees' attempts started since the given time.
    pub recent: i64,
    /// Recordings in the queue.
    pub waiting: i64,
    /// Recordings that could not be scored.
    pub refused: i64,
    /// Recordings whose re-simulation differs.
    pub flagged: i64,
}

/// Returns the counts of a school; `since` applies to the recent attempts.
pub async fn counts(executor: impl Executor<'_>, school: SchoolId, since: Moment) -> Result<SchoolCounts> {
    sqlx::query_as(
        "SELECT s.name AS school,
           (SELECT count(*) FROM people p WHERE p.school_id = s.id AND p.role = 'trainee' AND p.disabled_at IS NULL)
             AS trainees,
           (SELECT count(*) FROM people p WHERE p.school_id = s.id AND p.role = 'instructor' AND p.disabled_at IS NULL)
             AS instructors,
           (SELECT count(*) FROM people p
             WHERE p.school_id = s.id AND p.role = 'administrator' AND p.disabled_at IS NULL) AS administrators,
           (SELECT CAST(coalesce(sum(t.attempts), 0) AS BIGINT) FROM tallies t
             WHERE t.school_id = s.id AND t.cohort_id = zeroblob(16)) AS attempts,
           (SELECT count(*) FROM sessions a CROSS JOIN people p
             WHERE p.school_id = a.school_id AND p.id = a.trainee_id AND a.school_id = s.id AND a.started_at >= $2
             AND p.role = 'trainee') AS recent,
           (SELECT count(*) FROM jobs j WHERE j.school_id = s.id) AS waiting,
           (SELECT count(*) FROM sessions a WHERE a.school_id = s.id AND a.state = 'refused') AS refused,
           (SELECT count(*) FROM sessions a WHERE a.school_id = s.id AND a.verify_flagged = 1) AS flagged
         FROM schools s WHERE s.id = $1",
    )
    .bind(school)
    .bind(since)
    .fetch_one(executor)
    .await
}

/// A job that failed and is not finished.
#[derive(Clone, Debug, PartialEq, Eq, FromRow)]
pub struct FailingJob {
    /// Session.
    pub session_id: SessionId,
    /// Number of failures, crashes included.
    pub attempts: i64,
    /// Last error.
    pub error: String,
}

/// Returns the jobs of a school that failed at least once; at most 50.
pub async fn failing_jobs(executor: impl Executor<'_>, school: SchoolId) -> Result<Vec<FailingJob>> {
    sqlx::query_as(
        "SELECT session_id, attempts,
                concat_ws('; ', error, iif(deaths >= $2, 'set aside: web-admin retry tries it again', NULL)) AS error
         FROM jobs WHERE school_id = $1 AND attempts > 0 ORDER BY deaths DESC, next_run_at, session_id LIMIT 50",
    )
    .bind(school)
    .bind(MAX_CRASHES)
    .fetch_all(executor)
    .await
}
