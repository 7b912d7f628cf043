//! Grading again by another rubric: an act of its own, shown before it is done. One attempt by the rubric of today here, every
//! attempt at an exercise by that of any revision in [`exercise`].
//!
//! What was asked of the trainee stays as it was: only lines, limits, pass mark and what is required are those of the rubric.

pub mod exercise;

use anyhow::Context;
use assessment::{AssessError, Assessment, assess, own_exercise, suffices};
use data_encoding::HEXLOWER;
use documents::{Exercise, ExerciseBundle};
use model::ids::{RevisionId, SchoolId, ScoreId};
use model::{Moment, SessionKey};
use serde_json::json;
use store::audit::{Actor, AuditEntry};
use store::regradings::{self, NewReason};
use store::sessions::Session;
use store::{Connection, exercises, practice, scores};

use crate::error::Error;
use crate::service::Service;
use crate::{recordings, secret};

/// What decides a score.
#[derive(Clone, Debug)]
pub struct Rubric(Exercise);

impl Rubric {
    /// The rubric that trainees are judged by today. None where the school no longer teaches the exercise.
    pub async fn of_today(state: &Service, school: SchoolId, exercise: &str) -> Result<Option<Self>, Error> {
        match exercises::find_current_revision(state.db.reader(), school, exercise).await? {
            Some(taught) => Self::of_revision(state, school, taught.id).await.map(Some),
            None => Ok(None),
        }
    }

    /// The rubric of a revision.
    ///
    /// # Errors
    /// When there is no such revision, or the database fails.
    pub async fn of_revision(state: &Service, school: SchoolId, revision: RevisionId) -> Result<Self, Error> {
        let bytes =
            exercises::read_exercise_bytes(state.db.reader(), school, revision).await?.ok_or(Error::NotFound)?;
        let bundle = ExerciseBundle::from_parts(&bytes.exercise, &bytes.scene, &bytes.meshes);
        let bundle =
            bundle.map_err(|refused| anyhow::Error::new(refused).context("a published exercise is refused"))?;
        Ok(Self(bundle.exercise))
    }

    /// The rubric of an exercise with this digest, among its revisions; none where the school has not published it.
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

    /// What was asked of the trainee, judged by this rubric.
    #[must_use]
    pub fn judging(&self, asked: &Exercise) -> Exercise {
        let mut exercise = asked.clone();
        exercise.judge_by(&self.0);
        exercise
    }

    /// SHA-256 of what decides.
    #[must_use]
    pub fn sha256(&self) -> String {
        self.0.rubric_sha256()
    }

    /// What an attempt scores by it: by what was measured in it, or anew from its recording where a metric is asked for that was
    /// not measured, or not as it is defined today.
    ///
    /// # Errors
    /// When the recording has to be read and cannot be, or cannot be judged.
    pub async fn judge(&self, state: &Service, session: &Session) -> Result<Assessment, Error> {
        let Self(rubric) = self;
        let metrics = scores::list_score_metrics(state.db.reader(), session.key()).await?;
        let judged = match suffices(rubric, &metrics) {
            true => assessment::judge(metrics, rubric, &session.simulator_version),
            false => self.judge_recording(state, session).await?,
        };
        judged.map_err(|refused| Error::Unprocessable(refused.to_string()))
    }

    async fn judge_recording(
        &self,
        state: &Service,
        session: &Session,
    ) -> Result<Result<Assessment, AssessError>, Error> {
        let recording = recordings::fetch(state, session).await?;
        let Self(rubric) = self.clone();
        let judged = recordings::with(state, recording, move |recording| {
            let mut tried = own_exercise(&recording)?;
            tried.exercise.judge_by(&rubric);
            assess(&recording, &tried)
        });
        Ok(judged.await?.map_err(|error| anyhow::Error::from(error).context("a stored recording"))?)
    }
}

/// Who grades one attempt again, and why.
#[derive(Clone, Debug)]
pub struct Regrader<'a> {
    /// Who.
    pub actor: Actor,
    /// Why, unless it stands in the re-grading that the attempt is part of.
    pub reason: Option<&'a str>,
}

/// Adds a score to one attempt; earlier ones stay.
pub async fn apply(state: &Service, by: Regrader<'_>, session: &Session, again: &Assessment) -> Result<(), Error> {
    let mut tx = state.db.write().await?;
    let before = scores::find_newest_score(&mut *tx, session.key()).await?.context("a scored attempt")?;
    let change = ScoreChange { before: before.score, again };
    add(&mut tx, session.key(), by, change, state.clock.now()).await?;
    Ok(tx.commit().await?)
}

/// What a re-grading makes of an attempt.
#[derive(Clone, Copy)]
struct ScoreChange<'a> {
    /// The score that stood.
    before: f64,
    /// What is assessed now.
    again: &'a Assessment,
}

/// Adds a score to an attempt, with the audit entry that tells of it. The score's id.
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
        // The log never changes, and people are erased: it keeps the text's hash.
        told["reason_sha256"] = HEXLOWER.encode(&secret::token_sha256(reason)).into();
        let made_by = if let Actor::Person(id) = by.actor { Some(id) } else { None };
        let why = NewReason { score_id: score, reason, made_by };
        regradings::add_reason(tx, session, why, now).await?;
    }
    AuditEntry::new(session.school_id, by.actor, "session.regraded", session.id).with(told).append(tx, now).await?;
    Ok(score)
}
