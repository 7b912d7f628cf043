//! The grade that counts: the newest computed score, or what somebody has put in its place. Every grading stays.

use model::ids::{OverrideId, PersonId, SessionId};
use model::{Moment, SessionKey};
use sqlx::FromRow;

use super::{Connection, Executor, Result, practice};

/// The grade that counts.
#[derive(Clone, Copy, Debug, PartialEq, FromRow)]
pub struct Grade {
    /// 0–100.
    pub score: f64,
    /// It counts as a pass.
    pub passed: bool,
    /// Somebody has put it in place of the computed score.
    pub overridden: bool,
}

/// What somebody puts in place of a computed score, or that the computed score counts again.
#[derive(Clone, Debug, PartialEq)]
pub struct NewOverride<'a> {
    /// 0–100, and whether it counts as a pass; absent where the computed score is to count again.
    pub grade: Option<(f64, bool)>,
    /// Why.
    pub reason: &'a str,
    /// Who.
    pub made_by: PersonId,
}

/// An override as it was made.
#[derive(Clone, Debug, PartialEq, FromRow)]
pub struct OverrideRecord {
    /// 0–100; absent where it says that the computed score counts again.
    pub score: Option<f64>,
    /// It counts as a pass.
    pub passed: Option<bool>,
    /// Why.
    pub reason: String,
    /// The name of whoever made it.
    pub by: String,
    /// When.
    pub made_at: Moment,
}

/// The grade of an attempt that counts; none before it is scored.
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

/// Adds an override; earlier ones and every computed score stay.
///
/// # Errors
/// When the attempt or the person is of another school, the reason is empty, or the database fails.
pub async fn put_override(
    writer: &mut Connection,
    session: SessionKey,
    new: &NewOverride<'_>,
    now: Moment,
) -> Result<()> {
    sqlx::query(
        "INSERT INTO score_overrides (id, school_id, session_id, score, passed, reason, made_by, made_at)
         VALUES ($1, $2, $3, $4, $5, $6, $7, $8)",
    )
    .bind(OverrideId::made_at(now))
    .bind(session.school_id)
    .bind(session.id)
    .bind(new.grade.map(|(score, _)| score))
    .bind(new.grade.map(|(_, passed)| passed))
    .bind(new.reason)
    .bind(new.made_by)
    .bind(now)
    .execute(&mut *writer)
    .await?;
    practice::refresh_practice(writer, session).await
}

/// Attempts whose grade nobody has overridden and that is not that of the score it names.
pub async fn list_strayed_grades(executor: impl Executor<'_>) -> Result<Vec<SessionId>> {
    sqlx::query_scalar(
        "SELECT g.session_id FROM grades g JOIN scores c ON c.id = g.score_id
         WHERE g.override_id IS NULL AND (g.score <> c.score OR g.passed <> c.passed)",
    )
    .fetch_all(executor)
    .await
}

/// Every override of an attempt, in the order in which they were made.
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
