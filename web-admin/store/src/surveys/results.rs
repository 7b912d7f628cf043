//! What a survey was answered: one indexed query for all answers, one for the attempts behind them.

use assessment::questionnaire::Answer;
use model::Moment;
use model::ids::{ResponseId, SessionId};
use model::survey::{Identity, Survey};
use sqlx::FromRow;

use crate::{Executor, Json, Result};

/// Sent answers.
#[derive(Clone, Debug, PartialEq, FromRow)]
pub struct SubmittedResponse {
    /// The response.
    pub id: ResponseId,
    /// `professional`, or the person's role.
    pub role: String,
    /// Name or pseudonym, as the survey allows.
    pub who: Option<String>,
    /// After which attempt.
    pub session_id: Option<SessionId>,
    /// Its exercise.
    pub exercise_id: Option<String>,
    /// Its device.
    pub device: Option<String>,
    /// Its simulator's version.
    pub simulator_version: Option<String>,
    /// Their pseudonym, which tells namesakes apart; none of an anonymous survey, and of somebody without an account.
    pub pseudonym: Option<String>,
    /// In which language.
    pub language: String,
    /// When; of an anonymous one the day.
    pub submitted_at: Moment,
    /// In the order of the instrument's items.
    pub answers: Json<Vec<Option<Answer>>>,
}

/// Every sent response of a survey, in no telling order.
pub async fn submitted(executor: impl Executor<'_>, survey: &Survey) -> Result<Vec<SubmittedResponse>> {
    let mut submitted: Vec<SubmittedResponse> = sqlx::query_as(
        "SELECT r.id, r.role, CASE $3 WHEN 'named' THEN coalesce(p.display_name, r.label)
             WHEN 'pseudonymous' THEN p.pseudonym END AS who,
           CASE WHEN $3 <> 'anonymous' THEN p.pseudonym END AS pseudonym, r.session_id, r.exercise_id, r.device, r.simulator_version, r.language, r.submitted_at, r.answers
         FROM survey_responses r LEFT JOIN people p ON p.school_id = r.school_id AND p.id = r.person_id
         WHERE r.school_id = $1 AND r.survey_id = $2 AND r.state = 'submitted'",
    )
    .bind(survey.school_id)
    .bind(survey.id)
    .bind(survey.identity)
    .fetch_all(executor)
    .await?;
    // Sorted by the statement, every response of the school would be read for its order.
    submitted.sort_by_key(|response| response.id);
    Ok(submitted)
}

/// A figure of the attempt behind a response.
#[derive(Clone, Debug, PartialEq, FromRow)]
pub struct ResponseMetric {
    /// The response.
    pub response_id: ResponseId,
    /// The figure.
    pub value: f64,
}

/// A metric of the attempts behind the sent responses; `score` is the grade that counts.
pub async fn attempts(executor: impl Executor<'_>, survey: &Survey, metric: &str) -> Result<Vec<ResponseMetric>> {
    if survey.identity == Identity::Anonymous {
        return Ok(Vec::new());
    }
    let statement = if metric == "score" {
        "SELECT r.id AS response_id, g.score AS value FROM survey_responses r
         JOIN grades g ON g.school_id = r.school_id AND g.session_id = r.session_id
         WHERE r.school_id = $1 AND r.survey_id = $2 AND r.state = 'submitted' AND $3 = 'score'"
    } else {
        "SELECT response_id, value FROM (
           SELECT r.id AS response_id, (SELECT max(m.value) FROM metrics m
             WHERE m.school_id = r.school_id AND m.session_id = r.session_id AND m.id = $3) AS value
           FROM survey_responses r WHERE r.school_id = $1 AND r.survey_id = $2 AND r.state = 'submitted') measured
         WHERE value IS NOT NULL"
    };
    sqlx::query_as(statement).bind(survey.school_id).bind(survey.id).bind(metric).fetch_all(executor).await
}

/// How many were asked and have answered.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, FromRow)]
pub struct ResponseCounts {
    /// Links that were made.
    pub links: i64,
    /// Of them, those by which answers were sent.
    pub links_answered: i64,
    /// Trainees of the cohorts, of a survey that is asked once.
    pub people: i64,
    /// Attempts at its exercises while it was open, at most 50 000, of a survey that is asked after each.
    pub attempts: i64,
    /// Answers that were sent by people of the school.
    pub people_answered: i64,
    /// Answers that were taken back.
    pub withdrawn: i64,
}

/// Counts a survey.
pub async fn counts(executor: impl Executor<'_>, survey: &Survey, now: Moment) -> Result<ResponseCounts> {
    sqlx::query_as(
        "SELECT
           coalesce(sum(r.role = 'professional'), 0) AS links,
           coalesce(sum(r.role = 'professional' AND r.state = 'submitted'), 0) AS links_answered,
           coalesce(sum(r.role <> 'professional' AND r.state = 'submitted'), 0) AS people_answered,
           coalesce(sum(r.state = 'withdrawn'), 0) AS withdrawn,
           (SELECT count(DISTINCT m.person_id) FROM survey_cohorts sc
             JOIN cohort_members m ON m.cohort_id = sc.cohort_id AND m.role = 'trainee'
             JOIN people p ON p.school_id = m.school_id AND p.id = m.person_id AND p.disabled_at IS NULL
             WHERE sc.survey_id = $2 AND $3 = 0) AS people,
           (SELECT count(*) FROM (
             SELECT 1 FROM (SELECT DISTINCT m.person_id FROM survey_cohorts sc
               JOIN cohort_members m ON m.cohort_id = sc.cohort_id AND m.role = 'trainee'
               WHERE sc.survey_id = $2 AND $3 = 1) asked
             CROSS JOIN sessions s
             WHERE s.school_id = $1 AND s.trainee_id = asked.person_id AND s.started_at >= $4
               AND s.started_at < $5 AND (NOT EXISTS (SELECT 1 FROM survey_exercises e WHERE e.survey_id = $2)
                 OR EXISTS (SELECT 1 FROM survey_exercises e WHERE e.survey_id = $2 AND e.exercise_id = s.exercise_id))
             UNION ALL
             SELECT 1 FROM survey_exercises e
             CROSS JOIN sessions s
             WHERE s.school_id = $1 AND s.exercise_id = e.exercise_id AND s.started_at >= $4
               AND s.started_at < $5 AND e.survey_id = $2 AND $3 = 1
               AND (SELECT role FROM people WHERE people.id = s.trainee_id) = 'trainee' AND NOT EXISTS (SELECT 1 FROM survey_cohorts sc WHERE sc.survey_id = $2)
             UNION ALL
             SELECT 1 FROM (SELECT 1 WHERE $3 = 1
               AND NOT EXISTS (SELECT 1 FROM survey_cohorts sc WHERE sc.survey_id = $2)
               AND NOT EXISTS (SELECT 1 FROM survey_exercises e WHERE e.survey_id = $2)) everybody
             CROSS JOIN sessions s
             WHERE s.school_id = $1 AND s.started_at >= $4 AND s.started_at < $5
               AND (SELECT role FROM people WHERE people.id = s.trainee_id) = 'trainee'
             LIMIT 50000) asked_after) AS attempts
         FROM survey_responses r WHERE r.school_id = $1 AND r.survey_id = $2",
    )
    .bind(survey.school_id)
    .bind(survey.id)
    .bind(survey.after_attempts)
    .bind(survey.opens_at)
    .bind(survey.closes_at.unwrap_or(now).min(now))
    .fetch_one(executor)
    .await
}

/// A theme of a comment.
#[derive(Clone, Debug, PartialEq, Eq, FromRow)]
pub struct Tag {
    /// The response.
    pub response_id: ResponseId,
    /// The item.
    pub item_id: String,
    /// The theme.
    pub tag: String,
}

/// Every theme of a survey's comments.
pub async fn tags(executor: impl Executor<'_>, survey: &Survey) -> Result<Vec<Tag>> {
    sqlx::query_as(
        "SELECT response_id, item_id, tag FROM survey_tags WHERE school_id = $1 AND survey_id = $2
         ORDER BY tag, response_id, item_id",
    )
    .bind(survey.school_id)
    .bind(survey.id)
    .fetch_all(executor)
    .await
}
