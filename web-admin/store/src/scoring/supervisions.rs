//! Confirmations that an instructor supervised an attempt.

use model::ids::{AssignmentId, CohortId, PersonId, SchoolId, SessionId};
use model::{Moment, SessionKey};
use sqlx::FromRow;

use crate::auth::lti::deliveries;
use crate::recordings::sessions::Session;
use crate::{Connection, Executor, Result};

/// A confirmed supervision.
#[derive(Clone, Debug, PartialEq, Eq, FromRow)]
pub struct Supervision {
    /// Name of the supervisor.
    pub by: String,
    /// Time of the confirmation.
    pub confirmed_at: Moment,
}

/// Confirms the supervision of an attempt. Returns false if it was already confirmed.
///
/// # Errors
/// If the supervisor belongs to another school, or the database fails.
pub async fn confirm_supervision(
    writer: &mut Connection,
    session: &Session,
    by: PersonId,
    now: Moment,
) -> Result<bool> {
    deliveries::mark_attempt(&mut *writer, session.key()).await?;
    sqlx::query(
        "INSERT INTO supervisions (school_id, session_id, trainee_id, confirmed_by, confirmed_at)
         VALUES ($1, $2, $3, $4, $5) ON CONFLICT (school_id, session_id) DO NOTHING",
    )
    .bind(session.school_id)
    .bind(session.id)
    .bind(session.trainee_id)
    .bind(by)
    .bind(now)
    .execute(writer)
    .await
    .map(|done| done.rows_affected() == 1)
}

/// Withdraws a confirmation. Returns false if it does not exist.
pub async fn withdraw_supervision(writer: &mut Connection, session: SessionKey) -> Result<bool> {
    deliveries::mark_attempt(&mut *writer, session).await?;
    sqlx::query("DELETE FROM supervisions WHERE school_id = $1 AND session_id = $2")
        .bind(session.school_id)
        .bind(session.id)
        .execute(writer)
        .await
        .map(|done| done.rows_affected() == 1)
}

/// Returns the supervision of an attempt, if it was confirmed.
pub async fn find_supervision(executor: impl Executor<'_>, session: SessionKey) -> Result<Option<Supervision>> {
    sqlx::query_as(
        "SELECT p.display_name AS \"by\", v.confirmed_at FROM supervisions v
         JOIN people p ON p.school_id = v.school_id AND p.id = v.confirmed_by
         WHERE v.school_id = $1 AND v.session_id = $2",
    )
    .bind(session.school_id)
    .bind(session.id)
    .fetch_optional(executor)
    .await
}

/// Returns the supervised attempts of a trainee.
pub async fn list_trainee_supervisions(
    executor: impl Executor<'_>,
    school: SchoolId,
    trainee: PersonId,
) -> Result<Vec<SessionId>> {
    sqlx::query_scalar("SELECT session_id FROM supervisions WHERE school_id = $1 AND trainee_id = $2")
        .bind(school)
        .bind(trainee)
        .fetch_all(executor)
        .await
}

/// Returns the supervised attempts of a cohort's trainees.
pub async fn list_cohort_supervisions(
    executor: impl Executor<'_>,
    school: SchoolId,
    cohort: CohortId,
) -> Result<Vec<SessionId>> {
    sqlx::query_scalar(
        "SELECT v.session_id FROM (
           SELECT person_id FROM cohort_members WHERE school_id = $1 AND cohort_id = $2 AND role = 'trainee') trained
         CROSS JOIN supervisions v WHERE v.school_id = $1 AND v.trainee_id = trained.person_id",
    )
    .bind(school)
    .bind(cohort)
    .fetch_all(executor)
    .await
}

/// Returns the supervised attempts of an assignment's trainees.
pub async fn of_assignment(
    executor: impl Executor<'_>,
    school: SchoolId,
    assignment: AssignmentId,
) -> Result<Vec<SessionId>> {
    sqlx::query_scalar(
        "SELECT v.session_id FROM (
           SELECT m.person_id FROM assignments a JOIN cohort_members m ON m.cohort_id = a.cohort_id AND m.role = 'trainee'
           WHERE a.id = $2
           UNION ALL SELECT person_id FROM assignments WHERE id = $2 AND person_id IS NOT NULL) trained
         CROSS JOIN supervisions v WHERE v.school_id = $1 AND v.trainee_id = trained.person_id",
    )
    .bind(school)
    .bind(assignment)
    .fetch_all(executor)
    .await
}
