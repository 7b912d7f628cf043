//! Re-grading of all attempts at an exercise with a revised rubric: preview, confirmation and
//! progress.

use model::ids::{OverrideId, PersonId, RegradingId, RevisionId, SchoolId, ScoreId, SessionId};
use model::scoring::regrading::{OutcomeCount, RegradingState};
use model::{CurrentPerson, Moment, Role, SessionKey};
use serde::Serialize;
use sqlx::FromRow;

use crate::{Connection, Executor, Json, Result};

mod lines;

pub use lines::{RegradedAttempt, ToGrade, found, graded, left, lines, looked_at, to_grade, to_look};

/// A re-grading.
#[derive(Clone, Debug, PartialEq, FromRow)]
pub struct Regrading {
    /// Id.
    pub id: RegradingId,
    /// School.
    pub school_id: SchoolId,
    /// Id of the exercise.
    pub exercise_id: String,
    /// Revision whose rubric is applied.
    pub revision_id: RevisionId,
    /// Publication time of the revision.
    pub published_at: Moment,
    /// SHA-256 of the exercise document.
    pub exercise_sha256: String,
    /// State.
    pub state: RegradingState,
    /// Reason.
    pub reason: Option<String>,
    /// Person who started the preview and confirmed it.
    pub made_by: PersonId,
    /// Name of that person.
    pub by: String,
    /// Start time of the preview.
    pub made_at: Moment,
    /// Time of completion.
    pub ended_at: Option<Moment>,
    /// Number of attempts by outcome; empty until the preview is complete.
    pub counts: Json<Vec<OutcomeCount>>,
    /// Hash of the attempts and grades shown in the preview.
    pub shown_sha256: Option<String>,
}

/// An attempt and its current grade.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, FromRow)]
pub struct Stood {
    /// The attempt.
    pub session_id: SessionId,
    /// Newest computed score.
    pub score_id: ScoreId,
    /// Override, if there is one.
    pub override_id: Option<OverrideId>,
}

/// Selects counted and scored attempts: school `$1`, exercise `$2`, person who may grade them `$3`,
/// all attempts of the school `$4`.
macro_rules! attempts {
    ($select:literal) => {
        concat!(
            $select,
            " FROM sessions s JOIN grades g ON g.school_id = s.school_id AND g.session_id = s.id
             JOIN scores c ON c.id = g.score_id
             WHERE s.school_id = $1 AND s.exercise_id = $2 AND s.state = 'scored' AND s.uncounted IS NULL
               AND ($4 OR s.trainee_id = $3 OR EXISTS (
               SELECT 1 FROM taught_trainees taught WHERE taught.teacher_id = $3 AND taught.trainee_id = s.trainee_id))"
        )
    };
}

macro_rules! regrading {
    ($rest:literal) => {
        concat!(
            "SELECT g.id, g.school_id, g.exercise_id, g.revision_id, r.published_at, r.exercise_sha256, g.state, g.reason,
               g.made_by, p.display_name AS \"by\", g.made_at, g.ended_at, g.counts, g.shown_sha256
             FROM regradings g
             JOIN exercise_revisions r ON r.school_id = g.school_id AND r.id = g.revision_id
             JOIN people p ON p.school_id = g.school_id AND p.id = g.made_by ",
            $rest
        )
    };
}

/// Starts the preview of a re-grading with the rubric of a revision, for all attempts that the
/// person may grade. Returns `None` without such attempts.
///
/// # Errors
/// If the exercise or the revision does not belong to the school, or the database fails.
pub async fn begin(
    writer: &mut Connection,
    by: &CurrentPerson,
    exercise: &str,
    revision: RevisionId,
    now: Moment,
) -> Result<Option<RegradingId>> {
    let id = RegradingId::made_at(now);
    sqlx::query(
        "INSERT INTO regradings (id, school_id, exercise_id, revision_id, state, made_by, made_at)
         VALUES ($1, $2, $3, $4, 'looking', $5, $6)",
    )
    .bind(id)
    .bind(by.school_id)
    .bind(exercise)
    .bind(revision)
    .bind(by.id)
    .bind(now)
    .execute(&mut *writer)
    .await?;
    let lines = sqlx::query(attempts!(
        "INSERT INTO regrading_lines (school_id, regrading_id, session_id, score_id, override_id, before, passed_before)
         SELECT s.school_id, $5, s.id, g.score_id, g.override_id, c.score, c.passed"
    ))
    .bind(by.school_id)
    .bind(exercise)
    .bind(by.id)
    .bind(by.role == Role::Administrator)
    .bind(id)
    .execute(writer)
    .await?;
    Ok((lines.rows_affected() > 0).then_some(id))
}

/// Returns the attempts at an exercise that the person may grade, with their current grades, sorted
/// by id.
pub async fn standing(executor: impl Executor<'_>, by: &CurrentPerson, exercise: &str) -> Result<Vec<Stood>> {
    let mut attempts: Vec<Stood> = sqlx::query_as(attempts!("SELECT s.id AS session_id, g.score_id, g.override_id"))
        .bind(by.school_id)
        .bind(exercise)
        .bind(by.id)
        .bind(by.role == Role::Administrator)
        .fetch_all(executor)
        .await?;
    // With ORDER BY, the engine would read all attempts of the school in the order of their ids.
    attempts.sort_by_key(|attempt| attempt.session_id);
    Ok(attempts)
}

/// Returns the attempts of a re-grading, with their grades at the start of the preview, sorted by
/// id.
pub async fn stood(executor: impl Executor<'_>, regrading: &Regrading) -> Result<Vec<Stood>> {
    sqlx::query_as(
        "SELECT session_id, score_id, override_id FROM regrading_lines WHERE school_id = $1 AND regrading_id = $2
         ORDER BY session_id",
    )
    .bind(regrading.school_id)
    .bind(regrading.id)
    .fetch_all(executor)
    .await
}

/// Returns a re-grading: one's own, or for an administrator any of the school.
pub async fn find(executor: impl Executor<'_>, by: &CurrentPerson, id: RegradingId) -> Result<Option<Regrading>> {
    sqlx::query_as(regrading!("WHERE g.school_id = $1 AND g.id = $2 AND ($3 OR g.made_by = $4)"))
        .bind(by.school_id)
        .bind(id)
        .bind(by.role == Role::Administrator)
        .bind(by.id)
        .fetch_optional(executor)
        .await
}

/// Returns the re-gradings of an exercise that the person may see, latest first; at most 20.
pub async fn of_exercise(executor: impl Executor<'_>, by: &CurrentPerson, exercise: &str) -> Result<Vec<Regrading>> {
    sqlx::query_as(regrading!(
        "WHERE g.school_id = $1 AND g.exercise_id = $2 AND ($3 OR g.made_by = $4)
         ORDER BY g.made_at DESC, g.id DESC LIMIT 20"
    ))
    .bind(by.school_id)
    .bind(exercise)
    .bind(by.role == Role::Administrator)
    .bind(by.id)
    .fetch_all(executor)
    .await
}

/// Returns the re-grading that the worker continues with: the oldest of all schools.
pub async fn under_way(executor: impl Executor<'_>) -> Result<Option<Regrading>> {
    sqlx::query_as(regrading!("WHERE g.state IN ('looking', 'grading') ORDER BY g.made_at LIMIT 1"))
        .fetch_optional(executor)
        .await
}

/// Completes the preview: stores the sums and the hash of the shown grades.
pub async fn show(writer: &mut Connection, regrading: &Regrading, shown_sha256: &str) -> Result<()> {
    let counts = lines::sum_up(&mut *writer, regrading).await?;
    sqlx::query(
        "UPDATE regradings SET state = 'shown', counts = $3, shown_sha256 = $4 WHERE school_id = $1 AND id = $2",
    )
    .bind(regrading.school_id)
    .bind(regrading.id)
    .bind(Json(counts))
    .bind(shown_sha256)
    .execute(writer)
    .await
    .map(drop)
}

/// Confirms a re-grading: the worker then stores the new scores.
///
/// # Errors
/// If the reason is empty, or the database fails.
pub async fn confirm(writer: &mut Connection, regrading: &Regrading, reason: &str, now: Moment) -> Result<()> {
    sqlx::query(
        "UPDATE regradings SET state = 'grading', reason = $3, confirmed_at = $4 WHERE school_id = $1 AND id = $2",
    )
    .bind(regrading.school_id)
    .bind(regrading.id)
    .bind(reason)
    .bind(now)
    .execute(writer)
    .await
    .map(drop)
}

/// Completes a re-grading and updates the counts: attempts whose score changed in the meantime are
/// counted separately.
pub async fn end(writer: &mut Connection, regrading: &Regrading, now: Moment) -> Result<()> {
    let counts = lines::sum_up(&mut *writer, regrading).await?;
    sqlx::query("UPDATE regradings SET state = 'done', counts = $3, ended_at = $4 WHERE school_id = $1 AND id = $2")
        .bind(regrading.school_id)
        .bind(regrading.id)
        .bind(Json(counts))
        .bind(now)
        .execute(writer)
        .await
        .map(drop)
}

/// Deletes previews that were started before `moment` and never confirmed.
pub async fn forget_before(writer: &mut Connection, moment: Moment) -> Result<()> {
    let forgotten: Vec<RegradingId> =
        sqlx::query_scalar("SELECT id FROM regradings WHERE made_at < $1 AND confirmed_at IS NULL")
            .bind(moment)
            .fetch_all(&mut *writer)
            .await?;
    for id in forgotten {
        forget(writer, id).await?;
    }
    Ok(())
}

/// Deletes a re-grading that was not confirmed. The caller checks this: of a confirmed one, the
/// lines would be deleted.
pub async fn forget(writer: &mut Connection, id: RegradingId) -> Result<()> {
    sqlx::query("DELETE FROM regrading_lines WHERE regrading_id = $1").bind(id).execute(&mut *writer).await?;
    sqlx::query("DELETE FROM regradings WHERE id = $1 AND confirmed_at IS NULL")
        .bind(id)
        .execute(writer)
        .await
        .map(drop)
}

/// A re-grading in the history of an attempt.
#[derive(Clone, Debug, PartialEq, Eq, FromRow)]
pub struct RegradingAct {
    /// New score.
    pub score_id: ScoreId,
    /// Name of the person; `None` on the command line.
    pub by: Option<String>,
    /// Reason.
    pub reason: String,
}

/// Reason for re-grading one attempt.
#[derive(Clone, Copy, Debug)]
pub struct NewReason<'a> {
    /// New score.
    pub score_id: ScoreId,
    /// Reason.
    pub reason: &'a str,
    /// Person; `None` on the command line.
    pub made_by: Option<PersonId>,
}

/// Stores the reason for re-grading one attempt.
pub async fn add_reason(writer: &mut Connection, session: SessionKey, new: NewReason<'_>, now: Moment) -> Result<()> {
    sqlx::query(
        "INSERT INTO regrade_reasons (score_id, school_id, session_id, reason, made_by, made_at)
         VALUES ($1, $2, $3, $4, $5, $6)",
    )
    .bind(new.score_id)
    .bind(session.school_id)
    .bind(session.id)
    .bind(new.reason)
    .bind(new.made_by)
    .bind(now)
    .execute(writer)
    .await
    .map(drop)
}

/// Returns the re-gradings in the history of an attempt's grade. Reasons recorded before the table
/// `regrade_reasons` existed are taken from the audit log.
pub async fn of_session(executor: impl Executor<'_>, session: SessionKey) -> Result<Vec<RegradingAct>> {
    // Without the hint SQLite reads all lines of the school: `unlikely` states that few belong to
    // one attempt.
    sqlx::query_as(
        "SELECT l.new_score_id AS score_id, p.display_name AS \"by\", g.reason
         FROM regrading_lines l
         JOIN regradings g ON g.school_id = l.school_id AND g.id = l.regrading_id
         JOIN people p ON p.school_id = g.school_id AND p.id = g.made_by
         WHERE l.school_id = $1 AND unlikely(l.session_id = $2) AND l.new_score_id IS NOT NULL
         UNION ALL
         SELECT w.score_id, p.display_name, w.reason FROM regrade_reasons w
         LEFT JOIN people p ON p.school_id = w.school_id AND p.id = w.made_by
         WHERE w.school_id = $1 AND w.session_id = $2
         UNION ALL
         SELECT unhex(replace(a.details ->> 'score', '-', '')), p.display_name, a.details ->> 'reason' FROM audit_log a
         LEFT JOIN people p ON p.school_id = a.school_id AND p.id = unhex(replace(a.actor, '-', ''))
         WHERE a.object = $3 AND a.school_id = $1 AND a.action = 'session.regraded' AND a.details ->> 'reason' IS NOT NULL",
    )
    .bind(session.school_id)
    .bind(session.id)
    .bind(session.id.to_string())
    .fetch_all(executor)
    .await
}
