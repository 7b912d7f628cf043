//! Cohorts and who is in them.

use sqlx::{FromRow, SqliteConnection, SqliteExecutor};
use uuid::Uuid;

use super::Result;
use crate::domain::{Moment, Role, new_id};

/// A cohort.
#[derive(Clone, Debug, PartialEq, Eq, FromRow)]
pub struct Cohort {
    /// Id.
    pub id: Uuid,
    /// Name, unique in the school.
    pub name: String,
}

/// The cohort of a name in a school, made where it is missing.
///
/// # Errors
/// When the database fails.
pub async fn find_or_create(writer: &mut SqliteConnection, school: Uuid, name: &str, now: Moment) -> Result<Cohort> {
    sqlx::query_as(
        "INSERT INTO cohorts (id, school_id, name, created_at) VALUES ($1, $2, $3, $4)
         ON CONFLICT (school_id, name) DO UPDATE SET name = excluded.name RETURNING id, name",
    )
    .bind(new_id(now))
    .bind(school)
    .bind(name)
    .bind(now)
    .fetch_one(writer)
    .await
}

/// A cohort of a school.
///
/// # Errors
/// When the database fails.
pub async fn find(executor: impl SqliteExecutor<'_>, school: Uuid, id: Uuid) -> Result<Option<Cohort>> {
    sqlx::query_as("SELECT id, name FROM cohorts WHERE school_id = $1 AND id = $2")
        .bind(school)
        .bind(id)
        .fetch_optional(executor)
        .await
}

/// The cohorts of a school, by name.
///
/// # Errors
/// When the database fails.
pub async fn all(executor: impl SqliteExecutor<'_>, school: Uuid) -> Result<Vec<Cohort>> {
    sqlx::query_as("SELECT id, name FROM cohorts WHERE school_id = $1 ORDER BY name")
        .bind(school)
        .fetch_all(executor)
        .await
}

/// Who joins which cohort.
#[derive(Clone, Copy, Debug)]
pub struct Membership {
    /// The school of both.
    pub school_id: Uuid,
    /// The cohort.
    pub cohort_id: Uuid,
    /// The person.
    pub person_id: Uuid,
    /// As trainee or instructor.
    pub role: Role,
}

/// Puts a person into a cohort, or changes what they are in it.
///
/// # Errors
/// When either is of another school, the role is neither trainee nor instructor, or the database fails.
pub async fn join(writer: &mut SqliteConnection, membership: Membership) -> Result<()> {
    sqlx::query(
        "INSERT INTO cohort_members (school_id, cohort_id, person_id, role) VALUES ($1, $2, $3, $4)
         ON CONFLICT (cohort_id, person_id) DO UPDATE SET role = excluded.role",
    )
    .bind(membership.school_id)
    .bind(membership.cohort_id)
    .bind(membership.person_id)
    .bind(membership.role)
    .execute(writer)
    .await
    .map(drop)
}

/// Takes a person out of a cohort. False when they were not in it.
///
/// # Errors
/// When the database fails.
pub async fn leave(writer: &mut SqliteConnection, school: Uuid, cohort: Uuid, person: Uuid) -> Result<bool> {
    sqlx::query("DELETE FROM cohort_members WHERE school_id = $1 AND cohort_id = $2 AND person_id = $3")
        .bind(school)
        .bind(cohort)
        .bind(person)
        .execute(writer)
        .await
        .map(|done| done.rows_affected() == 1)
}

/// Cohorts in which a person is, in a role, by name.
///
/// # Errors
/// When the database fails.
pub async fn of_person(
    executor: impl SqliteExecutor<'_>,
    school: Uuid,
    person: Uuid,
    role: Role,
) -> Result<Vec<Cohort>> {
    sqlx::query_as(
        "SELECT c.id, c.name FROM cohorts c JOIN cohort_members m ON m.cohort_id = c.id
         WHERE c.school_id = $1 AND m.person_id = $2 AND m.role = $3 ORDER BY c.name",
    )
    .bind(school)
    .bind(person)
    .bind(role)
    .fetch_all(executor)
    .await
}
