//! Scores what was uploaded, from the durable queue: one recording at a time, and again after a crash; what is fatal twice is set aside.

use std::time::Duration;

use anyhow::Context;
use serde_json::json;

use crate::AppState;
use crate::judging::{self, Answer, Outcome, Task};
use crate::regrading;
use crate::replays;
use crate::storage::audit::{Actor, Entry};
use crate::storage::exercises::RevisionBytes;
use crate::storage::jobs::{self, Job};
use crate::storage::sessions::{self, Session};
use crate::storage::{exercises, practice, scores, tries};

/// Tries before a recording is refused whatever the reason.
const MAX_ATTEMPTS: u32 = 6;
/// Wait after the first failure, in s; it doubles with each.
const FIRST_WAIT_S: i64 = 10;
/// Longest sleep between two looks at the queue: the clock may be set.
const LONGEST_SLEEP: Duration = Duration::from_secs(60);

/// Why a recording was not scored.
#[derive(Debug)]
enum Failure {
    /// It never will be.
    Permanent(String),
    /// It may be, later.
    Passing(anyhow::Error),
    /// Whoever worked on it has died of it; how.
    Death(String),
}

impl<E: Into<anyhow::Error>> From<E> for Failure {
    fn from(error: E) -> Self {
        Self::Passing(error.into())
    }
}

/// Works until it is dropped. That may happen at any time: what is not stored yet is done again.
pub async fn run(state: AppState) {
    loop {
        let pause = match work_off(&state).await {
            Ok(()) => until_next(&state).await,
            Err(error) => {
                tracing::error!(cause = format!("{error:#}"), "the queue cannot be worked off");
                LONGEST_SLEEP
            }
        };
        // Timing out only means that nobody rang.
        let _ = tokio::time::timeout(pause, state.jobs.notified()).await;
    }
}

/// How long until a job is due.
async fn until_next(state: &AppState) -> Duration {
    let Ok(Some(next)) = jobs::next_at(state.db.reader()).await else { return LONGEST_SLEEP };
    let wait_us = next.micros().saturating_sub(state.clock.now().micros());
    Duration::from_micros(u64::try_from(wait_us).unwrap_or(0)).min(LONGEST_SLEEP)
}

/// Does every job that is due, and then what is graded again, piece by piece: whoever has just tried waits for no one else.
///
/// # Errors
/// When the database fails.
pub async fn work_off(state: &AppState) -> anyhow::Result<()> {
    loop {
        while let Some(job) = jobs::due(state.db.reader(), state.clock.now()).await? {
            match outcome(state, &job).await {
                Ok(outcome) => store(state, &job, outcome).await?,
                Err(Failure::Permanent(why)) => refuse(state, &job, &why).await?,
                Err(Failure::Passing(error)) => put_off(state, &job, &error).await?,
                Err(Failure::Death(how)) => bury(state, &job, &how).await?,
            }
        }
        if !regrading::exercise::step(state).await? {
            return Ok(());
        }
    }
}

async fn outcome(state: &AppState, job: &Job) -> Result<Outcome, Failure> {
    let session = sessions::find(state.db.reader(), job.school_id, job.session_id).await?;
    let session = session.context("the queue names a session that is not there")?;
    let task = Task::Judge(published(state, &session).await?);
    begin(state, job).await?;
    match judging::ask(state, replays::brief(state, &session, task)).await? {
        Answer::Judged(outcome) => Ok(*outcome),
        Answer::Permanent(why) => Err(Failure::Permanent(why)),
        Answer::Died(how) => Err(Failure::Death(how)),
        Answer::Passing(why) => Err(Failure::Passing(anyhow::anyhow!(why))),
        Answer::Replayed => Err(Failure::Passing(anyhow::anyhow!("a score was asked for, and a replay came"))),
    }
}

/// Writes down that a job is begun: should it be the end of us, it is known at the next start.
async fn begin(state: &AppState, job: &Job) -> anyhow::Result<()> {
    let mut tx = state.db.write().await?;
    tries::begin_job(&mut tx, job.session()).await?;
    Ok(tx.commit().await?)
}

/// The exercise as this school published it.
async fn published(state: &AppState, session: &Session) -> anyhow::Result<Option<RevisionBytes>> {
    let Some(revision) = session.revision_id else { return Ok(None) };
    Ok(exercises::bytes(state.db.reader(), session.school_id, revision).await?)
}

async fn store(state: &AppState, job: &Job, outcome: Outcome) -> anyhow::Result<()> {
    let now = state.clock.now();
    let key = job.session();
    let mut tx = state.db.write().await?;
    scores::add(&mut tx, key, &outcome.assessment, now).await?;
    scores::put_curve(&mut tx, key, &outcome.curve).await?;
    sessions::mark_scored(&mut tx, job.school_id, job.session_id, outcome.verified).await?;
    practice::refresh(&mut tx, key).await?;
    jobs::done(&mut tx, key).await?;
    let details = json!({
        "score": outcome.assessment.score,
        "rubric_sha256": outcome.assessment.rubric.sha256,
        "flagged": outcome.verified.flagged(),
    });
    entry(job, "session.scored").with(details).append(&mut tx, now).await?;
    tx.commit().await?;
    tracing::info!(session = %job.session_id, flagged = outcome.verified.flagged(), "recording scored");
    Ok(())
}

async fn refuse(state: &AppState, job: &Job, why: &str) -> anyhow::Result<()> {
    let mut tx = state.db.write().await?;
    sessions::mark_refused(&mut tx, job.school_id, job.session_id, why).await?;
    jobs::done(&mut tx, job.session()).await?;
    entry(job, "session.refused").with(json!({ "why": why })).append(&mut tx, state.clock.now()).await?;
    tx.commit().await?;
    tracing::warn!(session = %job.session_id, why, "recording refused");
    Ok(())
}

async fn put_off(state: &AppState, job: &Job, error: &anyhow::Error) -> anyhow::Result<()> {
    let why = format!("{error:#}");
    if job.attempts + 1 >= MAX_ATTEMPTS {
        return refuse(state, job, &format!("given up after {MAX_ATTEMPTS} tries; the last: {why}")).await;
    }
    let until = state.clock.now().plus_s(FIRST_WAIT_S << job.attempts);
    let mut tx = state.db.write().await?;
    jobs::put_off(&mut tx, job.session(), until, &why).await?;
    tx.commit().await?;
    tracing::warn!(session = %job.session_id, attempts = job.attempts + 1, why, "scoring put off");
    Ok(())
}

/// Puts a job behind those that nobody has died of, or aside where it was fatal before.
async fn bury(state: &AppState, job: &Job, how: &str) -> anyhow::Result<()> {
    let mut tx = state.db.write().await?;
    tries::note_death(&mut tx, job.session(), how).await?;
    let is_last = job.deaths + 1 >= tries::MOST_DEATHS;
    if is_last {
        entry(job, "session.set_aside").with(json!({ "why": how })).append(&mut tx, state.clock.now()).await?;
    }
    tx.commit().await?;
    tracing::error!(session = %job.session_id, how, set_aside = is_last, "a recording was fatal to its judge");
    Ok(())
}

fn entry<'a>(job: &Job, action: &'a str) -> Entry<'a> {
    Entry::new(job.school_id, Actor::Worker, action, job.session_id)
}
