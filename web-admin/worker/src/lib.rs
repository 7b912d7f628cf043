//! Scores uploads from the durable queue: as many concurrently as configured, scheduled fairly
//! between schools. Jobs survive a crash of the service; a recording that crashes its worker twice
//! is quarantined.

pub mod outbox;

use std::time::Duration;

use acts::error::is_database_unavailable;
use acts::recordings::duplicate_backfill;
use acts::replicas::{self, Duty};
use acts::scoring;
use acts::scoring::regrading;
use platform::clock;
use platform::fair_scheduler::{FairScheduler, ScorerPool};
use routes_base::AppState;
use store::operations::schools;
use store::recordings::parse_attempts;
use store::scoring::jobs;
use store::scoring::jobs::{Job, JobQuery, JobReturn};
use tokio::task::{JoinError, JoinSet};

/// Delay after the queue could not be processed.
const STALL: Duration = Duration::from_secs(60);
/// The same if the database is unavailable, which is often brief.
const AWAY: Duration = Duration::from_secs(2);

/// Processes the queue until the future is dropped, which may happen at any time: unfinished work
/// is repeated.
pub async fn run_worker(state: AppState) {
    let mut desk = WorkerDesk::default();
    loop {
        let pause = match desk.go_on(&state).await {
            Ok(()) => time_until_next_job(&state).await,
            Err(error) => note_stall(&error),
        };
        let ended = tokio::select! {
            Some(ended) = desk.running.join_next() => desk.settle(ended),
            () = state.jobs.notified() => Ok(()),
            () = tokio::time::sleep(pause) => Ok(()),
        };
        if let Err(error) = ended {
            // The job is still in the queue, and would fail again at once.
            tokio::time::sleep(note_stall(&error)).await;
        }
    }
}

/// Logs why the queue cannot be processed, and returns how long to wait.
fn note_stall(error: &anyhow::Error) -> Duration {
    tracing::error!(cause = format!("{error:#}"), "failed to process the queue");
    if is_database_unavailable(error) { AWAY } else { STALL }
}

/// Returns the time until the next job is due, limited so that jobs queued by other replicas and
/// changes of the clock are noticed.
async fn time_until_next_job(state: &AppState) -> Duration {
    let (now, longest) = (state.clock.now(), state.db.listening_period());
    let Ok(Some(next)) = jobs::find_next_job_time(state.db.reader(), now).await else { return longest };
    next.duration_since(now).min(longest)
}

/// Processes all due jobs, and then the re-gradings step by step, between which new uploads are
/// scored first.
pub async fn work_off_jobs(state: &AppState) -> anyhow::Result<()> {
    let mut desk = WorkerDesk::default();
    loop {
        desk.go_on(state).await?;
        match desk.running.join_next().await {
            Some(ended) => desk.settle(ended)?,
            None => return Ok(()),
        }
    }
}

/// The running jobs.
#[derive(Default)]
struct WorkerDesk {
    shares: FairScheduler,
    running: JoinSet<JobEnded>,
    /// Failed jobs whose lease has not been released yet.
    unsettled: Vec<Job>,
}

/// A finished job.
struct JobEnded {
    job: Job,
    took: Duration,
    done: anyhow::Result<()>,
}

impl WorkerDesk {
    /// Starts as many jobs as possible. If no job is waiting for a worker, continues re-gradings
    /// and backfills.
    async fn go_on(&mut self, state: &AppState) -> anyhow::Result<()> {
        while let Some(job) = self.unsettled.last() {
            scoring::requeue(state, job, JobReturn::Untried).await?;
            self.unsettled.pop();
        }
        loop {
            while self.running.len() < state.config.judges {
                let Some(job) = self.claim(state).await? else { break };
                self.begin(state, job);
            }
            if self.running.len() >= state.config.judges || !resume_old_jobs(state).await? {
                return Ok(());
            }
            while let Some(ended) = self.running.try_join_next() {
                self.settle(ended)?;
            }
        }
    }

    /// Claims the next job: first those without crashes, and among them by the schools' priority.
    async fn claim(&self, state: &AppState) -> anyhow::Result<Option<Job>> {
        let (reader, now) = (state.db.reader(), state.clock.now());
        let bench = ScorerPool { judges: state.config.judges, several: schools::are_schools_several(reader).await? };
        for deaths in 0..parse_attempts::MAX_CRASHES {
            let due = JobQuery { now, deaths };
            for school in self.shares.order(jobs::list_waiting_schools(reader, due).await?, bench) {
                // Another replica may have claimed it in the meantime.
                if let Some(job) = scoring::claim(state, school, due).await? {
                    return Ok(Some(job));
                }
            }
        }
        Ok(None)
    }

    fn begin(&mut self, state: &AppState, job: Job) {
        let state = state.clone();
        self.shares.begin(job.school_id);
        self.running.spawn(async move {
            let begun = clock::instant();
            let done = scoring::score_recording(&state, &job).await;
            JobEnded { job, took: begun.elapsed(), done }
        });
    }

    fn settle(&mut self, ended: Result<JobEnded, JoinError>) -> anyhow::Result<()> {
        let JobEnded { job, took, done } = ended?;
        self.shares.end(job.school_id, took);
        if done.is_err() {
            self.unsettled.push(job);
        }
        done
    }
}

/// Does one step of re-gradings and backfills. Returns false if nothing is left, or if the duty is
/// held by another replica.
async fn resume_old_jobs(state: &AppState) -> anyhow::Result<bool> {
    Ok(replicas::is_on_duty(state, Duty::OldAttempts).await?
        && (regrading::exercise::step(state).await? || duplicate_backfill::step(state).await?))
}
