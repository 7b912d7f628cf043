//! The effective grade of an attempt: the newest computed score, or an override. All scores and
//! overrides are kept.

use model::ids::{OverrideId, PersonId, SessionId};
use model::{Moment, SessionKey};
use sqlx::FromRow;

use crate::training::practice;
use crate::{Connection, Executor, Result};

/// The effective grade of an attempt.
#[derive(Clone, Copy, Debug, PartialEq, FromRow)]
pub struct Grade {
    /// Score, 0–100.
    pub score: f64,
    /// The attempt is passed.
    pub passed: bool,
    /// The grade is an override.
    pub overridden: bool,
}

/// An override of the computed score, or its removal.
#[derive(Clone, Debug, PartialEq)]
pub struct NewOverride<'a> {
    /// Score (0–100) and pass; `None` restores the computed score.
    pub grade: Option<(f64, bool)>,
    /// Reason.
    pub reason: &'a str,
    /// Person who makes the override.
    pub made_by: PersonId,
}

/// A recorded override.
#[derive(Clone, Debug, PartialEq, FromRow)]
pub struct OverrideRecord {
    /// Score, 0–100; `None` if the entry restores the computed score.
    pub score: Option<f64>,
    /// The attempt is passed; `None` if the entry restores the computed score.
    pub passed: Option<bool>,
    /// Reason.
    pub reason: String,
    /// Name of the person who made it.
    pub by: String,
    /// Time of the override.
    pub made_at: Moment,
}

/// Returns the effective grade of an attempt; `None` before it is scored.
pub async fn find_grade(executor: impl Executor<'_>, session: SessionKey) -> Result<Option<Grade>> {
    sqlx::query_as(
        "SELECT score, passed, override_id IS NOT NULL AS overridden FROM grades
         WHERE school_id = $1 AND session_id = $2",
    )
    .bind(session.school_id)
    .bind(session.id)
    .fetch_optional(executor)
    .await
}

/// Adds an override and returns its id. Earlier overrides and all computed scores are kept.
///
/// # Errors
/// If the attempt or the person belongs to another school, the reason is empty, or the database
/// fails.
pub async fn put_override(
    writer: &mut Connection,
    session: SessionKey,
    new: &NewOverride<'_>,
    now: Moment,
) -> Result<OverrideId> {
    let id = OverrideId::made_at(now);
    sqlx::query(
        "INSERT INTO score_overrides (id, school_id, session_id, score, passed, reason, made_by, made_at)
         VALUES ($1, $2, $3, $4, $5, $6, $7, $8)",
    )
    .bind(id)
    .bind(session.school_id)
    .bind(session.id)
    .bind(new.grade.map(|(score, _)| score))
    .bind(new.grade.map(|(_, passed)| passed))
    .bind(new.reason)
    .bind(new.made_by)
    .bind(now)
    .execute(&mut *writer)
    .await?;
    practice::refresh_practice(writer, session).await?;
    Ok(id)
}

/// Returns attempts without an override whose grade differs from the score it refers to.
pub async fn list_strayed_grades(executor: impl Executor<'_>) -> Result<Vec<SessionId>> {
    sqlx::query_scalar(
        "SELECT g.session_id FROM grades g JOIN scores c ON c.id = g.score_id
         WHERE g.override_id IS NULL AND (g.score <> c.score OR g.passed <> c.passed)",
    )
    .fetch_all(executor)
    .await
}

/// Returns all overrides of an attempt, oldest first.
pub async fn list_overrides(executor: impl Executor<'_>, session: SessionKey) -> Result<Vec<OverrideRecord>> {
    sqlx::query_as(
        "SELECT o.score, o.passed, o.reason, p.display_name AS by, o.made_at FROM score_overrides o
         JOIN people p ON p.school_id = o.school_id AND p.id = o.made_by
         WHERE o.school_id = $1 AND o.session_id = $2 ORDER BY o.rowid",
    )
    .bind(session.school_id)
    .bind(session.id)
    .fetch_all(executor)
    .await
}
