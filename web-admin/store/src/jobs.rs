//! The durable queue. A job lives until the transaction that stores its outcome deletes it: a crash repeats it.

use model::ids::{ReplicaId, SchoolId, SessionId};
use model::{Moment, SessionKey};
use sqlx::FromRow;

use super::tries::MOST_DEATHS;
use super::{Connection, Executor, Result, replicas};

/// A recording that waits to be scored.
#[derive(Clone, Debug, PartialEq, Eq, FromRow)]
pub struct Job {
    /// School.
    pub school_id: SchoolId,
    /// Session.
    pub session_id: SessionId,
    /// How often it was tried.
    #[sqlx(try_from = "i64")]
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

    /// This job in a replica's hands.
    #[must_use]
    pub const fn held_by(&self, replica: ReplicaId) -> JobHold {
        JobHold { session: self.session(), replica }
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

/// The schools for which something is due that nobody holds.
pub async fn list_waiting_schools(executor: impl Executor<'_>, due: JobQuery) -> Result<Vec<SchoolId>> {
    sqlx::query_scalar(
        "SELECT s.id FROM schools s WHERE EXISTS (SELECT 1 FROM jobs j
             WHERE j.school_id = s.id AND j.deaths = $1 AND j.held_by IS NULL AND (j.next_run_at <= $2 OR j.next_run_at > $3))",
    )
    .bind(due.deaths)
    .bind(due.now)
    .bind(due.now.plus_s(LONGEST_WAIT_S))
    .fetch_all(executor)
    .await
}

/// Takes the job of a school that has been due for longest, of those that nobody holds; none that was set aside.
pub async fn claim_due_job(
    writer: &mut Connection,
    school: SchoolId,
    due: JobQuery,
    replica: ReplicaId,
) -> Result<Option<Job>> {
    replicas::enrol_replica(&mut *writer, replica).await?;
    sqlx::query_as(
        "UPDATE jobs SET held_by = $1 WHERE (school_id, session_id) IN (
             SELECT school_id, session_id FROM jobs
             WHERE school_id = $2 AND deaths = $3 AND deaths < $4 AND (next_run_at <= $5 OR next_run_at > $6) AND held_by IS NULL
             ORDER BY next_run_at, session_id LIMIT 1)
         RETURNING school_id, session_id, attempts, deaths",
    )
    .bind(replica)
    .bind(school)
    .bind(due.deaths)
    .bind(MOST_DEATHS)
    .bind(due.now)
    .bind(due.now.plus_s(LONGEST_WAIT_S))
    .fetch_optional(writer)
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

/// A job that a replica has taken. Whoever was taken for dead holds it no more, and what they come to counts for nothing.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct JobHold {
    /// The attempt to score.
    pub session: SessionKey,
    /// Who scores it.
    pub replica: ReplicaId,
}

/// Notes that a job is begun. False where it is held no more.
pub async fn begin_job_try(writer: &mut Connection, hold: JobHold) -> Result<bool> {
    let begun = sqlx::query("UPDATE jobs SET begun = TRUE WHERE school_id = $1 AND session_id = $2 AND held_by = $3")
        .bind(hold.session.school_id)
        .bind(hold.session.id)
        .bind(hold.replica)
        .execute(writer)
        .await?;
    Ok(begun.rows_affected() > 0)
}

/// Why a job goes back into the queue.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum JobReturn<'a> {
    /// It was not tried.
    Untried,
    /// It could not be tried, which is no failure of the job.
    Postponed {
        /// When it is due again.
        until: Moment,
        /// Why, in words.
        why: &'a str,
    },
    /// It failed, which may pass.
    Failed {
        /// As of `Postponed`.
        until: Moment,
        /// As of `Postponed`.
        why: &'a str,
    },
    /// Whoever worked on it has died of it; how.
    Died(&'a str),
}

/// Puts a job back. False where it is held no more, and nothing is done.
pub async fn return_job(writer: &mut Connection, hold: JobHold, how: JobReturn<'_>) -> Result<bool> {
    let (until, why) = match how {
        JobReturn::Untried => (None, None),
        JobReturn::Postponed { until, why } | JobReturn::Failed { until, why } => (Some(until), Some(why)),
        JobReturn::Died(why) => (None, Some(why)),
    };
    let failures = i64::from(matches!(how, JobReturn::Failed { .. } | JobReturn::Died(_)));
    let deaths = i64::from(matches!(how, JobReturn::Died(_)));
    let returned = sqlx::query(
        "UPDATE jobs SET held_by = NULL, begun = FALSE, attempts = attempts + $4, deaths = deaths + $5,
           next_run_at = coalesce($6, next_run_at), error = coalesce($7, error)
         WHERE school_id = $1 AND session_id = $2 AND held_by = $3",
    )
    .bind(hold.session.school_id)
    .bind(hold.session.id)
    .bind(hold.replica)
    .bind(failures)
    .bind(deaths)
    .bind(until)
    .bind(why)
    .execute(writer)
    .await?;
    Ok(returned.rows_affected() > 0)
}

/// Takes a job out of the queue, with what has come of it. False where it is held no more: then nothing may come of it.
pub async fn finish_job(writer: &mut Connection, hold: JobHold) -> Result<bool> {
    let finished = sqlx::query("DELETE FROM jobs WHERE school_id = $1 AND session_id = $2 AND held_by = $3")
        .bind(hold.session.school_id)
        .bind(hold.session.id)
        .bind(hold.replica)
        .execute(writer)
        .await?;
    Ok(finished.rows_affected() > 0)
}

/// How many jobs wait.
pub async fn count_jobs(executor: impl Executor<'_>) -> Result<i64> {
    sqlx::query_scalar("SELECT count(*) FROM jobs").fetch_one(executor).await
}
