//! Scores recordings and stores the results.

pub mod exam_files;
pub mod exams;
pub mod ratings;
pub mod regrading;
pub mod reviewing;
pub mod segments;

use std::panic::AssertUnwindSafe;
use std::time::Duration;

use anyhow::Context;
use futures::FutureExt;
use model::ids::SchoolId;
use platform::fail_points::FailPoint;
use platform::recording_store::StoreError;
use serde_json::json;
use store::audit::{Actor, AuditEntry};
use store::authoring::exercises;
use store::authoring::exercises::RevisionBytes;
use store::recordings::sessions::Session;
use store::recordings::{parse_attempts, sessions};
use store::scoring::jobs::{Job, JobQuery, JobReturn};
use store::scoring::{jobs, scores};
use store::training::practice;
use tracing::Instrument;

use crate::error::{error_chain, is_database_unavailable};
use crate::recordings::replays;
use crate::sandbox_jobs::{JudgingOutcome, JudgingTask, SandboxRequest, SandboxResponse};
use crate::service::Service;
use crate::training::learning_records::queueing::{GradeSource, queue_statements};
use crate::{SPANS, sandbox};

/// Maximum number of attempts before a recording is rejected, even if the error is transient.
const MAX_ATTEMPTS: u32 = 6;
/// Time limit of the first attempt. A slower recording gets its full time in a later attempt, when
/// no other is waiting.
const FIRST_TRY: Duration = Duration::from_secs(30);
/// Delay after the first failure, in s; it doubles with each further one.
const FIRST_WAIT_S: i64 = 10;
/// Delay while the recording store is unavailable, in s.
const STORE_WAIT_S: i64 = 30;
/// Recorded crash reason if the service itself panicked.
const PANICKED: &str = "the service panicked while scoring this recording";

/// Why a recording was not scored.
#[derive(Debug)]
enum ScoringFailure {
    /// Permanent error: a retry cannot succeed.
    Permanent(String),
    /// Transient error: a retry may succeed.
    Passing(anyhow::Error),
    /// The recording or the database is unavailable, which is not the recording's fault.
    Unreachable(anyhow::Error),
    /// The scoring process crashed; contains how it ended.
    Death(String),
    /// The lease was lost: another replica is scoring the recording.
    Lost,
}

impl From<anyhow::Error> for ScoringFailure {
    fn from(error: anyhow::Error) -> Self {
        if is_database_unavailable(&error) { Self::Unreachable(error) } else { Self::Passing(error) }
    }
}

impl From<store::Error> for ScoringFailure {
    fn from(error: store::Error) -> Self {
        anyhow::Error::from(error).into()
    }
}

impl From<StoreError> for ScoringFailure {
    fn from(error: StoreError) -> Self {
        match error {
            StoreError::Away(cause) => Self::Unreachable(cause),
            error => Self::Passing(error.into()),
        }
    }
}

/// Claims the job of a school that has been due longest, if there is an unclaimed one.
///
/// # Errors
/// Fails if the database fails.
pub async fn claim(state: &Service, school: SchoolId, due: JobQuery) -> anyhow::Result<Option<Job>> {
    let mut tx = state.db.write_relaxed().await?;
    let job = jobs::claim_due_job(&mut tx, school, due, state.replica).await?;
    tx.commit().await?;
    Ok(job)
}

/// Scores a recording and stores its score, or the reason for the failure.
pub async fn score_recording(state: &Service, job: &Job) -> anyhow::Result<()> {
    let span = tracing::info_span!(target: SPANS, "score a recording", session = %job.session_id, deaths = job.deaths);
    match AssertUnwindSafe(try_scoring(state, job)).catch_unwind().instrument(span).await {
        Ok(done) => done,
        Err(_panic) => record_crash(state, job, PANICKED).await,
    }
}

async fn try_scoring(state: &Service, job: &Job) -> anyhow::Result<()> {
    match outcome(state, job).await {
        Ok(outcome) => keep_score(state, job, outcome).await,
        Err(ScoringFailure::Permanent(why)) => refuse(state, job, &why).await,
        Err(ScoringFailure::Passing(error)) => retry_later(state, job, &error).await,
        Err(ScoringFailure::Unreachable(error)) => wait_for_store(state, job, &error).await,
        Err(ScoringFailure::Death(how)) => record_crash(state, job, &how).await,
        Err(ScoringFailure::Lost) => {
            log_lost_lease(job);
            Ok(())
        }
    }
}

async fn outcome(state: &Service, job: &Job) -> Result<JudgingOutcome, ScoringFailure> {
    let session = sessions::find_session(state.db.reader(), job.school_id, job.session_id).await?;
    let session = session.context("the queue contains a session that does not exist")?;
    let task = JudgingTask::Judge(published(state, &session).await?);
    // Before the job is marked as started: a crash while fetching is not the recording's fault.
    let recording = state.recordings.fetch(&session.recording_path).await?;
    begin(state, job).await?;
    FailPoint::JobBegun.hit();
    let question = SandboxRequest::Recording(replays::brief(state, &session, &recording, task));
    let most = if job.deaths == 0 { FIRST_TRY } else { Duration::MAX };
    match sandbox::call_within(state, question, most).await? {
        SandboxResponse::Judged(outcome) => {
            keep_replay(state, &session).await;
            Ok(*outcome)
        }
        SandboxResponse::Permanent(why) => Err(ScoringFailure::Permanent(why)),
        SandboxResponse::Died(how) => Err(ScoringFailure::Death(how)),
        SandboxResponse::Passing(why) => Err(ScoringFailure::Passing(anyhow::anyhow!(why))),
        other => Err(ScoringFailure::Passing(anyhow::anyhow!("unexpected answer to a scoring request: {other:?}"))),
    }
}

/// Stores the replay. A failure is only logged and does not prevent scoring: the replay is rebuilt
/// on demand.
async fn keep_replay(state: &Service, session: &Session) {
    if let Err(error) = replays::keep(state, session).await {
        tracing::warn!(session = %session.id, cause = error_chain(&error), "replay not stored");
    }
}

/// Marks the job as started, so that a crash counts against it.
async fn begin(state: &Service, job: &Job) -> Result<(), ScoringFailure> {
    let mut tx = state.db.write_relaxed().await?;
    if !jobs::begin_job_try(&mut tx, job.held_by(state.replica)).await? {
        return Err(ScoringFailure::Lost);
    }
    Ok(tx.commit().await?)
}

/// Returns the exercise as this school published it.
async fn published(state: &Service, session: &Session) -> anyhow::Result<Option<RevisionBytes>> {
    let Some(revision) = session.revision_id else { return Ok(None) };
    Ok(exercises::read_exercise_bytes(state.db.reader(), session.school_id, revision).await?)
}

async fn keep_score(state: &Service, job: &Job, outcome: JudgingOutcome) -> anyhow::Result<()> {
    FailPoint::JobJudged.hit();
    let now = state.clock.now();
    let key = job.session();
    let mut tx = state.db.write().await?;
    if !jobs::finish_job(&mut tx, job.held_by(state.replica)).await? {
        log_lost_lease(job);
        return Ok(());
    }
    let score = scores::add_score(&mut tx, key, &outcome.assessment, now).await?;
    FailPoint::ScoreAdded.hit();
    scores::put_curve(&mut tx, key, &outcome.curve).await?;
    sessions::mark_scored(&mut tx, job.school_id, job.session_id, outcome.verified).await?;
    practice::refresh_practice(&mut tx, key).await?;
    queue_statements(state, &mut tx, key, GradeSource::Score(score), now).await?;
    let details = json!({
        "score": outcome.assessment.score,
        "rubric_sha256": outcome.assessment.rubric.sha256,
        "flagged": outcome.verified.flagged(),
    });
    entry(job, "session.scored").with(details).append(&mut tx, now).await?;
    FailPoint::ScoreCommitting.hit();
    tx.commit().await?;
    FailPoint::ScoreCommitted.hit();
    tracing::info!(session = %job.session_id, flagged = outcome.verified.flagged(), "recording scored");
    Ok(())
}

async fn refuse(state: &Service, job: &Job, why: &str) -> anyhow::Result<()> {
    let mut tx = state.db.write().await?;
    if !jobs::finish_job(&mut tx, job.held_by(state.replica)).await? {
        log_lost_lease(job);
        return Ok(());
    }
    sessions::mark_refused(&mut tx, job.school_id, job.session_id, why).await?;
    entry(job, "session.refused").with(json!({ "why": why })).append(&mut tx, state.clock.now()).await?;
    tx.commit().await?;
    tracing::warn!(session = %job.session_id, why, "recording refused");
    Ok(())
}

async fn retry_later(state: &Service, job: &Job, error: &anyhow::Error) -> anyhow::Result<()> {
    let why = format!("{error:#}");
    if job.attempts + 1 >= MAX_ATTEMPTS {
        return refuse(state, job, &format!("gave up after {MAX_ATTEMPTS} tries; last error: {why}")).await;
    }
    let until = state.clock.now().plus_s(FIRST_WAIT_S << job.attempts);
    requeue(state, job, JobReturn::Failed { until, why: &why }).await?;
    tracing::warn!(session = %job.session_id, attempts = job.attempts + 1, why, "scoring failed; will retry");
    Ok(())
}

/// Requeues a job until the unavailable resource may be back; does not count as an attempt.
async fn wait_for_store(state: &Service, job: &Job, error: &anyhow::Error) -> anyhow::Result<()> {
    let why = format!("{error:#}");
    let until = state.clock.now().plus_s(STORE_WAIT_S);
    requeue(state, job, JobReturn::Postponed { until, why: &why }).await?;
    tracing::warn!(session = %job.session_id, why, "scoring postponed: dependency unavailable");
    Ok(())
}

/// Requeues a job.
///
/// # Errors
/// Fails if the database fails.
pub async fn requeue(state: &Service, job: &Job, how: JobReturn<'_>) -> anyhow::Result<()> {
    let mut tx = state.db.write().await?;
    if !jobs::return_job(&mut tx, job.held_by(state.replica), how).await? {
        log_lost_lease(job);
    }
    Ok(tx.commit().await?)
}

/// Logs that the lease was lost and the result discarded.
fn log_lost_lease(job: &Job) {
    tracing::warn!(session = %job.session_id, "lost the lease: another replica is scoring this recording");
}

/// Records a crash: the job is requeued behind those without crashes, or quarantined after the
/// second crash.
async fn record_crash(state: &Service, job: &Job, how: &str) -> anyhow::Result<()> {
    let mut tx = state.db.write().await?;
    if !jobs::return_job(&mut tx, job.held_by(state.replica), JobReturn::Died(how)).await? {
        log_lost_lease(job);
        return Ok(());
    }
    let is_last = job.deaths + 1 >= parse_attempts::MAX_CRASHES;
    if is_last {
        entry(job, "session.set_aside").with(json!({ "why": how })).append(&mut tx, state.clock.now()).await?;
    }
    tx.commit().await?;
    tracing::error!(session = %job.session_id, how, set_aside = is_last, "scorer crashed on a recording");
    Ok(())
}

fn entry<'a>(job: &Job, action: &'a str) -> AuditEntry<'a> {
    AuditEntry::new(job.school_id, Actor::Worker, action, job.session_id)
}
