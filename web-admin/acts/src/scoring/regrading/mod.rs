//! Re-grading with another rubric: always previewed before it is applied. This module re-grades one
//! attempt with the current rubric; [`exercise`] re-grades all attempts at an exercise with the
//! rubric of any revision.
//!
//! The task of the trainee stays that of their attempt: only the rubric's lines, limits, pass mark
//! and requirements are replaced.

pub mod exercise;

use std::time::Duration;

use anyhow::Context;
use assessment::{Assessment, suffices};
use data_encoding::HEXLOWER;
use documents::{Exercise, ExerciseBundle};
use model::ids::{RevisionId, SchoolId, ScoreId};
use model::{Moment, SessionKey};
use platform::secret;
use serde_json::json;
use store::Connection;
use store::audit::{Actor, AuditEntry};
use store::authoring::exercises;
use store::recordings::sessions::Session;
use store::scoring::regradings::NewReason;
use store::scoring::{regradings, scores};
use store::training::practice;

use crate::error::Error;
use crate::recordings::replays;
use crate::sandbox_jobs::{JudgingTask, SandboxRequest, SandboxResponse};
use crate::service::Service;
use crate::training::learning_records::queueing::{GradeSource, queue_statements};
use crate::{recordings, sandbox};

/// Maximum time in the school's queue for scoring a recording again.
const PATIENCE: Duration = Duration::from_secs(60);

/// The parts of an exercise that determine a score.
#[derive(Clone, Debug)]
pub struct Rubric {
    exercise: Exercise,
    /// The revision that it is from.
    revision: RevisionId,
}

impl Rubric {
    /// Returns the current rubric of an exercise; `None` if the school no longer teaches it.
    pub async fn of_today(state: &Service, school: SchoolId, exercise: &str) -> Result<Option<Self>, Error> {
        match exercises::find_current_revision(state.db.reader(), school, exercise).await? {
            Some(taught) => Self::of_revision(state, school, taught.id).await.map(Some),
            None => Ok(None),
        }
    }

    /// Returns the rubric of a revision.
    ///
    /// # Errors
    /// Fails if there is no such revision, or the database fails.
    pub async fn of_revision(state: &Service, school: SchoolId, revision: RevisionId) -> Result<Self, Error> {
        let bytes = exercises::read_exercise_bytes(state.db.reader(), school, revision).await?;
        let bytes = bytes.ok_or(Error::NotFound)?;
        let bundle = ExerciseBundle::from_parts(&bytes.exercise, &bytes.scene, &bytes.meshes);
        let bundle = bundle.map_err(|refused| anyhow::Error::new(refused).context("published exercise is invalid"))?;
        Ok(Self { exercise: bundle.exercise, revision })
    }

    /// Returns the rubric with this digest among the revisions of an exercise; `None` if the school
    /// has not published it.
    pub async fn of_digest(
        state: &Service,
        school: SchoolId,
        exercise: &str,
        sha256: &str,
    ) -> Result<Option<Self>, Error> {
        for revision in exercises::list_exercise_revisions(state.db.reader(), school, exercise).await? {
            let rubric = Self::of_revision(state, school, revision.id).await?;
            if rubric.sha256() == sha256 {
                return Ok(Some(rubric));
            }
        }
        Ok(None)
    }

    /// Returns the exercise that the trainee attempted, with this rubric.
    #[must_use]
    pub fn judging(&self, asked: &Exercise) -> Exercise {
        let mut exercise = asked.clone();
        exercise.judge_by(&self.exercise);
        exercise
    }

    /// Returns the revision of the exercise that it is from.
    #[must_use]
    pub const fn revision(&self) -> RevisionId {
        self.revision
    }

    /// Returns the SHA-256 of the rubric.
    #[must_use]
    pub fn sha256(&self) -> String {
        self.exercise.rubric_sha256()
    }

    /// Scores an attempt by this rubric: from its stored metrics, or from its recording if a metric
    /// is missing or its definition has changed.
    ///
    /// # Errors
    /// Fails if the recording is needed and cannot be read or assessed.
    pub async fn judge(&self, state: &Service, session: &Session) -> Result<Assessment, Error> {
        let metrics = scores::list_score_metrics(state.db.reader(), session.key()).await?;
        if !suffices(&self.exercise, &metrics) {
            return self.judge_recording(state, session).await;
        }
        let judged = assessment::judge(metrics, &self.exercise, &session.simulator_version);
        judged.map_err(|refused| Error::Unprocessable(refused.to_string()))
    }

    /// Scores the recording in a helper process, in the school's queue.
    async fn judge_recording(&self, state: &Service, session: &Session) -> Result<Assessment, Error> {
        let school = session.school_id;
        let bytes = exercises::read_exercise_bytes(state.db.reader(), school, self.revision).await?;
        let _place = state.helpers.enter(school, PATIENCE).await?;
        let recording = recordings::fetch(state, session).await?;
        let task = JudgingTask::Regrade(bytes.ok_or(Error::NotFound)?);
        let brief = replays::brief(state, session, &recording, task);
        match sandbox::ask(state, SandboxRequest::Recording(brief)).await? {
            SandboxResponse::Regraded(assessment) => Ok(*assessment),
            SandboxResponse::Permanent(why) => Err(Error::Unprocessable(why)),
            other => Err(anyhow::anyhow!("a stored recording was not scored again: {other:?}").into()),
        }
    }
}

/// Actor and reason of a re-grading.
#[derive(Clone, Debug)]
pub struct Regrader<'a> {
    /// Actor.
    pub actor: Actor,
    /// Reason; `None` if it is stored with the re-grading of the whole exercise.
    pub reason: Option<&'a str>,
}

/// Adds a score to one attempt; earlier scores are kept.
pub async fn apply(state: &Service, by: Regrader<'_>, session: &Session, again: &Assessment) -> Result<(), Error> {
    let mut tx = state.db.write().await?;
    let before = scores::find_newest_score(&mut *tx, session.key()).await?.context("a scored attempt")?;
    let change = ScoreChange { before: before.score, again };
    let now = state.clock.now();
    let score = add(&mut tx, session.key(), by, change, now).await?;
    queue_statements(state, &mut tx, session.key(), GradeSource::Score(score), now).await?;
    Ok(tx.commit().await?)
}

/// Change of the score by a re-grading.
#[derive(Clone, Copy)]
struct ScoreChange<'a> {
    /// Previous score.
    before: f64,
    /// New assessment.
    again: &'a Assessment,
}

/// Adds a score to an attempt, with its audit entry, and returns the score's id.
async fn add(
    tx: &mut Connection,
    session: SessionKey,
    by: Regrader<'_>,
    change: ScoreChange<'_>,
    now: Moment,
) -> Result<ScoreId, Error> {
    let ScoreChange { before, again } = change;
    let score = scores::add_score(tx, session, again, now).await?;
    practice::refresh_practice(tx, session).await?;
    let mut told = json!({ "from": before, "to": again.score, "rubric_sha256": again.rubric.sha256, "score": score });
    if let Some(reason) = by.reason {
        // The log is immutable but people can be erased, so it contains only a hash of the text.
        told["reason_sha256"] = HEXLOWER.encode(&secret::token_sha256(reason)).into();
        let made_by = if let Actor::Person(id) = by.actor { Some(id) } else { None };
        let why = NewReason { score_id: score, reason, made_by };
        regradings::add_reason(tx, session, why, now).await?;
    }
    AuditEntry::new(session.school_id, by.actor, "session.regraded", session.id).with(told).append(tx, now).await?;
    Ok(score)
}
