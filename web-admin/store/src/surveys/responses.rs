//! Responses, from a link or a beginning to sent answers.

use assessment::questionnaire::Answer;
use model::Moment;
use model::ids::{PersonId, ResponseId, SchoolId, SessionId, SurveyId};
use model::survey::{Identity, ResponseState};
use sqlx::FromRow;

use crate::{Connection, Executor, Json, Result};

/// A response.
#[derive(Clone, Debug, PartialEq, FromRow)]
pub struct SurveyResponse {
    /// Id: random.
    pub id: ResponseId,
    /// Its school.
    pub school_id: SchoolId,
    /// Its survey.
    pub survey_id: SurveyId,
    /// How far it has come.
    pub state: ResponseState,
    /// Whose it is, where it is a person's and may be known.
    pub person_id: Option<PersonId>,
    /// After which attempt.
    pub session_id: Option<SessionId>,
    /// In which language it is given.
    pub language: String,
    /// In the order of the instrument's items.
    pub answers: Json<Vec<Option<Answer>>>,
    /// Until when its link is good.
    pub expires_at: Option<Moment>,
}

/// A response to be added: a link, or the beginning of a person's.
#[derive(Clone, Debug)]
pub struct NewResponse<'a> {
    /// Its school.
    pub school_id: SchoolId,
    /// Its survey.
    pub survey_id: SurveyId,
    /// What is kept of the address by which it is given.
    pub token_sha256: [u8; 32],
    /// `professional`, or the person's role.
    pub role: &'a str,
    /// Whom a link is for.
    pub label: Option<&'a str>,
    /// The person.
    pub person_id: Option<PersonId>,
    /// After which attempt.
    pub session_id: Option<SessionId>,
    /// In which language.
    pub language: &'a str,
    /// When the person consented; none: a link that nobody has opened.
    pub consented_at: Option<Moment>,
    /// Until when a link is good.
    pub expires_at: Option<Moment>,
}

/// Adds a response without answers.
///
/// # Errors
/// When the person has begun one already, or the database fails.
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
    // A sorted id would tell the order in which people began.
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

/// The response of an address, in any school: the address names none.
pub async fn by_token(executor: impl Executor<'_>, token_sha256: &[u8; 32]) -> Result<Option<SurveyResponse>> {
    sqlx::query_as(
        "SELECT id, school_id, survey_id, state, person_id, session_id, language, answers, expires_at
         FROM survey_responses WHERE token_sha256 = $1",
    )
    .bind(&token_sha256[..])
    .fetch_optional(executor)
    .await
}

/// What a person has begun, or sent under their name or pseudonym.
pub async fn draft_of(
    executor: impl Executor<'_>,
    school: SchoolId,
    survey: SurveyId,
    person: PersonId,
    session: Option<SessionId>,
) -> Result<Option<SurveyResponse>> {
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

/// Gives a response another address; the one before leads nowhere then.
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

/// Stores the answers so far. False when they were sent or taken back in the meantime.
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

/// What is to be sent, and how much may be known of it.
#[derive(Clone, Copy, Debug)]
pub struct Submission<'a> {
    /// What.
    pub response: &'a SurveyResponse,
    /// Whether it leads to who gave it.
    pub identity: Identity,
    /// When; of an anonymous one only the day is kept.
    pub at: Moment,
}

/// Sends a response: notes who has answered, and cuts what would lead from an anonymous one to them. False when it was
/// sent or taken back in the meantime.
///
/// # Errors
/// When the person has answered already, or the database fails.
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

/// Forgets what was begun: a person's response goes, a link is as if it had never been opened.
pub async fn reset(writer: &mut Connection, response: &SurveyResponse) -> Result<()> {
    let statement = if response.person_id.is_some() {
        "DELETE FROM survey_responses WHERE school_id = $1 AND id = $2 AND state = 'begun'"
    } else {
        "UPDATE survey_responses SET state = 'invited', answers = '[]', consented_at = NULL
         WHERE school_id = $1 AND id = $2 AND state = 'begun'"
    };
    sqlx::query(statement).bind(response.school_id).bind(response.id).execute(writer).await.map(drop)
}

/// Takes sent answers back: what was said, and the themes found in it, are gone. False when there was nothing sent.
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
