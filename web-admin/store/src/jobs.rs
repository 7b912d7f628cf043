//! The durable queue. A job lives until the transaction that stores its outcome deletes it: a crash repeats it.

use model::ids::{SchoolId, SessionId};
use model::{Moment, SessionKey};
use sqlx::FromRow;

use super::tries::MOST_DEATHS;
use super::{Connection, Executor, Result};

/// A recording that waits to be scored.
#[derive(Clone, Debug, PartialEq, Eq, FromRow)]
pub struct Job {
    /// School.
    pub school_id: SchoolId,
    /// Session.
    pub session_id: SessionId,
    /// How often it was tried.
    pub attempts: u32,
    /// How many of those tries ended in a death.
    pub deaths: i64,
}

impl Job {
    /// The attempt to score.
    #[must_use]
    pub const fn session(&self) -> SessionKey {
        SessionKey { school_id: self.school_id, id: self.session_id }
    }
}

/// Puts an attempt into the queue; once is enough.
pub async fn enqueue_job(writer: &mut Connection, session: SessionKey, now: Moment) -> Result<()> {
    sqlx::query(
        "INSERT INTO jobs (school_id, session_id, kind, next_run_at) VALUES ($1, $2, 'score', $3)
         ON CONFLICT (school_id, session_id, kind) DO NOTHING",
    )
    .bind(session.school_id)
    .bind(session.id)
    .bind(now)
    .execute(writer)
    .await
    .map(drop)
}

/// Longest that a job is put off, in s. What is due later was queued by a clock that has been set back since, and is due now.
pub const LONGEST_WAIT_S: i64 = 320;

/// What of the queue is asked for: what is due at a moment, and has had so many deaths.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct JobQuery {
    /// The moment.
    pub now: Moment,
    /// Deaths of whoever worked on it.
    pub deaths: i64,
}

/// The schools for which something is due.
pub async fn list_waiting_schools(executor: impl Executor<'_>, due: JobQuery) -> Result<Vec<SchoolId>> {
    sqlx::query_scalar(
        "SELECT s.id FROM schools s WHERE EXISTS (SELECT 1 FROM jobs j
             WHERE j.school_id = s.id AND j.deaths = $1 AND (j.next_run_at <= $2 OR j.next_run_at > $3))",
    )
    .bind(due.deaths)
    .bind(due.now)
    .bind(due.now.plus_s(LONGEST_WAIT_S))
    .fetch_all(executor)
    .await
}

/// At most so many jobs of a school, those first that have been due for longest; none that was set aside.
pub async fn list_due_jobs(
    executor: impl Executor<'_>,
    school: SchoolId,
    due: JobQuery,
    most: i64,
) -> Result<Vec<Job>> {
    sqlx::query_as(
        "SELECT school_id, session_id, attempts, deaths FROM jobs
         WHERE school_id = $1 AND deaths = $2 AND deaths < $3 AND (next_run_at <= $4 OR next_run_at > $5)
         ORDER BY next_run_at, session_id LIMIT $6",
    )
    .bind(school)
    .bind(due.deaths)
    .bind(MOST_DEATHS)
    .bind(due.now)
    .bind(due.now.plus_s(LONGEST_WAIT_S))
    .bind(most)
    .fetch_all(executor)
    .await
}

/// When the next job will be due that is not yet, if any waits.
pub async fn find_next_job_time(executor: impl Executor<'_>, now: Moment) -> Result<Option<Moment>> {
    sqlx::query_scalar("SELECT min(next_run_at) FROM jobs WHERE next_run_at > $1 AND deaths < $2")
        .bind(now)
        .bind(MOST_DEATHS)
        .fetch_one(executor)
        .await
}

/// Puts a job back after a failure that may pass.
pub async fn put_off_job(writer: &mut Connection, session: SessionKey, until: Moment, why: &str) -> Result<()> {
    sqlx::query(
        "UPDATE jobs SET begun = FALSE, attempts = attempts + 1, next_run_at = $3, error = $4
         WHERE school_id = $1 AND session_id = $2",
    )
    .bind(session.school_id)
    .bind(session.id)
    .bind(until)
    .bind(why)
    .execute(writer)
    .await
    .map(drop)
}

/// Puts a job back that could not be tried: it is no failure of the job.
pub async fn postpone_job(writer: &mut Connection, session: SessionKey, until: Moment, why: &str) -> Result<()> {
    sqlx::query("UPDATE jobs SET begun = FALSE, next_run_at = $3, error = $4 WHERE school_id = $1 AND session_id = $2")
        .bind(session.school_id)
        .bind(session.id)
        .bind(until)
        .bind(why)
        .execute(writer)
        .await
        .map(drop)
}

/// Takes a job out of the queue.
pub async fn finish_job(writer: &mut Connection, session: SessionKey) -> Result<()> {
    sqlx::query("DELETE FROM jobs WHERE school_id = $1 AND session_id = $2")
        .bind(session.school_id)
        .bind(session.id)
        .execute(writer)
        .await
        .map(drop)
}

/// How many jobs wait.
pub async fn count_jobs(executor: impl Executor<'_>) -> Result<i64> {
    sqlx::query_scalar("SELECT count(*) FROM jobs").fetch_one(executor).await
}
