//! Scores what was uploaded, from the durable queue: as many recordings at a time as there are judges, in turns of the schools, and again
//! after a crash; what is fatal twice is set aside.

use std::time::Duration;

use acts::shares::{Bench, Shares};
use acts::{clock, motions, regrading, scoring};
use model::SessionKey;
use store::jobs::{Job, JobQuery};
use store::{jobs, schools, tries};
use tokio::task::{JoinError, JoinSet};

use crate::AppState;

/// Longest sleep between two looks at the queue: the clock may be set.
const LONGEST_SLEEP: Duration = Duration::from_secs(60);

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
    LONGEST_SLEEP
}

/// How long until a job is due.
async fn time_until_next_job(state: &AppState) -> Duration {
    let now = state.clock.now();
    let Ok(Some(next)) = jobs::find_next_job_time(state.db.reader(), now).await else { return LONGEST_SLEEP };
    next.duration_since(now).min(LONGEST_SLEEP)
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
    held: Vec<SessionKey>,
}

/// How a job has ended.
struct JobEnded {
    session: SessionKey,
    took: Duration,
    done: anyhow::Result<()>,
}

impl WorkerDesk {
    /// Begins what can be begun. Where no job waits for a judge, goes on with old attempts.
    async fn go_on(&mut self, state: &AppState) -> anyhow::Result<()> {
        loop {
            while self.running.len() < state.config.judges {
                let Some(job) = self.next(state).await? else { break };
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

    /// The next job: of those that nobody has died of where there are any, of the school whose turn it is.
    async fn next(&self, state: &AppState) -> anyhow::Result<Option<Job>> {
        let (reader, now) = (state.db.reader(), state.clock.now());
        let bench = Bench { judges: state.config.judges, several: schools::are_schools_several(reader).await? };
        let most = i64::try_from(self.held.len())? + 1;
        for deaths in 0..tries::MOST_DEATHS {
            let due = JobQuery { now, deaths };
            for school in self.shares.order(jobs::list_waiting_schools(reader, due).await?, bench) {
                let found = jobs::list_due_jobs(reader, school, due, most).await?;
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
            let done = scoring::score_recording(&state, &job).await;
            JobEnded { session, took: begun.elapsed(), done }
        });
    }

    fn settle(&mut self, ended: Result<JobEnded, JoinError>) -> anyhow::Result<()> {
        let JobEnded { session, took, done } = ended?;
        self.shares.end(session.school_id, took);
        self.held.retain(|held| *held != session);
        done
    }
}

/// A piece of what is done with attempts that were judged long ago. False where nothing is left.
async fn resume_old_jobs(state: &AppState) -> anyhow::Result<bool> {
    Ok(regrading::exercise::step(state).await? || motions::step(state).await?)
}
