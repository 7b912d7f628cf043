//! Deadlines: extensions and reminders for assignments and for tasks to mark pops. Both kinds use
//! the same statements.

use model::Moment;
use model::ids::{AssignmentId, CohortId, DatedId, PersonId, SchoolId};
use sqlx::FromRow;

use crate::{Connection, Executor, Result};

/// Kind of object with a due date.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum DeadlineKind {
    /// An assignment.
    Assignment,
    /// A task to mark pops.
    Segments,
}

/// An extension of a deadline for one person.
#[derive(Clone, Copy, Debug, PartialEq, Eq, FromRow)]
pub struct Extension {
    /// The person.
    pub person_id: PersonId,
    /// Length of the extension, in calendar days.
    pub days: i64,
    /// Extended due date.
    pub due_at: Moment,
}

/// A reminder to be sent.
#[derive(Clone, Copy, Debug, PartialEq, Eq, FromRow)]
pub struct DueReminder {
    /// School.
    pub school_id: SchoolId,
    /// Recipient.
    pub person_id: PersonId,
    /// Id of the item.
    pub id: DatedId,
}

macro_rules! shorten {
    ($extensions:literal, $of:literal) => {
        concat!("DELETE FROM ", $extensions, " WHERE school_id = $1 AND ", $of, " = $2 AND person_id = $3")
    };
}

macro_rules! lengthen {
    ($extensions:literal, $of:literal) => {
        concat!(
            "INSERT INTO ",
            $extensions,
            " (school_id, ",
            $of,
            ", person_id, days, due_at) VALUES ($1, $2, $3, $4, $5)"
        )
    };
}

// The CROSS JOIN makes SQLite read the few items that are due soon before the members of their
// cohorts.
macro_rules! to_remind {
    ($dated:literal, $extensions:literal, $of:literal, $and:literal) => {
        concat!(
            "SELECT d.school_id, m.person_id, d.id FROM ",
            $dated,
            " d CROSS JOIN cohort_members m
             WHERE m.cohort_id = d.cohort_id AND m.role = 'trainee'
               AND d.due_at > $1 AND d.due_at <= $2 AND d.withdrawn_at IS NULL
               AND NOT EXISTS (SELECT 1 FROM mails s WHERE s.assignment_id = d.id AND s.person_id = m.person_id)
               AND NOT EXISTS (SELECT 1 FROM ",
            $extensions,
            " x WHERE x.",
            $of,
            " = d.id AND x.person_id = m.person_id)
             UNION SELECT x.school_id, x.person_id, d.id FROM ",
            $extensions,
            " x JOIN ",
            $dated,
            " d ON d.id = x.",
            $of,
            " WHERE x.due_at > $1 AND x.due_at <= $2 AND d.withdrawn_at IS NULL
               AND NOT EXISTS (SELECT 1 FROM mails s WHERE s.assignment_id = d.id AND s.person_id = x.person_id) ",
            $and
        )
    };
}

/// Key of an assignment or task with a due date.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct DeadlineKey {
    /// School.
    pub school_id: SchoolId,
    /// Kind of object.
    pub kind: DeadlineKind,
    /// Id of the assignment or task.
    pub id: DatedId,
}

/// Sets one trainee's extension, or removes it with `None`.
pub async fn extend_deadline(
    writer: &mut Connection,
    deadline: DeadlineKey,
    person: PersonId,
    longer: Option<(i64, Moment)>,
) -> Result<()> {
    let DeadlineKey { school_id, kind, id } = deadline;
    let shorten = match kind {
        DeadlineKind::Assignment => shorten!("assignment_extensions", "assignment_id"),
        DeadlineKind::Segments => shorten!("segment_extensions", "task_id"),
    };
    sqlx::query(shorten).bind(school_id).bind(id).bind(person).execute(&mut *writer).await?;
    let Some((days, due_at)) = longer else { return Ok(()) };
    let lengthen = match kind {
        DeadlineKind::Assignment => lengthen!("assignment_extensions", "assignment_id"),
        DeadlineKind::Segments => lengthen!("segment_extensions", "task_id"),
    };
    sqlx::query(lengthen).bind(school_id).bind(id).bind(person).bind(days).bind(due_at).execute(writer).await.map(drop)
}

/// Returns people with an item of one kind due between two moments who were not yet reminded of it.
pub async fn list_due_reminders(
    executor: impl Executor<'_>,
    kind: DeadlineKind,
    from: Moment,
    to: Moment,
) -> Result<Vec<DueReminder>> {
    let due = match kind {
        DeadlineKind::Assignment => to_remind!(
            "assignments",
            "assignment_extensions",
            "assignment_id",
            "UNION SELECT a.school_id, a.person_id, a.id FROM assignments a
             WHERE a.person_id IS NOT NULL AND a.due_at > $1 AND a.due_at <= $2 AND a.withdrawn_at IS NULL
               AND NOT EXISTS (SELECT 1 FROM mails s WHERE s.assignment_id = a.id AND s.person_id = a.person_id)
               AND NOT EXISTS (SELECT 1 FROM assignment_extensions x
                               WHERE x.assignment_id = a.id AND x.person_id = a.person_id)"
        ),
        DeadlineKind::Segments => to_remind!("segment_tasks", "segment_extensions", "task_id", ""),
    };
    sqlx::query_as(due).bind(from).bind(to).fetch_all(executor).await
}

/// Returns people with an unanswered survey that closes between two moments who were not yet reminded
/// of it.
pub async fn list_closing_surveys(executor: impl Executor<'_>, from: Moment, to: Moment) -> Result<Vec<DueReminder>> {
    sqlx::query_as(
        "SELECT DISTINCT s.school_id, m.person_id, s.id FROM surveys s
         CROSS JOIN survey_cohorts c CROSS JOIN cohort_members m
         WHERE c.survey_id = s.id AND m.cohort_id = c.cohort_id AND m.role = 'trainee' AND s.after_attempts = 0 AND s.opens_at <= $1 AND s.closes_at > $1 AND s.closes_at <= $2
           AND NOT EXISTS (SELECT 1 FROM survey_participations a WHERE a.survey_id = s.id AND a.person_id = m.person_id)
           AND NOT EXISTS (SELECT 1 FROM mails l WHERE l.assignment_id = s.id AND l.person_id = m.person_id)",
    )
    .bind(from)
    .bind(to)
    .fetch_all(executor)
    .await
}

/// Returns raters with unfinished ratings in a round made between two moments who were not yet
/// reminded of it.
pub async fn list_waiting_rounds(executor: impl Executor<'_>, from: Moment, to: Moment) -> Result<Vec<DueReminder>> {
    // The unary plus keeps SQLite from using an index by school.
    sqlx::query_as(
        "SELECT DISTINCT o.school_id, r.rater_id AS person_id, o.id FROM rating_rounds o CROSS JOIN ratings r
         WHERE +r.school_id = o.school_id AND r.round_id = o.id AND o.withdrawn_at IS NULL AND o.made_at > $1 AND o.made_at <= $2 AND r.finished_at IS NULL
           AND NOT EXISTS (SELECT 1 FROM mails l WHERE l.assignment_id = o.id AND l.person_id = r.rater_id)",
    )
    .bind(from)
    .bind(to)
    .fetch_all(executor)
    .await
}

/// Returns people of the schools who were invited to an open study between two moments, have not
/// answered and were not yet reminded of it.
pub async fn list_waiting_invitations(
    executor: impl Executor<'_>,
    from: Moment,
    to: Moment,
) -> Result<Vec<DueReminder>> {
    sqlx::query_as(
        "SELECT u.school_id, t.person_id, u.id FROM studies u CROSS JOIN study_participants t CROSS JOIN people p
         WHERE t.school_id = u.school_id AND t.study_id = u.id AND u.closed_at IS NULL AND t.withdrawn_at IS NULL
           AND t.agreed_at IS NULL AND t.added_at > $1 AND t.added_at <= $2
           AND p.school_id = t.school_id AND p.id = t.person_id AND p.role <> 'guest'
           AND NOT EXISTS (SELECT 1 FROM mails l WHERE l.assignment_id = u.id AND l.person_id = t.person_id)",
    )
    .bind(from)
    .bind(to)
    .fetch_all(executor)
    .await
}

/// An extension of one of the assignments of a cohort's trainees.
#[derive(Clone, Copy, Debug, PartialEq, Eq, FromRow)]
pub struct CohortExtension {
    /// The assignment.
    pub assignment_id: AssignmentId,
    /// The extension.
    #[sqlx(flatten)]
    pub extension: Extension,
}

/// Returns the extensions of assignments for all trainees of a cohort.
pub async fn list_cohort_extensions(
    executor: impl Executor<'_>,
    school: SchoolId,
    cohort: CohortId,
) -> Result<Vec<CohortExtension>> {
    sqlx::query_as(
        "SELECT x.assignment_id, x.person_id, x.days, x.due_at FROM cohort_members m
         CROSS JOIN assignment_extensions x
         WHERE x.school_id = m.school_id AND x.person_id = m.person_id AND m.school_id = $1 AND m.cohort_id = $2
         AND m.role = 'trainee'",
    )
    .bind(school)
    .bind(cohort)
    .fetch_all(executor)
    .await
}

/// Returns all extensions of an assignment or task.
pub async fn list_extensions(executor: impl Executor<'_>, deadline: DeadlineKey) -> Result<Vec<Extension>> {
    let DeadlineKey { school_id, kind, id } = deadline;
    let longer = match kind {
        DeadlineKind::Assignment => {
            "SELECT person_id, days, due_at FROM assignment_extensions WHERE school_id = $1 AND assignment_id = $2"
        }
        DeadlineKind::Segments => {
            "SELECT person_id, days, due_at FROM segment_extensions WHERE school_id = $1 AND task_id = $2"
        }
    };
    sqlx::query_as(longer).bind(school_id).bind(id).fetch_all(executor).await
}
