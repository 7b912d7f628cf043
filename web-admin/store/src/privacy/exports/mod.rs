//! A person's data export: all stored data about them.

mod access;
mod held;
mod said;

use std::collections::BTreeMap;

pub use access::{AccessFacts, PasskeyFacts, TokenFacts};
use model::ids::{PersonId, SchoolId, SessionId, StationId};
use model::{Moment, PersonKey, Role};
pub use said::{AnswerFacts, AssignmentFacts, CommentFacts, MarksFacts, RatingFacts};
use serde::Serialize;
use serde_json::Value;
use sqlx::FromRow;

use crate::{ExactNumber, Json, Pool, Result};

/// All stored data about a person.
#[derive(Clone, Debug, Serialize)]
pub struct PersonExport {
    /// Personal details.
    pub person: PersonFacts,
    /// Names of the cohorts, sorted.
    pub cohorts: Vec<String>,
    /// Attempts, by start time.
    pub attempts: Vec<AttemptFacts>,
    /// Metrics of the attempts.
    pub metrics: Vec<MetricFacts>,
    /// All computed scores of the attempts.
    pub scores: Vec<ScoreFacts>,
    /// Comments and replies on the attempts.
    pub comments: Vec<CommentFacts>,
    /// Assignments.
    pub assignments: Vec<AssignmentFacts>,
    /// Finished ratings of the attempts, without the raters.
    pub ratings: Vec<RatingFacts>,
    /// Marked pops, and the accuracy of the marks.
    pub marked_pops: Vec<MarksFacts>,
    /// Answers in surveys that are not anonymous.
    pub survey_answers: Vec<AnswerFacts>,
    /// Credentials other than the password.
    pub access: AccessFacts,
    /// Other records, by kind.
    #[serde(flatten)]
    pub held: BTreeMap<&'static str, Vec<Value>>,
    /// Audit log entries on the person's actions, account, attempts and tokens.
    pub log: Vec<LogFacts>,
}

/// Personal details.
#[derive(Clone, Debug, Serialize, FromRow)]
pub struct PersonFacts {
    id: PersonId,
    school: String,
    role: Role,
    email: String,
    display_name: String,
    pseudonym: String,
    registrar_id: Option<String>,
    language: Option<String>,
    created_at: Moment,
}

/// An attempt, with the URL of its recording.
#[derive(Clone, Debug, Serialize, FromRow)]
pub struct AttemptFacts {
    session_id: SessionId,
    exercise_id: String,
    started_at: Moment,
    received_at: Moment,
    duration_s: f64,
    device: String,
    simulator_version: String,
    state: String,
    complete: bool,
    refusal: Option<String>,
    uncounted: Option<String>,
    claimed_started_at: Option<Moment>,
    signed_by_station: Option<StationId>,
    resimulation_differs: Option<bool>,
    recording_sha256: String,
    recording_size_bytes: i64,
    recording: String,
}

/// A metric of an attempt.
#[derive(Clone, Debug, Serialize, FromRow)]
pub struct MetricFacts {
    session_id: SessionId,
    id: String,
    version: i64,
    value: Option<f64>,
    unit: String,
}

/// A computed score of an attempt.
#[derive(Clone, Debug, Serialize, FromRow)]
pub struct ScoreFacts {
    session_id: SessionId,
    score: f64,
    passed: bool,
    rubric_sha256: String,
    deductions: Json<Value>,
    hard_fails: Json<Value>,
    computed_at: Moment,
}

/// An entry of the audit log.
#[derive(Clone, Debug, Serialize, FromRow)]
pub struct LogFacts {
    at: Moment,
    actor: String,
    action: String,
    object: String,
    details: Json<Value>,
}

/// Collects the data export of a person. Returns `None` if there is no such person.
pub async fn of_person(reader: &Pool, school: SchoolId, person: PersonId) -> Result<Option<PersonExport>> {
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
           complete, refusal, uncounted, claimed_started_at, signed_by AS signed_by_station,
           verify_flagged AS resimulation_differs, recording_sha256, recording_size AS recording_size_bytes, '' AS recording
         FROM sessions WHERE school_id = $1 AND trainee_id = $2 ORDER BY started_at, id",
    );
    let scores = sqlx::query_as(
        "SELECT c.session_id, c.score, c.passed, c.rubric_sha256, c.deductions, c.hard_fails, c.computed_at
         FROM sessions s
         CROSS JOIN scores c
         WHERE c.school_id = s.school_id AND c.session_id = s.id AND s.school_id = $1
         AND s.trainee_id = $2 ORDER BY s.started_at, s.id, c.rowid",
    );
    let mut attempts: Vec<AttemptFacts> = attempts.bind(school).bind(person).fetch_all(reader).await?;
    for attempt in &mut attempts {
        attempt.recording = format!("/api/v1/sessions/{}/recording", attempt.session_id);
    }
    Ok(Some(PersonExport {
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
        held: held::of_person(reader, school, person).await?,
        log: log(reader, PersonKey { school_id: school, person_id: person }).await?,
        person: facts,
    }))
}

/// Returns the metrics of the person's attempts. Each attempt is one row with a JSON array, because
/// SQLite's cost grows with the number of cells.
async fn metrics(reader: &Pool, school: SchoolId, person: PersonId) -> Result<Vec<MetricFacts>> {
    /// Id, version, value and unit.
    type Measured = (String, i64, ExactNumber, String);
    let rows: Vec<(SessionId, Json<Vec<Measured>>)> = sqlx::query_as(
        "SELECT s.id, (SELECT json_group_array(json_array(m.id, m.version,
             iif(m.value IS NULL, NULL, printf('%!.17g', m.value)), m.unit) ORDER BY m.position)
           FROM metrics m WHERE m.school_id = s.school_id AND m.session_id = s.id)
         FROM sessions s WHERE s.school_id = $1 AND s.trainee_id = $2 ORDER BY s.started_at, s.id",
    )
    .bind(school)
    .bind(person)
    .fetch_all(reader)
    .await?;
    let facts = |(session_id, found): (SessionId, Json<Vec<Measured>>)| {
        let fact = move |(id, version, ExactNumber(value), unit)| MetricFacts { session_id, id, version, value, unit };
        found.0.into_iter().map(fact)
    };
    Ok(rows.into_iter().flat_map(facts).collect())
}

/// Returns the audit log entries on the person's actions, account, attempts, tokens, assignments
/// and extensions.
async fn log(reader: &Pool, PersonKey { school_id: school, person_id: person }: PersonKey) -> Result<Vec<LogFacts>> {
    sqlx::query_as(
        "WITH ids (id) AS (SELECT $2 UNION ALL SELECT id FROM sessions WHERE school_id = $1 AND trainee_id = $2
             UNION ALL SELECT id FROM api_tokens WHERE school_id = $1 AND person_id = $2
             UNION ALL SELECT assignment_id FROM assignment_extensions WHERE school_id = $1 AND person_id = $2
             UNION ALL SELECT id FROM assignments WHERE school_id = $1 AND person_id = $2
             UNION ALL SELECT task_id FROM segment_extensions WHERE school_id = $1 AND person_id = $2),
           spelt (text) AS (SELECT lower(substr(hex(id), 1, 8) || '-' || substr(hex(id), 9, 4) || '-'
             || substr(hex(id), 13, 4) || '-' || substr(hex(id), 17, 4) || '-' || substr(hex(id), 21)) FROM ids),
           found (seq) AS (SELECT a.seq FROM spelt CROSS JOIN audit_log a
               WHERE a.object = spelt.text AND (a.action NOT LIKE '%.extended' OR a.details ->> '$.person' = $3)
             UNION SELECT seq FROM audit_log WHERE actor = $3)
         SELECT a.at, a.actor, a.action, a.object, a.details FROM found CROSS JOIN audit_log a
         WHERE a.seq = found.seq ORDER BY a.seq",
    )
    .bind(school)
    .bind(person)
    .bind(person.to_string())
    .fetch_all(reader)
    .await
}
