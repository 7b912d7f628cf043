//! Re-gradings of every attempt at an exercise: what each attempt was and would be, and how far the work is.

use model::ids::{OverrideId, PersonId, RegradingId, RevisionId, SchoolId, ScoreId, SessionId};
use model::regrading::{OutcomeCount, RegradingState};
use model::{CurrentPerson, Moment, Role, SessionKey};
use serde::Serialize;
use sqlx::FromRow;

use super::{Connection, Executor, Json, Result};

mod lines;

pub use lines::{RegradedAttempt, ToGrade, found, graded, left, lines, looked_at, to_grade, to_look};

/// A re-grading.
#[derive(Clone, Debug, PartialEq, FromRow)]
pub struct Regrading {
    /// Id.
    pub id: RegradingId,
    /// School.
    pub school_id: SchoolId,
    /// Exercise.
    pub exercise_id: String,
    /// The revision whose rubric judges.
    pub revision_id: RevisionId,
    /// When that was published.
    pub published_at: Moment,
    /// SHA-256 of its document.
    pub exercise_sha256: String,
    /// How far it is.
    pub state: RegradingState,
    /// Why it was done.
    pub reason: Option<String>,
    /// Who looked, and confirmed.
    pub made_by: PersonId,
    /// Their name.
    pub by: String,
    /// When they looked.
    pub made_at: Moment,
    /// When it was all done.
    pub ended_at: Option<Moment>,
    /// How many attempts there are of each outcome; none before it is shown.
    pub counts: Json<Vec<OutcomeCount>>,
    /// Stands for the attempts and their grades as they were shown.
    pub shown_sha256: Option<String>,
}

/// An attempt as its grade stands.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, FromRow)]
pub struct Stood {
    /// The attempt.
    pub session_id: SessionId,
    /// The newest computed score.
    pub score_id: ScoreId,
    /// What somebody has put in its place.
    pub override_id: Option<OverrideId>,
}

/// The scored attempts at an exercise that count and that somebody may judge: $1 school, $2 exercise, $3 who, $4 whether all.
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

/// Begins to look what the rubric of a revision would change, for every attempt that somebody may judge. None where there is
/// no attempt.
///
/// # Errors
/// When exercise or revision are not of the school, or the database fails.
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

/// The attempts at an exercise that somebody may judge, as their grades stand now, by id.
pub async fn standing(executor: impl Executor<'_>, by: &CurrentPerson, exercise: &str) -> Result<Vec<Stood>> {
    let mut attempts: Vec<Stood> = sqlx::query_as(attempts!("SELECT s.id AS session_id, g.score_id, g.override_id"))
        .bind(by.school_id)
        .bind(exercise)
        .bind(by.id)
        .bind(by.role == Role::Administrator)
        .fetch_all(executor)
        .await?;
    // Sorted by the statement, every attempt of the school would be read for its order.
    attempts.sort_by_key(|attempt| attempt.session_id);
    Ok(attempts)
}

/// The attempts of a re-grading, as their grades stood when they were looked at, by id.
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

/// A re-grading that somebody may see: their own, any of the school for an administrator.
pub async fn find(executor: impl Executor<'_>, by: &CurrentPerson, id: RegradingId) -> Result<Option<Regrading>> {
    sqlx::query_as(regrading!("WHERE g.school_id = $1 AND g.id = $2 AND ($3 OR g.made_by = $4)"))
        .bind(by.school_id)
        .bind(id)
        .bind(by.role == Role::Administrator)
        .bind(by.id)
        .fetch_optional(executor)
        .await
}

/// The re-gradings of an exercise that somebody may see, the latest first, at most 20.
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

/// The re-grading that the worker is to go on with: the oldest of every school's.
pub async fn under_way(executor: impl Executor<'_>) -> Result<Option<Regrading>> {
    sqlx::query_as(regrading!("WHERE g.state IN ('looking', 'grading') ORDER BY g.made_at LIMIT 1"))
        .fetch_optional(executor)
        .await
}

/// Looking has come to its end: what was found is summed up, and stands under a digest.
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

/// Lets the scores be added.
///
/// # Errors
/// When the reason is empty, or the database fails.
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

/// Every score was added; those that somebody else was quicker with are counted as such.
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

/// Throws away what was looked at before a moment and never confirmed.
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

/// Throws a re-grading away that was not confirmed.
///
/// # Errors
/// When it was confirmed, or the database fails.
pub async fn forget(writer: &mut Connection, id: RegradingId) -> Result<()> {
    sqlx::query("DELETE FROM regrading_lines WHERE regrading_id = $1").bind(id).execute(&mut *writer).await?;
    sqlx::query("DELETE FROM regradings WHERE id = $1 AND confirmed_at IS NULL")
        .bind(id)
        .execute(writer)
        .await
        .map(drop)
}

/// Who had a score of an attempt computed again, alone or with every other at its exercise, and why.
#[derive(Clone, Debug, PartialEq, Eq, FromRow)]
pub struct RegradingAct {
    /// The score.
    pub score_id: ScoreId,
    /// Their name; none at the command line.
    pub by: Option<String>,
    /// Why.
    pub reason: String,
}

/// Why one attempt was graded again.
#[derive(Clone, Copy, Debug)]
pub struct NewReason<'a> {
    /// The score that was added.
    pub score_id: ScoreId,
    /// Why.
    pub reason: &'a str,
    /// By whom; none at the command line.
    pub made_by: Option<PersonId>,
}

/// Keeps why one attempt was graded again.
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

/// The re-gradings in the history of an attempt's grade. Reasons of before stand in the audit log.
pub async fn of_session(executor: impl Executor<'_>, session: SessionKey) -> Result<Vec<RegradingAct>> {
    // Left to itself, SQLite reads every line of the school: it is told that few are of one attempt.
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
