//! Tasks to mark pops: traces and marks.

use model::ids::{CohortId, PersonId, SchoolId, SessionId, TaskId, TraceId};
use model::{CurrentPerson, Moment, Role};
use sqlx::FromRow;

use crate::{Connection, Executor, Json, Result};

/// A task to be created.
#[derive(Clone, Debug)]
pub struct NewTask {
    /// Title.
    pub title: String,
    /// Cohort of the trainees.
    pub cohort_id: CohortId,
    /// Due date: the local time as entered, and the moment it denotes.
    pub due: Option<(String, Moment)>,
    /// The school's time zone.
    pub time_zone: String,
    /// Attempts, in order.
    pub sessions: Vec<SessionId>,
}

/// A task, as shown to a visitor.
#[derive(Clone, Debug, PartialEq, Eq, FromRow)]
pub struct SegmentTask {
    /// Id.
    pub id: TaskId,
    /// Title.
    pub title: String,
    /// Cohort.
    pub cohort_id: CohortId,
    /// Name of the cohort.
    pub cohort: String,
    /// Regular due date in local time, as entered.
    pub due_local: Option<String>,
    /// Due date, for a trainee including their extension.
    pub due_at: Option<Moment>,
    /// Length of the trainee's extension, in calendar days; 0 without one.
    pub extended_days: i64,
    /// Time zone of `due_local`.
    pub time_zone: String,
    /// When it was made.
    pub made_at: Moment,
    /// Number of traces, without the trainee's own attempts.
    #[sqlx(try_from = "i64")]
    pub traces: u32,
    /// Number of traces that the visitor has submitted.
    #[sqlx(try_from = "i64")]
    pub sent: u32,
}

/// A trace of a task.
#[derive(Clone, Debug, PartialEq, Eq, FromRow)]
pub struct Trace {
    /// Random id.
    pub id: TraceId,
    /// Task.
    pub task_id: TaskId,
    /// The attempt.
    pub session_id: SessionId,
    /// Trainee who made the attempt.
    pub trainee_id: PersonId,
    /// Position in the task, from 1.
    #[sqlx(try_from = "i64")]
    pub position: u32,
}

/// A person's marks on a trace.
#[derive(Clone, Debug, PartialEq, FromRow)]
pub struct Marks {
    /// Person.
    pub person_id: PersonId,
    /// Trace.
    pub trace_id: TraceId,
    /// Times of the marks, sorted, in s.
    pub marks: Json<Vec<f64>>,
    /// Time of submission, after which they cannot be changed.
    pub sent_at: Option<Moment>,
}

/// Creates a task.
///
/// # Errors
/// If an attempt or the cohort does not belong to the school, or the database fails.
pub async fn add_segment_task(
    writer: &mut Connection,
    by: &CurrentPerson,
    new: &NewTask,
    now: Moment,
) -> Result<TaskId> {
    let task: TaskId = sqlx::query_scalar(
        "INSERT INTO segment_tasks (id, school_id, title, cohort_id, due_local, time_zone, due_at, made_by, made_at)
         VALUES ($1, $2, $3, $4, $5, $6, $7, $8, $9) RETURNING id",
    )
    .bind(TaskId::made_at(now))
    .bind(by.school_id)
    .bind(&new.title)
    .bind(new.cohort_id)
    .bind(new.due.as_ref().map(|(local, _)| local))
    .bind(&new.time_zone)
    .bind(new.due.as_ref().map(|(_, at)| *at))
    .bind(by.id)
    .bind(now)
    .fetch_one(&mut *writer)
    .await?;
    for (session, position) in new.sessions.iter().zip(1_u32..) {
        sqlx::query(
            "INSERT INTO segment_traces (id, school_id, task_id, session_id, position) VALUES ($1, $2, $3, $4, $5)",
        )
        .bind(TraceId::random())
        .bind(by.school_id)
        .bind(task)
        .bind(session)
        .bind(i64::from(position))
        .execute(&mut *writer)
        .await?;
    }
    Ok(task)
}

/// Returns the tasks of the cohorts that a person teaches, or for an administrator all of the
/// school; latest first, at most 100.
pub async fn list_managed_tasks(
    executor: impl Executor<'_>,
    by: &CurrentPerson,
    only: Option<TaskId>,
) -> Result<Vec<SegmentTask>> {
    sqlx::query_as(
        "SELECT k.id, k.title, k.cohort_id, c.name AS cohort, k.due_local, k.due_at, CAST(0 AS BIGINT) AS extended_days,
           k.time_zone, k.made_at, (SELECT count(*) FROM segment_traces r WHERE r.task_id = k.id) AS traces, CAST(0 AS BIGINT) AS sent
         FROM segment_tasks k JOIN cohorts c ON c.school_id = k.school_id AND c.id = k.cohort_id
         WHERE k.school_id = $1 AND k.withdrawn_at IS NULL AND ($4 IS NULL OR k.id = $4) AND ($2 OR EXISTS (
           SELECT 1 FROM cohort_members m
           WHERE m.cohort_id = k.cohort_id AND m.person_id = $3 AND m.role = 'instructor'))
         ORDER BY k.made_at DESC, k.id DESC LIMIT 100",
    )
    .bind(by.school_id)
    .bind(by.role == Role::Administrator)
    .bind(by.id)
    .bind(only)
    .fetch_all(executor)
    .await
}

/// Returns a trainee's tasks, sorted by due date. Tasks that consist of the trainee's own attempts
/// are left out.
pub async fn list_trainee_tasks(
    executor: impl Executor<'_>,
    school: SchoolId,
    person: PersonId,
) -> Result<Vec<SegmentTask>> {
    sqlx::query_as(
        "SELECT k.id, k.title, k.cohort_id, min(c.name) AS cohort, k.due_local, coalesce(min(x.due_at), k.due_at) AS due_at,
           coalesce(min(x.days), 0) AS extended_days, k.time_zone, k.made_at, count(*) AS traces, count(a.sent_at) AS sent
         FROM cohort_members m
         JOIN segment_tasks k ON k.cohort_id = m.cohort_id AND k.withdrawn_at IS NULL
         JOIN cohorts c ON c.school_id = k.school_id AND c.id = k.cohort_id
         JOIN segment_traces r ON r.task_id = k.id
         JOIN sessions s ON s.school_id = r.school_id AND s.id = r.session_id AND s.trainee_id <> $2
         LEFT JOIN segment_marks a ON a.trace_id = r.id AND a.person_id = $2
         LEFT JOIN segment_extensions x ON x.task_id = k.id AND x.person_id = $2
         WHERE m.person_id = $2 AND m.role = 'trainee' AND k.school_id = $1
         GROUP BY k.id ORDER BY k.due_at IS NULL, coalesce(min(x.due_at), k.due_at), k.made_at",
    )
    .bind(school)
    .bind(person)
    .fetch_all(executor)
    .await
}

/// Returns the traces of a task, in order.
pub async fn list_traces(executor: impl Executor<'_>, school: SchoolId, task: TaskId) -> Result<Vec<Trace>> {
    sqlx::query_as(
        "SELECT r.id, r.task_id, r.session_id, s.trainee_id, r.position FROM segment_traces r
         JOIN sessions s ON s.school_id = r.school_id AND s.id = r.session_id
         WHERE r.school_id = $1 AND r.task_id = $2 ORDER BY r.position",
    )
    .bind(school)
    .bind(task)
    .fetch_all(executor)
    .await
}

/// Returns a trace of a school.
pub async fn find_trace(executor: impl Executor<'_>, school: SchoolId, id: TraceId) -> Result<Option<Trace>> {
    sqlx::query_as(
        "SELECT r.id, r.task_id, r.session_id, s.trainee_id, r.position FROM segment_traces r
         JOIN sessions s ON s.school_id = r.school_id AND s.id = r.session_id
         WHERE r.school_id = $1 AND r.id = $2",
    )
    .bind(school)
    .bind(id)
    .fetch_optional(executor)
    .await
}

/// Returns all marks on the traces of a task.
pub async fn find_marks(executor: impl Executor<'_>, school: SchoolId, task: TaskId) -> Result<Vec<Marks>> {
    sqlx::query_as(
        "SELECT a.person_id, a.trace_id, a.marks, a.sent_at FROM segment_traces r
         JOIN segment_marks a ON a.trace_id = r.id
         WHERE r.school_id = $1 AND r.task_id = $2 ORDER BY r.position",
    )
    .bind(school)
    .bind(task)
    .fetch_all(executor)
    .await
}

/// Returns a person's marks on a trace.
pub async fn list_marks_of(executor: impl Executor<'_>, trace: TraceId, person: PersonId) -> Result<Option<Marks>> {
    sqlx::query_as(
        "SELECT person_id, trace_id, marks, sent_at FROM segment_marks WHERE trace_id = $1 AND person_id = $2",
    )
    .bind(trace)
    .bind(person)
    .fetch_optional(executor)
    .await
}

/// Stores marks. Returns false if they were already submitted.
pub async fn put_marks(writer: &mut Connection, school: SchoolId, new: &Marks) -> Result<bool> {
    sqlx::query(
        "INSERT INTO segment_marks (school_id, trace_id, person_id, marks, sent_at) VALUES ($1, $2, $3, $4, $5)
         ON CONFLICT (trace_id, person_id) DO UPDATE SET marks = excluded.marks, sent_at = excluded.sent_at
         WHERE segment_marks.sent_at IS NULL",
    )
    .bind(school)
    .bind(new.trace_id)
    .bind(new.person_id)
    .bind(&new.marks)
    .bind(new.sent_at)
    .execute(writer)
    .await
    .map(|done| done.rows_affected() == 1)
}

/// Withdraws a task.
pub async fn withdraw_task(writer: &mut Connection, school: SchoolId, id: TaskId, now: Moment) -> Result<()> {
    sqlx::query("UPDATE segment_tasks SET withdrawn_at = $3 WHERE school_id = $1 AND id = $2")
        .bind(school)
        .bind(id)
        .bind(now)
        .execute(writer)
        .await
        .map(drop)
}
