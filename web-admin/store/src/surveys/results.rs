//! Results of a survey: one indexed query for all answers, one for the attempts that they refer to.

use assessment::questionnaire::Answer;
use model::Moment;
use model::ids::{ResponseId, SessionId};
use model::surveys::{Identity, Survey};
use sqlx::FromRow;

use crate::{Executor, Json, Result};

/// A submitted response.
#[derive(Clone, Debug, PartialEq, FromRow)]
pub struct SubmittedResponse {
    /// Id of the response.
    pub id: ResponseId,
    /// `professional`, or the person's role.
    pub role: String,
    /// Name or pseudonym, as the survey permits.
    pub who: Option<String>,
    /// Attempt that it refers to.
    pub session_id: Option<SessionId>,
    /// Exercise of the attempt.
    pub exercise_id: Option<String>,
    /// Device of the attempt.
    pub device: Option<String>,
    /// Simulator version of the attempt.
    pub simulator_version: Option<String>,
    /// Pseudonym, which distinguishes people with equal names; `None` in an anonymous survey and
    /// for people without an account.
    pub pseudonym: Option<String>,
    /// Language of the response.
    pub language: String,
    /// Time of submission; for an anonymous response only the day.
    pub submitted_at: Moment,
    /// Answers, in the order of the instrument's items.
    pub answers: Json<Vec<Option<Answer>>>,
}

/// Returns the submitted responses of a survey, sorted by their random ids.
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
    // With ORDER BY, the engine would read all responses of the school in the order of their ids.
    submitted.sort_by_key(|response| response.id);
    Ok(submitted)
}

/// Value of a metric for the attempt of a response.
#[derive(Clone, Debug, PartialEq, FromRow)]
pub struct ResponseMetric {
    /// Id of the response.
    pub response_id: ResponseId,
    /// Value, in the metric's unit.
    pub value: f64,
}

/// Returns a metric of the attempts that the submitted responses refer to; `score` is the effective
/// score.
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

/// Counts of invitations and responses.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, FromRow)]
pub struct ResponseCounts {
    /// Number of links.
    pub links: i64,
    /// Number of responses submitted through links.
    pub links_answered: i64,
    /// Number of trainees in the cohorts, for a survey that is asked once.
    pub people: i64,
    /// Number of attempts at its exercises while it was open, at most 50 000, for a survey that is
    /// asked after each attempt.
    pub attempts: i64,
    /// Number of responses submitted by people of the school.
    pub people_answered: i64,
    /// Number of withdrawn responses.
    pub withdrawn: i64,
}

/// Returns the counts of a survey.
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

/// A tag of a comment.
#[derive(Clone, Debug, PartialEq, Eq, FromRow)]
pub struct Tag {
    /// Id of the response.
    pub response_id: ResponseId,
    /// Id of the item.
    pub item_id: String,
    /// The tag.
    pub tag: String,
}

/// Returns all tags of a survey's comments.
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
