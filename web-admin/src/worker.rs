//! Scores what was uploaded, from the durable queue: as many recordings at a time as there are judges, in turns of the schools, and again
//! after a crash; what is fatal twice is set aside.

use std::time::Duration;

use anyhow::Context;
use serde_json::json;
use tokio::task::{JoinError, JoinSet};

use crate::AppState;
use crate::clock;
use crate::judging::{self, Answer, Outcome, Question, Task};
use crate::killpoints::KillPoint;
use crate::motions;
use crate::regrading;
use crate::replays;
use crate::shares::{Bench, Shares};
use crate::storage::audit::{Actor, Entry};
use crate::storage::exercises::RevisionBytes;
use crate::storage::jobs::{self, Due, Job};
use crate::storage::scores::SessionKey;
use crate::storage::sessions::{self, Session};
use crate::storage::{exercises, practice, schools, scores, tries};

/// Tries before a recording is refused whatever the reason.
const MAX_ATTEMPTS: u32 = 6;
/// Longest first try: what takes longer has all its time once nobody else waits.
const FIRST_TRY: Duration = Duration::from_secs(30);
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
    let mut desk = Desk::default();
    loop {
        let pause = match desk.go_on(&state).await {
            Ok(()) => until_next(&state).await,
            Err(error) => stalled(&error),
        };
        let ended = tokio::select! {
            Some(ended) = desk.running.join_next() => desk.settle(ended),
            () = state.jobs.notified() => Ok(()),
            () = tokio::time::sleep(pause) => Ok(()),
        };
        if let Err(error) = ended {
            // It is still in the queue, and would fail again at once.
            tokio::time::sleep(stalled(&error)).await;
        }
    }
}

/// Notes why nothing goes on; how long to wait.
fn stalled(error: &anyhow::Error) -> Duration {
    tracing::error!(cause = format!("{error:#}"), "the queue cannot be worked off");
    LONGEST_SLEEP
}

/// How long until a job is due.
async fn until_next(state: &AppState) -> Duration {
    let now = state.clock.now();
    let Ok(Some(next)) = jobs::next_at(state.db.reader(), now).await else { return LONGEST_SLEEP };
    let wait_us = next.micros().saturating_sub(now.micros());
    Duration::from_micros(u64::try_from(wait_us).unwrap_or(0)).min(LONGEST_SLEEP)
}

/// Does every job that is due, and then what is graded again, piece by piece: whoever has just tried waits for no one else.
///
/// # Errors
/// When the database fails.
pub async fn work_off(state: &AppState) -> anyhow::Result<()> {
    let mut desk = Desk::default();
    loop {
        desk.go_on(state).await?;
        match desk.running.join_next().await {
            Some(ended) => desk.settle(ended)?,
            None => return Ok(()),
        }
    }
}

/// Jobs that are being done, by as many judges as there are.
#[derive(Default)]
struct Desk {
    shares: Shares,
    running: JoinSet<Ended>,
    held: Vec<SessionKey>,
}

/// How a job has ended.
struct Ended {
    session: SessionKey,
    took: Duration,
    done: anyhow::Result<()>,
}

impl Desk {
    /// Begins what can be begun. Where no job waits for a judge, goes on with old attempts.
    async fn go_on(&mut self, state: &AppState) -> anyhow::Result<()> {
        loop {
            while self.running.len() < state.config.judges {
                let Some(job) = self.next(state).await? else { break };
                self.begin(state, job);
            }
            if self.running.len() >= state.config.judges || !go_on_with_old(state).await? {
                return Ok(());
            }
            while let Some(ended) = self.running.try_join_next() {
                self.settle(ended)?;
            }
        }
    }

    /// The next job: of those that nobody has died of where there are any, of the school whose turn it is.
    async fn next(&self, state: &AppState) -> anyhow::Result<Option<Job>> {
        let (reader, now) = (state.db.reader(), state.clock.now());
        let bench = Bench { judges: state.config.judges, several: schools::are_several(reader).await? };
        let most = i64::try_from(self.held.len())? + 1;
        for deaths in 0..tries::MOST_DEATHS {
            let due = Due { now, deaths };
            for school in self.shares.order(jobs::schools(reader, due).await?, bench) {
                let found = jobs::due(reader, school, due, most).await?;
                if let Some(job) = found.into_iter().find(|job| !self.held.contains(&job.session())) {
                    return Ok(Some(job));
                }
            }
        }
        Ok(None)
    }

    fn begin(&mut self, state: &AppState, job: Job) {
        let (state, session) = (state.clone(), job.session());
        self.shares.begin(session.school_id);
        self.held.push(session);
        self.running.spawn(async move {
            let begun = clock::instant();
            let done = work(&state, &job).await;
            Ended { session, took: begun.elapsed(), done }
        });
    }

    fn settle(&mut self, ended: Result<Ended, JoinError>) -> anyhow::Result<()> {
        let Ended { session, took, done } = ended?;
        self.shares.end(session.school_id, took);
        self.held.retain(|held| *held != session);
        done
    }
}

/// A piece of what is done with attempts that were judged long ago. False where nothing is left.
async fn go_on_with_old(state: &AppState) -> anyhow::Result<bool> {
    Ok(regrading::exercise::step(state).await? || motions::step(state).await?)
}

/// Does a job.
async fn work(state: &AppState, job: &Job) -> anyhow::Result<()> {
    match outcome(state, job).await {
        Ok(outcome) => store(state, job, outcome).await,
        Err(Failure::Permanent(why)) => refuse(state, job, &why).await,
        Err(Failure::Passing(error)) => put_off(state, job, &error).await,
        Err(Failure::Death(how)) => bury(state, job, &how).await,
    }
}

async fn outcome(state: &AppState, job: &Job) -> Result<Outcome, Failure> {
    let session = sessions::find(state.db.reader(), job.school_id, job.session_id).await?;
    let session = session.context("the queue names a session that is not there")?;
    let task = Task::Judge(published(state, &session).await?);
    begin(state, job).await?;
    KillPoint::JobBegun.pass();
    let question = Question::Recording(replays::brief(state, &session, task));
    let most = if job.deaths == 0 { FIRST_TRY } else { Duration::MAX };
    match judging::ask_within(state, question, most).await? {
        Answer::Judged(outcome) => Ok(*outcome),
        Answer::Permanent(why) => Err(Failure::Permanent(why)),
        Answer::Died(how) => Err(Failure::Death(how)),
        Answer::Passing(why) => Err(Failure::Passing(anyhow::anyhow!(why))),
        other => Err(Failure::Passing(anyhow::anyhow!("a score was asked for, and this came: {other:?}"))),
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
    KillPoint::JobJudged.pass();
    let now = state.clock.now();
    let key = job.session();
    let mut tx = state.db.write().await?;
    scores::add(&mut tx, key, &outcome.assessment, now).await?;
    KillPoint::ScoreAdded.pass();
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
    KillPoint::ScoreCommitting.pass();
    tx.commit().await?;
    KillPoint::ScoreCommitted.pass();
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
