//! The durable queue of scoring jobs. The transaction that stores a job's result also deletes the
//! job, so that a job is repeated after a crash.

use model::ids::{ReplicaId, SchoolId, SessionId};
use model::{Moment, SessionKey};
use sqlx::FromRow;

use crate::recordings::parse_attempts::MAX_CRASHES;
use crate::{Connection, Executor, Result, replicas};

/// A recording to be scored.
#[derive(Clone, Debug, PartialEq, Eq, FromRow)]
pub struct Job {
    /// School.
    pub school_id: SchoolId,
    /// Attempt to be scored.
    pub session_id: SessionId,
    /// Number of failures, crashes included.
    #[sqlx(try_from = "i64")]
    pub attempts: u32,
    /// Number of crashes while the job was processed.
    pub deaths: i64,
}

impl Job {
    /// Returns the key of the attempt to be scored.
    #[must_use]
    pub const fn session(&self) -> SessionKey {
        SessionKey { school_id: self.school_id, id: self.session_id }
    }

    /// Returns the lease of this job by a replica.
    #[must_use]
    pub const fn held_by(&self, replica: ReplicaId) -> JobHold {
        JobHold { session: self.session(), replica }
    }
}

/// Adds an attempt to the queue, unless it is already there.
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

/// Longest delay of a retry, in s. A job that is due later than this was queued before the clock
/// was set back, and is treated as due now.
pub const LONGEST_WAIT_S: i64 = 320;

/// Selects jobs due at `now` with exactly `deaths` crashes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct JobQuery {
    /// Current time.
    pub now: Moment,
    /// Number of crashes while the job was processed.
    pub deaths: i64,
}

/// Returns the schools that have due jobs without a lease.
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

/// Leases the job of a school that has been due for longest. Quarantined jobs are left out.
pub async fn claim_due_job(
    writer: &mut Connection,
    school: SchoolId,
    due: JobQuery,
    replica: ReplicaId,
) -> Result<Option<Job>> {
    replicas::enrol_replica(&mut *writer, replica).await?;
    // `deaths < $4` leaves out quarantined jobs; `next_run_at > $6` selects jobs queued before the
    // clock was set back.
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
    .bind(MAX_CRASHES)
    .bind(due.now)
    .bind(due.now.plus_s(LONGEST_WAIT_S))
    .fetch_optional(writer)
    .await
}

/// Returns the time at which the next job becomes due, not counting jobs that are already due.
pub async fn find_next_job_time(executor: impl Executor<'_>, now: Moment) -> Result<Option<Moment>> {
    sqlx::query_scalar("SELECT min(next_run_at) FROM jobs WHERE next_run_at > $1 AND deaths < $2")
        .bind(now)
        .bind(MAX_CRASHES)
        .fetch_one(executor)
        .await
}

/// A replica's lease of a job. A replica that was declared dead has lost its leases and cannot
/// store a result.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct JobHold {
    /// Attempt to be scored.
    pub session: SessionKey,
    /// Replica that holds the lease.
    pub replica: ReplicaId,
}

/// Marks a job as started. Returns false if the lease was lost.
pub async fn begin_job_try(writer: &mut Connection, hold: JobHold) -> Result<bool> {
    let begun = sqlx::query("UPDATE jobs SET begun = TRUE WHERE school_id = $1 AND session_id = $2 AND held_by = $3")
        .bind(hold.session.school_id)
        .bind(hold.session.id)
        .bind(hold.replica)
        .execute(writer)
        .await?;
    Ok(begun.rows_affected() > 0)
}

/// Reason for releasing a job.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum JobReturn<'a> {
    /// The job was not started.
    Untried,
    /// The job could not be started, for a reason that does not count as its failure.
    Postponed {
        /// Time of the next attempt.
        until: Moment,
        /// Reason, as text.
        why: &'a str,
    },
    /// The job failed and is to be retried.
    Failed {
        /// Time of the retry.
        until: Moment,
        /// Reason, as text.
        why: &'a str,
    },
    /// The job crashed its worker, with a description of the crash.
    Died(&'a str),
}

/// Releases a job. Returns false without any change if the lease was lost.
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

/// Deletes a job, in the transaction that stores its result. Returns false if the lease was lost:
/// the result must then be discarded.
pub async fn finish_job(writer: &mut Connection, hold: JobHold) -> Result<bool> {
    let finished = sqlx::query("DELETE FROM jobs WHERE school_id = $1 AND session_id = $2 AND held_by = $3")
        .bind(hold.session.school_id)
        .bind(hold.session.id)
        .bind(hold.replica)
        .execute(writer)
        .await?;
    Ok(finished.rows_affected() > 0)
}

/// Returns the number of jobs in the queue.
pub async fn count_jobs(executor: impl Executor<'_>) -> Result<i64> {
    sqlx::query_scalar("SELECT count(*) FROM jobs").fetch_one(executor).await
}
