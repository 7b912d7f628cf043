//! The attempts of a re-grading: what each was and would be.

use assessment::Assessment;
use model::ids::{RegradingId, SchoolId, ScoreId, SessionId};
use model::regrading::{OutcomeCount, RegradingLine, RegradingOutcome};
use sqlx::FromRow;

use super::Regrading;
use crate::engine::twin;
use crate::{Connection, Executor, Json, Result};

/// What finds a line.
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

/// What was found out about an attempt.
#[derive(Clone, Debug, PartialEq)]
pub struct RegradedAttempt {
    /// What becomes of it.
    pub outcome: RegradingOutcome,
    /// How it is judged, where it gets a score.
    pub assessment: Option<Assessment>,
    /// Why it cannot be judged.
    pub why: Option<String>,
}

/// An attempt whose score is to be added.
#[derive(Clone, Debug, FromRow)]
pub struct ToGrade {
    /// The attempt.
    pub session_id: SessionId,
    /// Its score.
    pub assessment: Json<Assessment>,
    /// The computed score before, 0–100.
    pub before: f64,
    /// It still has the score that was looked at.
    pub current: bool,
}

/// The next attempts that wait to be looked at.
pub async fn to_look(executor: impl Executor<'_>, regrading: RegradingId, most: u32) -> Result<Vec<SessionId>> {
    sqlx::query_scalar(
        "SELECT session_id FROM regrading_lines WHERE regrading_id = $1 AND outcome IS NULL ORDER BY session_id LIMIT $2 + 0",
    )
    .bind(regrading)
    .bind(i64::from(most))
    .fetch_all(executor)
    .await
}

/// Keeps what was found out about an attempt.
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

/// The next attempts whose scores are to be added.
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

/// Notes the score that an attempt was given; none where somebody was quicker.
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

/// How many attempts there are of each outcome, and their scores before and after. Reads every line.
///
/// # Errors
/// When an attempt waits to be looked at, or the database fails.
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

/// How many attempts were looked at, and how many there are.
pub async fn looked_at(executor: impl Executor<'_>, regrading: RegradingId) -> Result<(i64, i64)> {
    sqlx::query_as("SELECT count(outcome), count(*) FROM regrading_lines WHERE regrading_id = $1")
        .bind(regrading)
        .fetch_one(executor)
        .await
}

/// How many scores are yet to be added.
pub async fn left(executor: impl Executor<'_>, regrading: RegradingId) -> Result<i64> {
    sqlx::query_scalar("SELECT count(*) FROM regrading_lines WHERE regrading_id = $1 AND assessment IS NOT NULL")
        .bind(regrading)
        .fetch_one(executor)
        .await
}

/// Lines of some outcomes after one attempt, by its id, so many at most.
pub async fn lines(
    executor: impl Executor<'_>,
    regrading: &Regrading,
    outcomes: &[RegradingOutcome],
    after: SessionId,
    most: u32,
) -> Result<Vec<RegradingLine>> {
    // A page of each outcome is put in order: however many attempts there are, no more are read. Cross joins keep this order.
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
