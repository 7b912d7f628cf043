//! The attempts of a re-grading: previous and new scores.

use assessment::Assessment;
use model::ids::{RegradingId, SchoolId, ScoreId, SessionId};
use model::scoring::regrading::{OutcomeCount, RegradingLine, RegradingOutcome};
use sqlx::FromRow;

use super::Regrading;
use crate::engine::twin;
use crate::{Connection, Executor, Json, Result};

/// Key of a line.
#[derive(Clone, Copy)]
struct LineKey {
    school_id: SchoolId,
    regrading_id: RegradingId,
    session_id: SessionId,
}

impl Regrading {
    const fn key(&self, session: SessionId) -> LineKey {
        LineKey { school_id: self.school_id, regrading_id: self.id, session_id: session }
    }
}

/// Result of re-grading one attempt.
#[derive(Clone, Debug, PartialEq)]
pub struct RegradedAttempt {
    /// Outcome.
    pub outcome: RegradingOutcome,
    /// New assessment, if there is one.
    pub assessment: Option<Assessment>,
    /// Reason why it cannot be graded.
    pub why: Option<String>,
}

/// An attempt whose new score is to be stored.
#[derive(Clone, Debug, FromRow)]
pub struct ToGrade {
    /// The attempt.
    pub session_id: SessionId,
    /// New assessment.
    pub assessment: Json<Assessment>,
    /// Previous computed score, 0–100.
    pub before: f64,
    /// The attempt still has the score that was compared.
    pub current: bool,
}

/// Returns the next attempts to be compared.
pub async fn to_look(executor: impl Executor<'_>, regrading: RegradingId, most: u32) -> Result<Vec<SessionId>> {
    sqlx::query_scalar(
        "SELECT session_id FROM regrading_lines WHERE regrading_id = $1 AND outcome IS NULL ORDER BY session_id LIMIT $2 + 0",
    )
    .bind(regrading)
    .bind(i64::from(most))
    .fetch_all(executor)
    .await
}

/// Stores the result of comparing one attempt.
pub async fn found(
    writer: &mut Connection,
    regrading: &Regrading,
    session: SessionId,
    found: &RegradedAttempt,
) -> Result<()> {
    let key = regrading.key(session);
    sqlx::query(
        "UPDATE regrading_lines SET outcome = $4, after = $5, passed_after = $6, assessment = $7, why = $8
         WHERE school_id = $1 AND regrading_id = $2 AND session_id = $3",
    )
    .bind(key.school_id)
    .bind(key.regrading_id)
    .bind(key.session_id)
    .bind(found.outcome)
    .bind(found.assessment.as_ref().map(|assessment| assessment.score))
    .bind(found.assessment.as_ref().map(|assessment| assessment.passed))
    .bind(found.assessment.as_ref().map(Json))
    .bind(&found.why)
    .execute(writer)
    .await
    .map(drop)
}

/// Returns the next attempts whose new scores are to be stored.
pub async fn to_grade(executor: impl Executor<'_>, regrading: RegradingId, most: u32) -> Result<Vec<ToGrade>> {
    sqlx::query_as(
        "SELECT l.session_id, l.assessment, l.before, g.score_id = l.score_id AS current FROM regrading_lines l
         JOIN grades g ON g.school_id = l.school_id AND g.session_id = l.session_id
         WHERE l.regrading_id = $1 AND l.assessment IS NOT NULL ORDER BY l.session_id LIMIT $2 + 0",
    )
    .bind(regrading)
    .bind(i64::from(most))
    .fetch_all(executor)
    .await
}

/// Records the new score of an attempt; `None` if another change to its score came first.
pub async fn graded(
    writer: &mut Connection,
    regrading: &Regrading,
    session: SessionId,
    score: Option<ScoreId>,
) -> Result<()> {
    let key = regrading.key(session);
    sqlx::query(
        "UPDATE regrading_lines SET assessment = NULL, new_score_id = $4,
           outcome = CASE WHEN $4 IS NULL THEN 'overtaken' ELSE outcome END
         WHERE school_id = $1 AND regrading_id = $2 AND session_id = $3",
    )
    .bind(key.school_id)
    .bind(key.regrading_id)
    .bind(key.session_id)
    .bind(score)
    .execute(writer)
    .await
    .map(drop)
}

/// Returns the number of attempts and the sums of scores before and after, by outcome. Reads all
/// lines.
///
/// # Errors
/// If an attempt has not been compared yet, or the database fails.
pub(super) async fn sum_up(executor: impl Executor<'_>, regrading: &Regrading) -> Result<Vec<OutcomeCount>> {
    sqlx::query_as(
        "SELECT outcome, count(*) AS attempts, sum(before) AS before, sum(coalesce(after, before)) AS after
         FROM regrading_lines WHERE school_id = $1 AND regrading_id = $2 GROUP BY outcome ORDER BY outcome NULLS FIRST",
    )
    .bind(regrading.school_id)
    .bind(regrading.id)
    .fetch_all(executor)
    .await
}

/// Returns the number of compared attempts and the number of all attempts.
pub async fn looked_at(executor: impl Executor<'_>, regrading: RegradingId) -> Result<(i64, i64)> {
    sqlx::query_as("SELECT count(outcome), count(*) FROM regrading_lines WHERE regrading_id = $1")
        .bind(regrading)
        .fetch_one(executor)
        .await
}

/// Returns the number of scores still to be stored.
pub async fn left(executor: impl Executor<'_>, regrading: RegradingId) -> Result<i64> {
    sqlx::query_scalar("SELECT count(*) FROM regrading_lines WHERE regrading_id = $1 AND assessment IS NOT NULL")
        .bind(regrading)
        .fetch_one(executor)
        .await
}

/// Returns the lines with some outcomes, in order of their ids, starting after `after`.
pub async fn lines(
    executor: impl Executor<'_>,
    regrading: &Regrading,
    outcomes: &[RegradingOutcome],
    after: SessionId,
    most: u32,
) -> Result<Vec<RegradingLine>> {
    // Each outcome contributes one sorted page, so that the number of rows read does not depend on
    // the number of attempts. The cross joins fix the order of the join.
    sqlx::query_as(twin!(
            executor,
            "SELECT l.session_id, s.started_at, p.display_name AS trainee, l.before, l.passed_before, l.after, l.passed_after,
               o.score AS overridden, l.outcome, l.why
             FROM json_each($3) wanted
             CROSS JOIN regrading_lines l
             CROSS JOIN sessions s
             CROSS JOIN people p
             LEFT JOIN score_overrides o ON o.id = l.override_id WHERE p.school_id = s.school_id AND p.id = s.trainee_id
             AND s.school_id = l.school_id AND s.id = l.session_id AND l.school_id = $1 AND l.regrading_id = $2
             AND l.session_id IN (
               SELECT session_id FROM regrading_lines
               WHERE regrading_id = $2 AND outcome = wanted.value AND session_id > $4 ORDER BY session_id LIMIT $5 + 0)
             ORDER BY l.session_id LIMIT $5 + 0",
            "SELECT l.session_id, s.started_at, p.display_name AS trainee, l.before, l.passed_before, l.after, l.passed_after,
               o.score AS overridden, l.outcome, l.why
             FROM json_each($3) wanted
             CROSS JOIN LATERAL (
               SELECT * FROM regrading_lines
               WHERE school_id = $1 AND regrading_id = $2 AND outcome = wanted.value AND session_id > $4
               ORDER BY session_id LIMIT $5 + 0) l
             CROSS JOIN sessions s
             CROSS JOIN people p
             LEFT JOIN score_overrides o ON o.id = l.override_id WHERE p.school_id = s.school_id AND p.id = s.trainee_id
             AND s.school_id = l.school_id AND s.id = l.session_id
             ORDER BY l.session_id LIMIT $5 + 0",
        ))
    .bind(regrading.school_id)
    .bind(regrading.id)
    .bind(Json(outcomes))
    .bind(after)
    .bind(i64::from(most))
    .fetch_all(executor)
    .await
}
