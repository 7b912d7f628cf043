//! Experts who consent to their attempts being shown to others, as part of a curve over at least
//! five experts.

use attempt::AttemptCurve;
use model::ids::{PersonId, SchoolId, SessionId};
use model::{Moment, PersonKey, new_id};
use sqlx::FromRow;

use crate::{Connection, Executor, Json, Result};

/// Maximum number of experts whose attempts are combined.
const MOST: u32 = 50;

/// A consent to be recorded.
#[derive(Clone, Copy, Debug)]
pub struct NewDeclaration<'a> {
    /// Text that the expert agreed to.
    pub wording: &'a str,
    /// How the consent was given.
    pub how: &'a str,
    /// Time of the consent.
    pub given_at: Moment,
    /// The expert, or the administrator who recorded the consent.
    pub recorded_by: PersonId,
}

/// A recorded consent, which may have been withdrawn.
#[derive(Clone, Debug, PartialEq, Eq, FromRow)]
pub struct Declaration {
    /// Text that the expert agreed to.
    pub wording: String,
    /// How the consent was given.
    pub how: String,
    /// Time of the consent.
    pub given_at: Moment,
    /// Name of the person who recorded it.
    pub recorded_by: String,
    /// Time of the withdrawal.
    pub withdrawn_at: Option<Moment>,
    /// Name of the person who recorded the withdrawal.
    pub withdrawn_by: Option<String>,
}

/// Records a person's consent. Returns false if they already have one that is not withdrawn.
///
/// # Errors
/// If one of the people belongs to another school, or the database fails.
pub async fn record_consent(
    writer: &mut Connection,
    PersonKey { school_id: school, person_id: person }: PersonKey,
    new: NewDeclaration<'_>,
    now: Moment,
) -> Result<bool> {
    sqlx::query(
        "INSERT INTO expert_declarations (id, school_id, person_id, wording, how, given_at, recorded_by)
         VALUES ($1, $2, $3, $4, $5, $6, $7) ON CONFLICT (school_id, person_id) WHERE withdrawn_at IS NULL DO NOTHING",
    )
    .bind(new_id(now))
    .bind(school)
    .bind(person)
    .bind(new.wording)
    .bind(new.how)
    .bind(new.given_at)
    .bind(new.recorded_by)
    .execute(writer)
    .await
    .map(|done| done.rows_affected() == 1)
}

/// Withdraws a person's consent and keeps its record. Returns false if they have given no consent.
pub async fn withdraw_consent(
    writer: &mut Connection,
    PersonKey { school_id: school, person_id: person }: PersonKey,
    by: PersonId,
    now: Moment,
) -> Result<bool> {
    sqlx::query(
        "UPDATE expert_declarations SET withdrawn_at = $3, withdrawn_by = $4
         WHERE school_id = $1 AND person_id = $2 AND withdrawn_at IS NULL",
    )
    .bind(school)
    .bind(person)
    .bind(now)
    .bind(by)
    .execute(writer)
    .await
    .map(|done| done.rows_affected() == 1)
}

/// Returns the time of a person's current consent, if there is one.
pub async fn list_consents(executor: impl Executor<'_>, school: SchoolId, person: PersonId) -> Result<Option<Moment>> {
    sqlx::query_scalar(
        "SELECT given_at FROM expert_declarations WHERE school_id = $1 AND person_id = $2 AND withdrawn_at IS NULL",
    )
    .bind(school)
    .bind(person)
    .fetch_optional(executor)
    .await
}

/// Returns all recorded consents of a person, latest first.
pub async fn declarations(executor: impl Executor<'_>, school: SchoolId, person: PersonId) -> Result<Vec<Declaration>> {
    sqlx::query_as(
        "SELECT d.wording, d.how, d.given_at, r.display_name AS recorded_by, d.withdrawn_at,
           w.display_name AS withdrawn_by
         FROM expert_declarations d
         JOIN people r ON r.school_id = d.school_id AND r.id = d.recorded_by
         LEFT JOIN people w ON w.school_id = d.school_id AND w.id = d.withdrawn_by
         WHERE d.school_id = $1 AND d.person_id = $2 ORDER BY d.given_at DESC, d.id DESC",
    )
    .bind(school)
    .bind(person)
    .fetch_all(executor)
    .await
}

/// Returns the curve of each consenting expert's latest passed attempt at an exercise.
pub async fn list_expert_curves(
    executor: impl Executor<'_>,
    school: SchoolId,
    exercise: &str,
) -> Result<Vec<AttemptCurve>> {
    let curves: Vec<Json<AttemptCurve>> = sqlx::query_scalar(
        "SELECT c.body FROM expert_declarations e
         JOIN session_curves c ON c.school_id = e.school_id AND c.session_id = (
           SELECT s.id FROM sessions s JOIN grades g ON g.school_id = s.school_id AND g.session_id = s.id
           WHERE s.school_id = e.school_id AND s.trainee_id = e.person_id AND s.exercise_id = $2 AND g.passed = 1
             AND s.uncounted IS NULL
           ORDER BY s.started_at DESC LIMIT 1)
         WHERE e.school_id = $1 AND e.withdrawn_at IS NULL ORDER BY e.person_id LIMIT $3 + 0",
    )
    .bind(school)
    .bind(exercise)
    .bind(i64::from(MOST))
    .fetch_all(executor)
    .await?;
    Ok(curves.into_iter().map(|json| json.0).collect())
}

/// Returns the latest passed attempt of each consenting expert at an exercise, except those of the
/// given person.
pub async fn list_expert_attempts(
    executor: impl Executor<'_>,
    PersonKey { school_id: school, person_id: person }: PersonKey,
    exercise: &str,
    most: u32,
) -> Result<Vec<SessionId>> {
    // The limit counts attempts, not declarations: most experts may never have tried this exercise.
    sqlx::query_scalar(
        "SELECT tried.newest FROM (
           SELECT e.person_id, (SELECT s.id FROM sessions s JOIN grades g ON g.school_id = s.school_id AND g.session_id = s.id
             WHERE s.school_id = e.school_id AND s.trainee_id = e.person_id AND s.exercise_id = $2 AND g.passed = 1
               AND s.uncounted IS NULL
             ORDER BY s.started_at DESC LIMIT 1) AS newest
           FROM expert_declarations e
           WHERE e.school_id = $1 AND e.withdrawn_at IS NULL AND e.person_id <> $3) tried
         WHERE tried.newest IS NOT NULL ORDER BY tried.person_id LIMIT $4 + 0",
    )
    .bind(school)
    .bind(exercise)
    .bind(person)
    .bind(i64::from(most))
    .fetch_all(executor)
    .await
}
