//! Comments, assignments, ratings, marks and survey answers in a person's data export.

use assessment::questionnaire::Answer;
use attempt::AttemptCurve;
use model::Moment;
use model::ids::{AssignmentId, CommentId, PersonId, SchoolId, SessionId, TraceId};
use model::scoring::segments::{MarksVerdict, pops};
use model::titles::StoredTitle;
use serde::Serialize;
use sqlx::FromRow;

use crate::training::assignments;
use crate::{Json, Pool, Result};

/// A comment on one of the person's attempts, or a reply.
#[derive(Clone, Debug, Serialize, FromRow)]
pub struct CommentFacts {
    session_id: SessionId,
    id: CommentId,
    answers: Option<CommentId>,
    author: String,
    kind: Option<String>,
    from_s: Option<f64>,
    to_s: Option<f64>,
    body: String,
    made_at: Moment,
}

/// An assignment.
#[derive(Clone, Debug, Serialize)]
pub struct AssignmentFacts {
    id: AssignmentId,
    title: String,
    assigned_at: Moment,
    due_at: Option<Moment>,
    extended_days: i64,
    attempt_limit: Option<u32>,
    supervised: bool,
}

/// A finished rating of one of the person's attempts.
#[derive(Clone, Debug, Serialize, FromRow)]
pub struct RatingFacts {
    session_id: SessionId,
    round: String,
    #[sqlx(try_from = "StoredTitle")]
    instrument: String,
    answers: Json<Vec<Option<Answer>>>,
    finished_at: Moment,
}

/// Pops marked by the person. The results are present once the marks have been submitted.
#[derive(Clone, Debug, Serialize)]
pub struct MarksFacts {
    task: String,
    trace: TraceId,
    marks_s: Vec<f64>,
    sent_at: Option<Moment>,
    pops: Option<usize>,
    found: Option<usize>,
    false_marks: Option<usize>,
    mean_error_ms: Option<f64>,
    largest_error_ms: Option<f64>,
}

/// The person's answers in a survey.
#[derive(Clone, Debug, Serialize, FromRow)]
pub struct AnswerFacts {
    survey: String,
    #[sqlx(try_from = "StoredTitle")]
    instrument: String,
    session_id: Option<SessionId>,
    state: String,
    answers: Json<Vec<Option<Answer>>>,
    submitted_at: Option<Moment>,
}

pub(super) async fn comments(reader: &Pool, school: SchoolId, person: PersonId) -> Result<Vec<CommentFacts>> {
    sqlx::query_as(
        "SELECT c.session_id, c.id, c.answers, p.display_name AS author, c.kind, c.from_s, c.to_s, c.body, c.made_at
         FROM sessions s CROSS JOIN comments c
         JOIN people p ON p.school_id = c.school_id AND p.id = c.author_id
         WHERE c.school_id = s.school_id AND c.session_id = s.id AND s.school_id = $1 AND s.trainee_id = $2
         AND c.withdrawn_at IS NULL
         ORDER BY s.started_at, s.id, c.made_at, c.id",
    )
    .bind(school)
    .bind(person)
    .fetch_all(reader)
    .await
}

pub(super) async fn assignments(reader: &Pool, school: SchoolId, person: PersonId) -> Result<Vec<AssignmentFacts>> {
    let assigned = assignments::list_trainee_assignments(reader, school, person).await?;
    let facts = assigned.into_iter().map(|assigned| AssignmentFacts {
        id: assigned.id,
        title: assigned.title,
        assigned_at: assigned.made_at,
        due_at: assigned.due_at,
        extended_days: assigned.extended_days,
        attempt_limit: assigned.attempt_limit,
        supervised: assigned.supervised,
    });
    Ok(facts.collect())
}

pub(super) async fn ratings(reader: &Pool, school: SchoolId, person: PersonId) -> Result<Vec<RatingFacts>> {
    sqlx::query_as(
        "SELECT r.session_id, o.title AS round, i.title AS instrument, r.answers, r.finished_at
         FROM sessions s CROSS JOIN ratings r
         JOIN rating_rounds o ON o.id = r.round_id AND o.withdrawn_at IS NULL
         JOIN instrument_revisions i ON i.id = o.revision_id
         WHERE r.school_id = s.school_id AND r.session_id = s.id AND s.school_id = $1 AND s.trainee_id = $2
         AND r.finished_at IS NOT NULL
         AND NOT EXISTS (SELECT 1 FROM exams x WHERE x.round_id = o.id AND x.closed_at IS NULL)
         ORDER BY s.started_at, s.id, o.made_at, r.id",
    )
    .bind(school)
    .bind(person)
    .fetch_all(reader)
    .await
}

#[derive(FromRow)]
struct MarksRow {
    task: String,
    trace: TraceId,
    marks: Json<Vec<f64>>,
    sent_at: Option<Moment>,
    curve: Json<AttemptCurve>,
}

impl From<MarksRow> for MarksFacts {
    fn from(row: MarksRow) -> Self {
        let verdict = row.sent_at.map(|_| MarksVerdict::of(&pops(&row.curve), &row.marks));
        let verdict = verdict.as_ref();
        Self {
            task: row.task,
            trace: row.trace,
            marks_s: row.marks.0.clone(),
            sent_at: row.sent_at,
            pops: verdict.map(MarksVerdict::pops),
            found: verdict.map(|verdict| verdict.hits.len()),
            false_marks: verdict.map(|verdict| verdict.false_marks.len()),
            mean_error_ms: verdict.and_then(MarksVerdict::mean_error_ms),
            largest_error_ms: verdict.and_then(MarksVerdict::largest_error_ms),
        }
    }
}

pub(super) async fn marked_pops(reader: &Pool, school: SchoolId, person: PersonId) -> Result<Vec<MarksFacts>> {
    let rows: Vec<MarksRow> = sqlx::query_as(
        "SELECT k.title AS task, r.id AS trace, a.marks, a.sent_at, c.body AS curve
         FROM segment_marks a JOIN segment_traces r ON r.id = a.trace_id
         JOIN segment_tasks k ON k.id = r.task_id
         JOIN session_curves c ON c.school_id = r.school_id AND c.session_id = r.session_id
         WHERE a.school_id = $1 AND a.person_id = $2 ORDER BY k.made_at, r.position",
    )
    .bind(school)
    .bind(person)
    .fetch_all(reader)
    .await?;
    Ok(rows.into_iter().map(MarksFacts::from).collect())
}

pub(super) async fn survey_answers(reader: &Pool, school: SchoolId, person: PersonId) -> Result<Vec<AnswerFacts>> {
    sqlx::query_as(
        "SELECT u.title AS survey, i.title AS instrument, r.session_id, r.state, r.answers, r.submitted_at
         FROM survey_responses r JOIN surveys u ON u.id = r.survey_id AND u.identity <> 'anonymous'
         JOIN instrument_revisions i ON i.id = u.revision_id
         WHERE r.school_id = $1 AND r.person_id = $2 ORDER BY r.submitted_at NULLS FIRST, r.id",
    )
    .bind(school)
    .bind(person)
    .fetch_all(reader)
    .await
}
