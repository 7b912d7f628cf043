//! Scores what was uploaded, from the durable queue: as many recordings at a time as there are judges, in turns of the schools, and again
//! after a crash; what is fatal twice is set aside.

pub mod outbox;

use std::time::Duration;

use acts::error::is_database_away;
use acts::replicas::{self, Duty};
use acts::shares::{Bench, Shares};
use acts::{clock, motions, regrading, scoring};
use routes_base::AppState;
use store::jobs::{Job, JobQuery, JobReturn};
use store::{jobs, schools, tries};
use tokio::task::{JoinError, JoinSet};

/// Wait after the queue could not be worked off.
const STALL: Duration = Duration::from_secs(60);
/// The same where the database does not answer, and may do so at any time.
const AWAY: Duration = Duration::from_secs(2);

/// Works until it is dropped. That may happen at any time: what is not stored yet is done again.
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
            // It is still in the queue, and would fail again at once.
            tokio::time::sleep(note_stall(&error)).await;
        }
    }
}

/// Notes why nothing goes on; how long to wait.
fn note_stall(error: &anyhow::Error) -> Duration {
    tracing::error!(cause = format!("{error:#}"), "the queue cannot be worked off");
    if is_database_away(error) { AWAY } else { STALL }
}

/// How long until a job is due; no longer than others, or whoever sets the clock, may be left unnoticed.
async fn time_until_next_job(state: &AppState) -> Duration {
    let (now, longest) = (state.clock.now(), state.db.listening_period());
    let Ok(Some(next)) = jobs::find_next_job_time(state.db.reader(), now).await else { return longest };
    next.duration_since(now).min(longest)
}

/// Does every job that is due, and then what is graded again, piece by piece: whoever has just tried waits for no one else.
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

/// Jobs that are being done, by as many judges as there are.
#[derive(Default)]
struct WorkerDesk {
    shares: Shares,
    running: JoinSet<JobEnded>,
    /// Jobs that ended without a word to the queue, which has them as held by us.
    unsettled: Vec<Job>,
}

/// How a job has ended.
struct JobEnded {
    job: Job,
    took: Duration,
    done: anyhow::Result<()>,
}

impl WorkerDesk {
    /// Begins what can be begun. Where no job waits for a judge, goes on with old attempts.
    async fn go_on(&mut self, state: &AppState) -> anyhow::Result<()> {
        while let Some(job) = self.unsettled.last() {
            scoring::give_back(state, job, JobReturn::Untried).await?;
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

    /// Takes the next job: of those that nobody has died of where there are any, of the school whose turn it is.
    async fn claim(&self, state: &AppState) -> anyhow::Result<Option<Job>> {
        let (reader, now) = (state.db.reader(), state.clock.now());
        let bench = Bench { judges: state.config.judges, several: schools::are_schools_several(reader).await? };
        for deaths in 0..tries::MOST_DEATHS {
            let due = JobQuery { now, deaths };
            for school in self.shares.order(jobs::list_waiting_schools(reader, due).await?, bench) {
                // Another service may have been quicker.
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

/// A piece of what is done with attempts that were judged long ago. False where nothing is left, or it is another service's to do.
async fn resume_old_jobs(state: &AppState) -> anyhow::Result<bool> {
    Ok(replicas::is_on_duty(state, Duty::OldAttempts).await?
        && (regrading::exercise::step(state).await? || motions::step(state).await?))
}
