//! Everything held about a person, for themselves.

mod access;
mod said;

pub use access::{AccessFacts, TokenFacts};
pub use said::{AnswerFacts, AssignmentFacts, CommentFacts, MarksFacts, RatingFacts};

use serde::Serialize;
use sqlx::types::Json;
use sqlx::{FromRow, SqlitePool};
use uuid::Uuid;

use super::second_factors::PersonKey;
use super::{ExactNumber, Result};
use crate::domain::{Moment, Role};

/// Everything held about a person.
#[derive(Clone, Debug, Serialize)]
pub struct Export {
    /// Who.
    pub person: PersonFacts,
    /// Cohorts, by name.
    pub cohorts: Vec<String>,
    /// Attempts, in order of time.
    pub attempts: Vec<AttemptFacts>,
    /// What was measured in them.
    pub metrics: Vec<MetricFacts>,
    /// How they were graded, every time.
    pub scores: Vec<ScoreFacts>,
    /// What was said about their attempts, by them and others.
    pub comments: Vec<CommentFacts>,
    /// What was assigned to them.
    pub assignments: Vec<AssignmentFacts>,
    /// What raters gave their attempts, without the raters.
    pub ratings: Vec<RatingFacts>,
    /// The pops that they marked, and how near they came.
    pub marked_pops: Vec<MarksFacts>,
    /// What they answered in surveys that are not anonymous.
    pub survey_answers: Vec<AnswerFacts>,
    /// What lets them in besides their password.
    pub access: AccessFacts,
    /// What they did, and what was done with their account.
    pub log: Vec<LogFacts>,
}

/// Who somebody is.
#[derive(Clone, Debug, Serialize, FromRow)]
pub struct PersonFacts {
    id: Uuid,
    school: String,
    role: Role,
    email: String,
    display_name: String,
    pseudonym: String,
    registrar_id: Option<String>,
    language: Option<String>,
    created_at: Moment,
}

/// An attempt, with what its recording is and where it is had.
#[derive(Clone, Debug, Serialize, FromRow)]
pub struct AttemptFacts {
    session_id: Uuid,
    exercise_id: String,
    started_at: Moment,
    received_at: Moment,
    duration_s: f64,
    device: String,
    simulator_version: String,
    state: String,
    recording_sha256: String,
    recording_size_bytes: i64,
    recording: String,
}

/// A metric of an attempt.
#[derive(Clone, Debug, Serialize, FromRow)]
pub struct MetricFacts {
    session_id: Uuid,
    id: String,
    version: i64,
    value: Option<f64>,
    unit: String,
}

/// A grading of an attempt.
#[derive(Clone, Debug, Serialize, FromRow)]
pub struct ScoreFacts {
    session_id: Uuid,
    score: f64,
    passed: bool,
    rubric_sha256: String,
    computed_at: Moment,
}

/// An entry of the audit log.
#[derive(Clone, Debug, Serialize, FromRow)]
pub struct LogFacts {
    at: Moment,
    action: String,
    object: String,
}

/// Gathers it. `None` when there is no such person.
///
/// # Errors
/// When the database fails.
pub async fn of_person(reader: &SqlitePool, school: Uuid, person: Uuid) -> Result<Option<Export>> {
    let facts: Option<PersonFacts> = sqlx::query_as(
        "SELECT p.id, s.name AS school, p.role, p.email, p.display_name, p.pseudonym, p.registrar_id, p.language, p.created_at
         FROM people p JOIN schools s ON s.id = p.school_id WHERE p.school_id = $1 AND p.id = $2",
    )
    .bind(school)
    .bind(person)
    .fetch_optional(reader)
    .await?;
    let Some(facts) = facts else { return Ok(None) };
    let cohorts = sqlx::query_scalar(
        "SELECT c.name FROM cohort_members m JOIN cohorts c ON c.id = m.cohort_id
         WHERE m.school_id = $1 AND m.person_id = $2 ORDER BY c.name",
    );
    let attempts = sqlx::query_as(
        "SELECT id AS session_id, exercise_id, started_at, received_at, duration_s, device, simulator_version, state,
           recording_sha256, recording_size AS recording_size_bytes, '' AS recording
         FROM sessions WHERE school_id = $1 AND trainee_id = $2 ORDER BY started_at, id",
    );
    let scores = sqlx::query_as(
        "SELECT c.session_id, c.score, c.passed, c.rubric_sha256, c.computed_at FROM sessions s
         CROSS JOIN scores c ON c.school_id = s.school_id AND c.session_id = s.id
         WHERE s.school_id = $1 AND s.trainee_id = $2 ORDER BY s.started_at, s.id, c.rowid",
    );
    let mut attempts: Vec<AttemptFacts> = attempts.bind(school).bind(person).fetch_all(reader).await?;
    for attempt in &mut attempts {
        attempt.recording = format!("/api/v1/sessions/{}/recording", attempt.session_id);
    }
    Ok(Some(Export {
        cohorts: cohorts.bind(school).bind(person).fetch_all(reader).await?,
        attempts,
        metrics: metrics(reader, school, person).await?,
        scores: scores.bind(school).bind(person).fetch_all(reader).await?,
        comments: said::comments(reader, school, person).await?,
        assignments: said::assignments(reader, school, person).await?,
        ratings: said::ratings(reader, school, person).await?,
        marked_pops: said::marked_pops(reader, school, person).await?,
        survey_answers: said::survey_answers(reader, school, person).await?,
        access: access::of(reader, PersonKey { school_id: school, person_id: person }).await?,
        log: log(reader, person).await?,
        person: facts,
    }))
}

/// What was measured in their attempts: a row for each attempt, since what SQLite hands over costs by the cell.
async fn metrics(reader: &SqlitePool, school: Uuid, person: Uuid) -> Result<Vec<MetricFacts>> {
    /// Id, version, value and unit.
    type Measured = (String, i64, ExactNumber, String);
    let rows: Vec<(Uuid, Json<Vec<Measured>>)> = sqlx::query_as(
        "SELECT s.id, (SELECT json_group_array(json_array(m.id, m.version,
             iif(m.value IS NULL, NULL, printf('%!.17g', m.value)), m.unit) ORDER BY m.position)
           FROM metrics m WHERE m.school_id = s.school_id AND m.session_id = s.id)
         FROM sessions s WHERE s.school_id = $1 AND s.trainee_id = $2 ORDER BY s.started_at, s.id",
    )
    .bind(school)
    .bind(person)
    .fetch_all(reader)
    .await?;
    let facts = |(session_id, found): (Uuid, Json<Vec<Measured>>)| {
        let fact = move |(id, version, ExactNumber(value), unit)| MetricFacts { session_id, id, version, value, unit };
        found.0.into_iter().map(fact)
    };
    Ok(rows.into_iter().flat_map(facts).collect())
}

/// What they did, and what was done with their account.
async fn log(reader: &SqlitePool, person: Uuid) -> Result<Vec<LogFacts>> {
    sqlx::query_as("SELECT at, action, object FROM audit_log WHERE actor = $1 OR object = $1 ORDER BY seq")
        .bind(person.to_string())
        .fetch_all(reader)
        .await
}
