//! Re-grades all attempts at an exercise with another rubric. The worker computes the changes
//! attempt by attempt; a teacher reviews and confirms them with a reason; the worker adds the
//! previewed scores. Each step is stored, so a crash repeats at most one.

use anyhow::Context;
use data_encoding::HEXLOWER;
use futures::future::join_all;
use model::ids::{RegradingId, RevisionId, SessionId};
use model::scoring::judgement;
use model::scoring::regrading::{RegradingOutcome, RegradingState, count_attempts};
use model::{CurrentPerson, SessionKey};
use serde_json::json;
use sha2::{Digest, Sha256};
use store::Write;
use store::audit::{Actor, AuditEntry};
use store::authoring::exercises;
use store::recordings::sessions;
use store::scoring::regradings::{RegradedAttempt, Regrading, Stood};
use store::scoring::{grades, regradings, scores};

use super::{Regrader, Rubric, ScoreChange, add};
use crate::error::{Error, refuse_trainees};
use crate::service::Service;
use crate::training::learning_records::queueing::{GradeSource, queue_statements};

/// How long a preview can be confirmed, in s.
pub const PREVIEW_LIFETIME_S: i64 = 86_400;
/// Attempts assessed before the worker checks the queue of uploads again, which has priority.
const LOOKED_AT_ONCE: u32 = 4;
/// Attempts whose scores are added in one transaction.
const GRADED_AT_ONCE: u32 = 32;
/// Maximum difference of equal scores, in points.
const EQUAL: f64 = 1e-9;

/// Starts a preview of the changes by a revision's rubric, for every attempt at the exercise that
/// the person may grade.
///
/// # Errors
/// Fails if they may not grade, the exercise has no such revision, or there is no attempt.
pub async fn look(
    state: &Service,
    by: &CurrentPerson,
    exercise: &str,
    revision: RevisionId,
) -> Result<RegradingId, Error> {
    refuse_trainees(by)?;
    let revisions = exercises::list_exercise_revisions(state.db.reader(), by.school_id, exercise).await?;
    if !revisions.iter().any(|known| known.id == revision) {
        return Err(Error::NotFound);
    }
    let mut tx = state.db.write().await?;
    let begun = regradings::begin(&mut tx, by, exercise, revision, state.clock.now()).await?;
    let nothing = || Error::Conflict(tr!("none of your trainees has a scored attempt at this exercise").to_owned());
    let id = begun.ok_or_else(nothing)?;
    tx.commit().await?;
    state.jobs.notify_one();
    Ok(id)
}

/// Returns a re-grading that the person may see.
///
/// # Errors
/// Returns [`Error::NotFound`] for any other.
pub async fn find(state: &Service, by: &CurrentPerson, id: RegradingId) -> Result<Regrading, Error> {
    refuse_trainees(by)?;
    regradings::find(state.db.reader(), by, id).await?.ok_or(Error::NotFound)
}

/// Hashes the attempts and their grades, so that only the previewed changes can be confirmed.
fn digest(regrading: &Regrading, attempts: &[Stood]) -> Result<String, Error> {
    let shown = serde_json::to_vec(&(regrading.id, attempts)).map_err(anyhow::Error::from)?;
    Ok(HEXLOWER.encode(&Sha256::digest(shown)))
}

/// Confirms a preview, after which the worker adds the scores. Returns false, and changes nothing,
/// if attempts or grades have changed since.
///
/// # Errors
/// Fails if the re-grading is not waiting for confirmation, was started by another person, the
/// reason is missing, or the database fails.
pub async fn confirm(
    state: &Service,
    by: &CurrentPerson,
    id: RegradingId,
    seen: &str,
    reason: &str,
) -> Result<bool, Error> {
    let mut tx = state.db.write().await?;
    let regrading = own(&mut tx, by, id).await?;
    if regrading.state != RegradingState::Shown {
        return Err(Error::Conflict(tr!("this re-grading is not waiting for confirmation").to_owned()));
    }
    let now_standing = regradings::standing(&mut *tx, by, &regrading.exercise_id).await?;
    if digest(&regrading, &now_standing)? != seen {
        return Ok(false);
    }
    let reason = judgement::reason(reason).map_err(|refused| Error::Unprocessable(refused.to_string()))?;
    regradings::confirm(&mut tx, &regrading, &reason, state.clock.now()).await?;
    let told = json!({
        "regrading": id,
        "revision": regrading.revision_id,
        "attempts": now_standing.len(),
        "passes": count_attempts(&regrading.counts, &[RegradingOutcome::Passes]),
        "fails": count_attempts(&regrading.counts, &[RegradingOutcome::Fails]),
        "shown_sha256": seen,
    });
    let entry = AuditEntry::by(by, "exercise.regraded", regrading.exercise_id).with(told);
    entry.append(&mut tx, state.clock.now()).await?;
    tx.commit().await?;
    state.jobs.notify_one();
    Ok(true)
}

/// Returns a re-grading that this person has started.
async fn own(tx: &mut Write, by: &CurrentPerson, id: RegradingId) -> Result<Regrading, Error> {
    refuse_trainees(by)?;
    let regrading = regradings::find(&mut **tx, by, id).await?.ok_or(Error::NotFound)?;
    if regrading.made_by != by.id {
        return Err(Error::Forbidden(tr!("only the person who previewed the changes can confirm them")));
    }
    Ok(regrading)
}

/// Discards a preview and returns the id of the exercise.
///
/// # Errors
/// Fails if it was confirmed, was started by another person, or the database fails.
pub async fn forget(state: &Service, by: &CurrentPerson, id: RegradingId) -> Result<String, Error> {
    let mut tx = state.db.write().await?;
    let regrading = own(&mut tx, by, id).await?;
    if !matches!(regrading.state, RegradingState::Looking | RegradingState::Shown) {
        return Err(Error::Conflict(tr!("this re-grading is confirmed and can no longer be withdrawn").to_owned()));
    }
    regradings::forget(&mut tx, id).await?;
    tx.commit().await?;
    Ok(regrading.exercise_id)
}

/// Continues the oldest unfinished re-grading. Returns false if all are finished.
pub async fn step(state: &Service) -> anyhow::Result<bool> {
    let Some(regrading) = regradings::under_way(state.db.reader()).await? else { return Ok(false) };
    match regrading.state {
        RegradingState::Grading => grade_some(state, &regrading).await?,
        _ => look_at_some(state, &regrading).await?,
    }
    Ok(true)
}

async fn look_at_some(state: &Service, regrading: &Regrading) -> Result<(), Error> {
    let next = regradings::to_look(state.db.reader(), regrading.id, LOOKED_AT_ONCE).await?;
    let rubric = Rubric::of_revision(state, regrading.school_id, regrading.revision_id).await?;
    let found = join_all(next.iter().map(|session| judge(state, regrading, &rubric, *session))).await;
    let mut tx = state.db.write().await?;
    if next.is_empty() {
        let shown = digest(regrading, &regradings::stood(&mut *tx, regrading).await?)?;
        regradings::show(&mut tx, regrading, &shown).await?;
    }
    for (session, found) in next.iter().zip(found) {
        regradings::found(&mut tx, regrading, *session, &found?).await?;
    }
    Ok(tx.commit().await?)
}

/// Computes the outcome for one attempt.
async fn judge(
    state: &Service,
    regrading: &Regrading,
    rubric: &Rubric,
    id: SessionId,
) -> Result<RegradedAttempt, Error> {
    let (reader, school) = (state.db.reader(), regrading.school_id);
    let session = sessions::find_session(reader, school, id).await?.context("an attempt that is gone")?;
    let before = scores::find_newest_score(reader, session.key()).await?.context("a scored attempt")?;
    if before.rubric_sha256 == rubric.sha256() {
        return Ok(RegradedAttempt { outcome: RegradingOutcome::Same, assessment: None, why: None });
    }
    let assessment = match rubric.judge(state, &session).await {
        Ok(assessment) => assessment,
        Err(error) => {
            tracing::warn!(session = %id, cause = format!("{error:?}"), "attempt cannot be re-graded");
            return Ok(RegradedAttempt {
                outcome: RegradingOutcome::Unreadable,
                assessment: None,
                why: Some(error.to_string()),
            });
        }
    };
    let overridden = grades::find_grade(reader, session.key()).await?.is_some_and(|grade| grade.overridden);
    let outcome = match (before.passed, assessment.passed) {
        _ if overridden => RegradingOutcome::Overridden,
        (false, true) => RegradingOutcome::Passes,
        (true, false) => RegradingOutcome::Fails,
        _ if (before.score - assessment.score).abs() < EQUAL => RegradingOutcome::Equal,
        _ => RegradingOutcome::Changed,
    };
    Ok(RegradedAttempt { outcome, assessment: Some(assessment), why: None })
}

async fn grade_some(state: &Service, regrading: &Regrading) -> Result<(), Error> {
    let now = state.clock.now();
    let mut tx = state.db.write().await?;
    let next = regradings::to_grade(&mut *tx, regrading.id, GRADED_AT_ONCE).await?;
    if next.is_empty() {
        regradings::end(&mut tx, regrading, now).await?;
    }
    for line in next {
        let key = SessionKey { school_id: regrading.school_id, id: line.session_id };
        let score = match line.current {
            true => {
                let change = ScoreChange { before: line.before, again: &line.assessment.0 };
                // The reason is stored with the re-grading, once for all attempts.
                let by = Regrader { actor: Actor::Person(regrading.made_by), reason: None };
                let score = add(&mut tx, key, by, change, now).await?;
                queue_statements(state, &mut tx, key, GradeSource::Score(score), now).await?;
                Some(score)
            }
            false => None,
        };
        regradings::graded(&mut tx, regrading, line.session_id, score).await?;
    }
    Ok(tx.commit().await?)
}
