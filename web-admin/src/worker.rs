//! Scores what was uploaded, from the durable queue: one recording at a time, and again after a crash.

use std::time::Duration;

use anyhow::Context;
use assessment::{Assessment, assess, own_exercise};
use mechanics::puncture::PunctureParams;
use recording::Recording;
use recording::verify::verify;
use scene::{ExerciseBundle, Patient};
use serde_json::json;

use crate::AppState;
use crate::domain::Curve;
use crate::recordings;
use crate::regrading;
use crate::replays;
use crate::storage::audit::{Actor, Entry};
use crate::storage::exercises::RevisionBytes;
use crate::storage::jobs::{self, Job};
use crate::storage::sessions::{self, Session, Verified};
use crate::storage::{exercises, practice, scores};

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
}

impl<E: Into<anyhow::Error>> From<E> for Failure {
    fn from(error: E) -> Self {
        Self::Passing(error.into())
    }
}

/// What was made of a recording.
struct Outcome {
    assessment: Assessment,
    verified: Verified,
    curve: Curve,
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
    let published = published(state, &session).await?;
    let path = state.config.recordings_dir.join(&session.recording_path);
    let replay = replays::folder(state, &session);
    let judged = recordings::with(state, path, move |recording| {
        let judged = judge(&recording, published);
        if judged.is_ok() {
            replays::keep(&replay, &recording);
        }
        judged
    });
    let judged = judged.await;
    match judged.context("a recording could not be worked on")? {
        Ok(outcome) => outcome,
        Err(recording::ReadError::Io(error)) => Err(error.into()),
        Err(unreadable) => Err(Failure::Permanent(unreadable.to_string())),
    }
}

/// The exercise as this school published it.
async fn published(state: &AppState, session: &Session) -> anyhow::Result<Option<RevisionBytes>> {
    let Some(revision) = session.revision_id else { return Ok(None) };
    Ok(exercises::bytes(state.db.reader(), session.school_id, revision).await?)
}

/// Scores and re-simulates. The published exercise judges; the recording's own only where the school has none like it.
fn judge(recording: &Recording, published: Option<RevisionBytes>) -> Result<Outcome, Failure> {
    let bundle = match published {
        Some(bytes) => ExerciseBundle::from_parts(&bytes.exercise, &bytes.scene, &bytes.meshes)
            .map_err(|refused| Failure::Permanent(refused.to_string()))?,
        None => own_exercise(recording).map_err(|e| Failure::Permanent(e.to_string()))?,
    };
    let assessment = assess(recording, &bundle).map_err(|e| Failure::Permanent(e.to_string()))?;
    let verified = resimulate(recording, &bundle)?;
    Ok(Outcome { assessment, verified, curve: Curve::of(recording, &bundle) })
}

fn resimulate(recording: &Recording, bundle: &ExerciseBundle) -> Result<Verified, Failure> {
    let patient = Patient { thickness_mm: recording.session.patient_thickness_mm.clone() };
    let (told, layers) = (patient.thickness_mm.len(), bundle.scene.layers.len());
    if told != layers {
        let why = format!("patient_thickness_mm: {told} layers; the scene has {layers}");
        return Err(Failure::Permanent(why));
    }
    let params = PunctureParams::new(bundle.recorded_spec(&patient, recording.session.judging))
        .map_err(|e| Failure::Permanent(format!("the recorded patient: {e}")))?;
    let found = verify(recording, &params);
    Ok(Verified {
        deviation_n: found.largest_deviation_n,
        event_differences: i64::try_from(found.event_differences).unwrap_or(i64::MAX),
        exact: found.exact(),
    })
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

fn entry<'a>(job: &Job, action: &'a str) -> Entry<'a> {
    Entry::new(job.school_id, Actor::Worker, action, job.session_id)
}
