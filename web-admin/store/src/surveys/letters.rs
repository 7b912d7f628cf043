//! Letters with a survey link to people without an account.

use model::ids::{LetterId, ResponseId, SchoolId};
use model::letters::mail::{LetterDelivery, SurveyLetter};
use model::surveys::Survey;
use model::{Moment, count_u32};

use crate::{Connection, Executor, Result};

/// Queues a letter. Returns false if one was already queued for this address.
pub async fn queue_survey_letter(
    writer: &mut Connection,
    survey: &Survey,
    name: &str,
    email: &str,
    now: Moment,
) -> Result<bool> {
    sqlx::query(
        "INSERT INTO survey_letters (id, school_id, survey_id, name, email, next_run_at) VALUES ($1, $2, $3, $4, $5, $6)
         ON CONFLICT (survey_id, email) DO NOTHING",
    )
    .bind(LetterId::made_at(now))
    .bind(survey.school_id)
    .bind(survey.id)
    .bind(name)
    .bind(email)
    .bind(now)
    .execute(writer)
    .await
    .map(|done| done.rows_affected() == 1)
}

/// Returns the number of letters of a school queued since a time. Their ids contain the time; the
/// unary plus keeps SQLite from using the index by school instead of the ids.
pub async fn queued_since(executor: impl Executor<'_>, school: SchoolId, since: Moment) -> Result<u32> {
    let milliseconds = since.duration_since(Moment::from_micros(0)).as_millis();
    let first = LetterId::from_u128(milliseconds << 80);
    sqlx::query_scalar("SELECT count(*) FROM survey_letters WHERE +school_id = $1 AND id >= $2")
        .bind(school)
        .bind(first)
        .fetch_one(executor)
        .await
        .map(count_u32::<i64>)
}

/// Returns the letters that are due, oldest first.
pub async fn list_due_survey_letters(
    executor: impl Executor<'_>,
    now: Moment,
    limit: u32,
) -> Result<Vec<SurveyLetter>> {
    sqlx::query_as(
        "SELECT l.id, l.school_id, l.survey_id, l.name, l.email, l.response_id, l.tries, s.name AS school
         FROM survey_letters l JOIN schools s ON s.id = l.school_id
         WHERE l.next_run_at <= $1 ORDER BY l.next_run_at LIMIT $2 + 0",
    )
    .bind(now)
    .bind(i64::from(limit))
    .fetch_all(executor)
    .await
}

/// Claims a letter before it is sent, so that it is never sent twice automatically, even after a
/// crash. Returns false if another worker has claimed it.
pub async fn claim_survey_letter(writer: &mut Connection, letter: &SurveyLetter, response: ResponseId) -> Result<bool> {
    sqlx::query(
        "UPDATE survey_letters SET next_run_at = NULL, tries = tries + 1, error = NULL, response_id = $3
         WHERE school_id = $1 AND id = $2 AND next_run_at IS NOT NULL",
    )
    .bind(letter.school_id)
    .bind(letter.id)
    .bind(response)
    .execute(writer)
    .await
    .map(|done| done.rows_affected() == 1)
}

/// Records that a letter was sent, and removes its reference to the response.
pub async fn mark_letter_sent(writer: &mut Connection, letter: &SurveyLetter, now: Moment) -> Result<()> {
    sqlx::query("UPDATE survey_letters SET sent_at = $3, response_id = NULL WHERE school_id = $1 AND id = $2")
        .bind(letter.school_id)
        .bind(letter.id)
        .bind(now)
        .execute(writer)
        .await
        .map(drop)
}

/// Records that a letter could not be sent, and when to retry; `None` means that it is not retried.
pub async fn mark_letter_failed(
    writer: &mut Connection,
    letter: &SurveyLetter,
    error: &str,
    again: Option<Moment>,
) -> Result<()> {
    sqlx::query("UPDATE survey_letters SET error = $3, next_run_at = $4 WHERE school_id = $1 AND id = $2")
        .bind(letter.school_id)
        .bind(letter.id)
        .bind(error)
        .bind(again)
        .execute(writer)
        .await
        .map(drop)
}

/// Returns the status of a survey's letters, sorted by address.
pub async fn list_deliveries(executor: impl Executor<'_>, survey: &Survey) -> Result<Vec<LetterDelivery>> {
    sqlx::query_as(
        "SELECT name, email, sent_at, error, next_run_at FROM survey_letters
         WHERE school_id = $1 AND survey_id = $2 ORDER BY email",
    )
    .bind(survey.school_id)
    .bind(survey.id)
    .fetch_all(executor)
    .await
}
