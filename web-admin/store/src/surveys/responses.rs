//! Responses, from the invitation to the submitted answers.

use assessment::questionnaire::Answer;
use model::Moment;
use model::ids::{PersonId, ResponseId, SchoolId, SessionId, SurveyId};
use model::surveys::{Identity, ResponseState};
use sqlx::FromRow;

use crate::{Connection, Executor, Json, Result};

/// A response.
#[derive(Clone, Debug, PartialEq, FromRow)]
pub struct SurveyResponse {
    /// Random id.
    pub id: ResponseId,
    /// School.
    pub school_id: SchoolId,
    /// Survey.
    pub survey_id: SurveyId,
    /// State.
    pub state: ResponseState,
    /// Person who responds, if it is a person of the school and may be known.
    pub person_id: Option<PersonId>,
    /// Attempt that it refers to.
    pub session_id: Option<SessionId>,
    /// Language of the response.
    pub language: String,
    /// Answers, in the order of the instrument's items.
    pub answers: Json<Vec<Option<Answer>>>,
    /// Expiry time of its link.
    pub expires_at: Option<Moment>,
}

/// A response to be stored: a link, or the start of a person's response.
#[derive(Clone, Debug)]
pub struct NewResponse<'a> {
    /// School.
    pub school_id: SchoolId,
    /// Survey.
    pub survey_id: SurveyId,
    /// SHA-256 of the token in its URL.
    pub token_sha256: [u8; 32],
    /// `professional`, or the person's role.
    pub role: &'a str,
    /// Recipient of a link.
    pub label: Option<&'a str>,
    /// Person who responds.
    pub person_id: Option<PersonId>,
    /// Attempt that it refers to.
    pub session_id: Option<SessionId>,
    /// Language of the response.
    pub language: &'a str,
    /// Time of consent; `None` for a link that was not opened.
    pub consented_at: Option<Moment>,
    /// Expiry time of a link.
    pub expires_at: Option<Moment>,
}

/// Stores a response without answers.
///
/// # Errors
/// If the person has already started one, or the database fails.
pub async fn add(writer: &mut Connection, new: &NewResponse<'_>) -> Result<ResponseId> {
    let state = if new.consented_at.is_some() { ResponseState::Begun } else { ResponseState::Invited };
    sqlx::query_scalar(
        "INSERT INTO survey_responses (id, school_id, survey_id, token_sha256, state, role, label, person_id, session_id,
           exercise_id, device, simulator_version, language, answers, consented_at, expires_at)
         VALUES ($1, $2, $3, $4, $5, $6, $7, $8, $9,
           (SELECT exercise_id FROM sessions WHERE school_id = $2 AND id = $9),
           (SELECT device FROM sessions WHERE school_id = $2 AND id = $9),
           (SELECT simulator_version FROM sessions WHERE school_id = $2 AND id = $9), $10, '[]', $11, $12)
         RETURNING id",
    )
    // A sequential id would reveal the order in which people started.
    .bind(ResponseId::random())
    .bind(new.school_id)
    .bind(new.survey_id)
    .bind(&new.token_sha256[..])
    .bind(state)
    .bind(new.role)
    .bind(new.label)
    .bind(new.person_id)
    .bind(new.session_id)
    .bind(new.language)
    .bind(new.consented_at)
    .bind(new.expires_at)
    .fetch_one(writer)
    .await
}

/// Returns the response with this token, in any school: the URL contains no school.
pub async fn by_token(executor: impl Executor<'_>, token_sha256: &[u8; 32]) -> Result<Option<SurveyResponse>> {
    sqlx::query_as(
        "SELECT id, school_id, survey_id, state, person_id, session_id, language, answers, expires_at
         FROM survey_responses WHERE token_sha256 = $1",
    )
    .bind(&token_sha256[..])
    .fetch_optional(executor)
    .await
}

/// Returns the response that a person has started, or submitted under their name or pseudonym.
pub async fn draft_of(
    executor: impl Executor<'_>,
    school: SchoolId,
    survey: SurveyId,
    person: PersonId,
    session: Option<SessionId>,
) -> Result<Option<SurveyResponse>> {
    // The unary plus keeps SQLite from using an index by school.
    sqlx::query_as(
        "SELECT id, school_id, survey_id, state, person_id, session_id, language, answers, expires_at
         FROM survey_responses WHERE +school_id = $1 AND survey_id = $2 AND person_id = $3
           AND session_id IS NOT DISTINCT FROM $4",
    )
    .bind(school)
    .bind(survey)
    .bind(person)
    .bind(session)
    .fetch_optional(executor)
    .await
}

/// Replaces the token of a response, which invalidates the previous one.
pub async fn set_token(
    writer: &mut Connection,
    school: SchoolId,
    response: ResponseId,
    token_sha256: &[u8; 32],
) -> Result<()> {
    sqlx::query("UPDATE survey_responses SET token_sha256 = $3 WHERE school_id = $1 AND id = $2")
        .bind(school)
        .bind(response)
        .bind(&token_sha256[..])
        .execute(writer)
        .await
        .map(drop)
}

/// Stores the answers so far. Returns false if the response was submitted or withdrawn in the
/// meantime.
pub async fn put_answers(writer: &mut Connection, response: &SurveyResponse, now: Moment) -> Result<bool> {
    sqlx::query(
        "UPDATE survey_responses SET answers = $3, language = $4, state = 'begun',
           consented_at = coalesce(consented_at, $5)
         WHERE school_id = $1 AND id = $2 AND state IN ('invited', 'begun')",
    )
    .bind(response.school_id)
    .bind(response.id)
    .bind(&response.answers)
    .bind(&response.language)
    .bind(now)
    .execute(writer)
    .await
    .map(|done| done.rows_affected() == 1)
}

/// A response to be submitted.
#[derive(Clone, Copy, Debug)]
pub struct Submission<'a> {
    /// What.
    pub response: &'a SurveyResponse,
    /// Identity to be kept with it.
    pub identity: Identity,
    /// Time of submission; for an anonymous response only the day is stored.
    pub at: Moment,
}

/// Submits a response and records the participation. Removes everything that identifies the
/// respondent from an anonymous response. Returns false if it was submitted or withdrawn in the
/// meantime.
///
/// # Errors
/// If the person has already answered, or the database fails.
pub async fn submit(writer: &mut Connection, Submission { response, identity, at }: Submission<'_>) -> Result<bool> {
    const DAY_US: i64 = 86_400_000_000;
    if let Some(person) = response.person_id {
        sqlx::query(
            "INSERT INTO survey_participations (school_id, survey_id, person_id, session_id) VALUES ($1, $2, $3, $4)",
        )
        .bind(response.school_id)
        .bind(response.survey_id)
        .bind(person)
        .bind(response.session_id)
        .execute(&mut *writer)
        .await?;
    }
    let anonymous = identity == Identity::Anonymous;
    let day = |us: i64| us - us.rem_euclid(DAY_US);
    let kept = if anonymous { Moment::from_micros(day(at.micros())) } else { at };
    sqlx::query(
        "UPDATE survey_responses SET state = 'submitted', submitted_at = $3,
           consented_at = CASE WHEN $4 THEN $3 ELSE consented_at END,
           person_id = CASE WHEN $4 THEN NULL ELSE person_id END,
           session_id = CASE WHEN $4 THEN NULL ELSE session_id END,
           label = CASE WHEN $4 THEN NULL ELSE label END,
           expires_at = CASE WHEN $4 THEN NULL ELSE expires_at END
         WHERE school_id = $1 AND id = $2 AND state = 'begun'",
    )
    .bind(response.school_id)
    .bind(response.id)
    .bind(kept)
    .bind(anonymous)
    .execute(writer)
    .await
    .map(|done| done.rows_affected() == 1)
}

/// Discards a started response: a person's response is deleted, a link becomes unopened again.
pub async fn reset(writer: &mut Connection, response: &SurveyResponse) -> Result<()> {
    let statement = if response.person_id.is_some() {
        "DELETE FROM survey_responses WHERE school_id = $1 AND id = $2 AND state = 'begun'"
    } else {
        "UPDATE survey_responses SET state = 'invited', answers = '[]', consented_at = NULL
         WHERE school_id = $1 AND id = $2 AND state = 'begun'"
    };
    sqlx::query(statement).bind(response.school_id).bind(response.id).execute(writer).await.map(drop)
}

/// Withdraws a submitted response: deletes its answers and tags. Returns false if it was not
/// submitted.
pub async fn withdraw(writer: &mut Connection, response: &SurveyResponse) -> Result<bool> {
    sqlx::query("DELETE FROM survey_tags WHERE school_id = $1 AND response_id = $2")
        .bind(response.school_id)
        .bind(response.id)
        .execute(&mut *writer)
        .await?;
    sqlx::query(
        "UPDATE survey_responses SET state = 'withdrawn', answers = '[]', submitted_at = NULL, consented_at = NULL,
           label = NULL, person_id = NULL, session_id = NULL
         WHERE school_id = $1 AND id = $2 AND state = 'submitted'",
    )
    .bind(response.school_id)
    .bind(response.id)
    .execute(writer)
    .await
    .map(|done| done.rows_affected() == 1)
}
