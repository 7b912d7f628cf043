//! Assignments: the task, the cohort or trainee, and the due date.

use model::count::StoredCount;
use model::ids::{AssignmentId, CohortId, PersonId, SchoolId};
use model::titles::StoredTitle;
use model::training::assignment::{Assigned, AssignmentTask};
use model::training::due;
use model::{CurrentPerson, Moment, Role};
use sqlx::FromRow;

use crate::auth::lti::deliveries;
use crate::{Connection, Executor, Result};

/// An assignment to be stored.
#[derive(Clone, Debug)]
pub struct NewAssignment {
    /// Exercise or course to train.
    pub task: AssignmentTask,
    /// The cohort, or
    pub cohort_id: Option<CohortId>,
    /// the trainee.
    pub person_id: Option<PersonId>,
    /// Attempts must be supervised by an instructor.
    pub supervised: bool,
    /// Only attempts made after the assignment count.
    pub since_only: bool,
    /// Maximum number of attempts that count.
    pub attempt_limit: Option<u32>,
    /// Due date: the local time as entered, and the moment it denotes.
    pub due: Option<(String, Moment)>,
    /// The school's time zone.
    pub time_zone: String,
}

/// Stores an assignment.
///
/// # Errors
/// If the exercise, course, cohort or person does not belong to the school, or the database fails.
pub async fn add_assignment(
    writer: &mut Connection,
    by: &CurrentPerson,
    new: &NewAssignment,
    now: Moment,
) -> Result<AssignmentId> {
    let (exercise, course) = match &new.task {
        AssignmentTask::Exercise(id) => (Some(id), None),
        AssignmentTask::Course(id) => (None, Some(id)),
    };
    let id = sqlx::query_scalar(
        "INSERT INTO assignments (id, school_id, exercise_id, curriculum_id, cohort_id, person_id, supervised,
           attempt_limit, due_local, time_zone, due_at, made_by, made_at, since_only)
         VALUES ($1, $2, $3, $4, $5, $6, $7, $8, $9, $10, $11, $12, $13, $14) RETURNING id",
    )
    .bind(AssignmentId::made_at(now))
    .bind(by.school_id)
    .bind(exercise)
    .bind(course)
    .bind(new.cohort_id)
    .bind(new.person_id)
    .bind(new.supervised)
    .bind(new.attempt_limit.map(i64::from))
    .bind(new.due.as_ref().map(|(local, _)| local))
    .bind(&new.time_zone)
    .bind(new.due.as_ref().map(|(_, at)| *at))
    .bind(by.id)
    .bind(now)
    .bind(new.since_only)
    .fetch_one(&mut *writer)
    .await?;
    deliveries::mark_assignment(writer, by.school_id, id).await?;
    Ok(id)
}

#[derive(FromRow)]
struct AssignedRow {
    id: AssignmentId,
    exercise_id: Option<String>,
    curriculum_id: Option<String>,
    #[sqlx(try_from = "StoredTitle")]
    title: String,
    person_id: Option<PersonId>,
    made_at: Moment,
    since_only: bool,
    due_at: Option<Moment>,
    extended_days: i64,
    #[sqlx(try_from = "StoredCount")]
    attempt_limit: Option<u32>,
    supervised: bool,
    time_zone: String,
}

impl From<AssignedRow> for Assigned {
    fn from(row: AssignedRow) -> Self {
        let task = match (row.exercise_id, row.curriculum_id) {
            (Some(exercise), _) => AssignmentTask::Exercise(exercise),
            (None, course) => AssignmentTask::Course(course.unwrap_or_default()),
        };
        Self {
            id: row.id,
            task,
            title: row.title,
            person_id: row.person_id,
            made_at: row.made_at,
            since_only: row.since_only,
            due_at: row.due_at,
            extended_days: row.extended_days,
            attempt_limit: row.attempt_limit,
            supervised: row.supervised,
            time_zone: row.time_zone,
        }
    }
}

/// Selects assignments of school `$1`, with the extensions of trainee `$2`.
macro_rules! assigned {
    ($which:literal) => {
        concat!(
            "SELECT a.id, a.exercise_id, a.curriculum_id, coalesce(r.title, c.title, '') AS title, a.person_id, a.made_at,
               a.since_only, coalesce(x.due_at, a.due_at) AS due_at, coalesce(x.days, 0) AS extended_days, a.attempt_limit,
               a.supervised, a.time_zone
             FROM assignments a
             LEFT JOIN assignment_extensions x ON x.assignment_id = a.id AND x.person_id = $2
             LEFT JOIN exercises e ON e.school_id = a.school_id AND e.exercise_id = a.exercise_id
             LEFT JOIN exercise_revisions r ON r.id = e.revision_id
             LEFT JOIN curricula u ON u.school_id = a.school_id AND u.curriculum_id = a.curriculum_id
             LEFT JOIN curriculum_revisions c ON c.id = u.revision_id
             WHERE a.school_id = $1 AND a.withdrawn_at IS NULL AND a.id ",
            $which
        )
    };
}

/// Returns an assignment with its regular due date, without extensions.
pub async fn find_assignment(
    executor: impl Executor<'_>,
    school: SchoolId,
    id: AssignmentId,
) -> Result<Option<Assigned>> {
    let row: Option<AssignedRow> = sqlx::query_as(assigned!("= $3"))
        .bind(school)
        .bind(None::<AssignmentId>)
        .bind(id)
        .fetch_optional(executor)
        .await?;
    Ok(row.map(Assigned::from))
}

/// Returns the cohort of an assignment; `None` for an individual one.
pub async fn find_cohort(executor: impl Executor<'_>, school: SchoolId, id: AssignmentId) -> Result<Option<CohortId>> {
    sqlx::query_scalar("SELECT cohort_id FROM assignments WHERE school_id = $1 AND id = $2")
        .bind(school)
        .bind(id)
        .fetch_one(executor)
        .await
}

/// Returns the assignments of a cohort and of its individual trainees, with their regular due
/// dates, without extensions.
pub async fn list_cohort_assignments(
    executor: impl Executor<'_>,
    school: SchoolId,
    cohort: CohortId,
) -> Result<Vec<Assigned>> {
    let rows: Vec<AssignedRow> = sqlx::query_as(assigned!(
        "IN (SELECT id FROM assignments WHERE cohort_id = $3
             UNION SELECT b.id FROM cohort_members m JOIN assignments b ON b.person_id = m.person_id
                   WHERE m.cohort_id = $3 AND m.role = 'trainee')
         ORDER BY a.made_at, a.id"
    ))
    .bind(school)
    .bind(None::<PersonId>)
    .bind(cohort)
    .fetch_all(executor)
    .await?;
    Ok(rows.into_iter().map(Assigned::from).collect())
}

/// Returns the latest assignment of the same task to the same cohort or trainee that is neither
/// withdrawn nor past its due date.
pub async fn find_same_assignment(
    executor: impl Executor<'_>,
    school: SchoolId,
    new: &NewAssignment,
    now: Moment,
) -> Result<Option<AssignmentId>> {
    let (exercise, course) = match &new.task {
        AssignmentTask::Exercise(id) => (Some(id), None),
        AssignmentTask::Course(id) => (None, Some(id)),
    };
    sqlx::query_scalar(
        "SELECT id FROM assignments WHERE school_id = $1 AND exercise_id IS NOT DISTINCT FROM $2
         AND curriculum_id IS NOT DISTINCT FROM $3
           AND cohort_id IS NOT DISTINCT FROM $4 AND person_id IS NOT DISTINCT FROM $5 AND withdrawn_at IS NULL
           AND coalesce(due_at, $6) >= $6
         ORDER BY made_at DESC LIMIT 1",
    )
    .bind(school)
    .bind(exercise)
    .bind(course)
    .bind(new.cohort_id)
    .bind(new.person_id)
    .bind(due::earliest_open(now))
    .fetch_optional(executor)
    .await
}

/// Returns the assignments of a trainee, made to them directly or to one of their cohorts, with
/// their extensions.
pub async fn list_trainee_assignments(
    executor: impl Executor<'_>,
    school: SchoolId,
    person: PersonId,
) -> Result<Vec<Assigned>> {
    let rows: Vec<AssignedRow> = sqlx::query_as(assigned!(
        "IN (SELECT id FROM assignments WHERE person_id = $2
             UNION SELECT b.id FROM cohort_members m JOIN assignments b ON b.cohort_id = m.cohort_id
                   WHERE m.person_id = $2 AND m.role = 'trainee')
         ORDER BY a.made_at, a.id"
    ))
    .bind(school)
    .bind(person)
    .fetch_all(executor)
    .await?;
    Ok(rows.into_iter().map(Assigned::from).collect())
}

/// An assignment as shown to the staff who manage it.
#[derive(Clone, Debug, PartialEq, Eq, FromRow)]
pub struct ManagedAssignment {
    /// Id.
    pub id: AssignmentId,
    /// Title of the exercise or course.
    #[sqlx(try_from = "StoredTitle")]
    pub title: String,
    /// The cohort, or
    pub cohort_id: Option<CohortId>,
    /// the trainee.
    pub person_id: Option<PersonId>,
    /// Name of the cohort or trainee.
    pub to: String,
    /// Due date in local time, as entered.
    pub due_local: Option<String>,
    /// Moment at which it is due.
    pub due_at: Option<Moment>,
    /// Time zone of `due_local`.
    pub time_zone: String,
    /// Maximum number of attempts that count.
    #[sqlx(try_from = "StoredCount")]
    pub attempt_limit: Option<u32>,
    /// Attempts must be supervised by an instructor.
    pub supervised: bool,
    /// Only attempts made after the assignment count.
    pub since_only: bool,
}

/// Returns the assignments that a person manages, latest first: for an instructor those of their
/// cohorts and of the trainees in them, for an administrator all of the school.
pub async fn list_managed_assignments(
    executor: impl Executor<'_>,
    by: &CurrentPerson,
    only: Option<AssignmentId>,
    limit: u32,
) -> Result<Vec<ManagedAssignment>> {
    sqlx::query_as(
        "SELECT a.id, coalesce(r.title, c.title, '') AS title, a.cohort_id, a.person_id,
           coalesce(k.name, p.display_name, '') AS \"to\", a.due_local, a.due_at, a.time_zone, a.attempt_limit,
           a.supervised, a.since_only
         FROM assignments a
         LEFT JOIN cohorts k ON k.id = a.cohort_id
         LEFT JOIN people p ON p.id = a.person_id
         LEFT JOIN exercises e ON e.school_id = a.school_id AND e.exercise_id = a.exercise_id
         LEFT JOIN exercise_revisions r ON r.id = e.revision_id
         LEFT JOIN curricula u ON u.school_id = a.school_id AND u.curriculum_id = a.curriculum_id
         LEFT JOIN curriculum_revisions c ON c.id = u.revision_id
         WHERE a.school_id = $1 AND a.withdrawn_at IS NULL AND ($4 IS NULL OR a.id = $4)
           AND ($2 OR a.cohort_id IN (SELECT t.cohort_id FROM cohort_members t WHERE t.person_id = $3 AND t.role = 'instructor')
             OR a.person_id IN (SELECT taught.trainee_id FROM taught_trainees taught WHERE taught.teacher_id = $3))
         ORDER BY a.made_at DESC, a.id DESC LIMIT $5 + 0",
    )
    .bind(by.school_id)
    .bind(by.role == Role::Administrator)
    .bind(by.id)
    .bind(only)
    .bind(i64::from(limit))
    .fetch_all(executor)
    .await
}

/// Withdraws an assignment.
pub async fn withdraw_assignment(
    writer: &mut Connection,
    school: SchoolId,
    id: AssignmentId,
    now: Moment,
) -> Result<()> {
    sqlx::query("UPDATE assignments SET withdrawn_at = $3 WHERE school_id = $1 AND id = $2")
        .bind(school)
        .bind(id)
        .bind(now)
        .execute(&mut *writer)
        .await?;
    deliveries::mark_assignment(writer, school, id).await
}
