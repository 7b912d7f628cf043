//! Cohorts, their members, and membership requests.

use std::collections::BTreeSet;

use model::ids::{CohortId, PersonId, SchoolId};
use model::training::membership::{MembershipAct, MembershipEvent, MembershipRequest};
use model::{Moment, Role, new_id};
use sqlx::FromRow;

use crate::{Connection, Executor, Json, Result};

/// A cohort.
#[derive(Clone, Debug, PartialEq, Eq, FromRow)]
pub struct Cohort {
    /// Id.
    pub id: CohortId,
    /// Name, unique in the school.
    pub name: String,
}

/// Returns the cohort with this name in a school, and creates it if it is missing.
pub async fn find_or_create(writer: &mut Connection, school: SchoolId, name: &str, now: Moment) -> Result<Cohort> {
    sqlx::query_as(
        "INSERT INTO cohorts (id, school_id, name, created_at) VALUES ($1, $2, $3, $4)
         ON CONFLICT (school_id, name) DO UPDATE SET name = excluded.name RETURNING id, name",
    )
    .bind(CohortId::made_at(now))
    .bind(school)
    .bind(name)
    .bind(now)
    .fetch_one(writer)
    .await
}

/// Returns a cohort of a school.
pub async fn find_cohort(executor: impl Executor<'_>, school: SchoolId, id: CohortId) -> Result<Option<Cohort>> {
    sqlx::query_as("SELECT id, name FROM cohorts WHERE school_id = $1 AND id = $2")
        .bind(school)
        .bind(id)
        .fetch_optional(executor)
        .await
}

/// Returns the cohorts of a school, sorted by name.
pub async fn list_cohorts(executor: impl Executor<'_>, school: SchoolId) -> Result<Vec<Cohort>> {
    sqlx::query_as("SELECT id, name FROM cohorts WHERE school_id = $1 ORDER BY name")
        .bind(school)
        .fetch_all(executor)
        .await
}

/// A person and a cohort that they belong to or are requested for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct MembershipKey {
    /// School.
    pub school_id: SchoolId,
    /// Cohort.
    pub cohort_id: CohortId,
    /// Person.
    pub person_id: PersonId,
}

/// A person's membership of a cohort.
#[derive(Clone, Copy, Debug)]
pub struct Membership {
    /// School of both.
    pub school_id: SchoolId,
    /// The cohort.
    pub cohort_id: CohortId,
    /// The person.
    pub person_id: PersonId,
    /// Role in the cohort: trainee or instructor.
    pub role: Role,
}

/// Author and time of a change to a membership.
#[derive(Clone, Copy, Debug)]
pub struct Attribution {
    /// Person who makes the change; `None` on the command line.
    pub by: Option<PersonId>,
    /// Time of the change.
    pub at: Moment,
}

/// Adds a person to a cohort, or changes their role in it. A pending membership request is deleted.
///
/// # Errors
/// If either belongs to another school, the role is neither trainee nor instructor, or the database
/// fails.
pub async fn join_cohort(writer: &mut Connection, membership: Membership, deed: Attribution) -> Result<()> {
    let Membership { school_id, cohort_id, person_id, role } = membership;
    sqlx::query(
        "INSERT INTO cohort_members (school_id, cohort_id, person_id, role) VALUES ($1, $2, $3, $4)
         ON CONFLICT (cohort_id, person_id) DO UPDATE SET role = excluded.role",
    )
    .bind(school_id)
    .bind(cohort_id)
    .bind(person_id)
    .bind(role)
    .execute(&mut *writer)
    .await?;
    forget_request(writer, MembershipKey { school_id, cohort_id, person_id }).await?;
    note_membership_act(writer, MembershipKey { school_id, cohort_id, person_id }, MembershipAct::Joined, deed).await
}

/// Returns those of the given people who are members of a cohort.
pub async fn list_members_among(
    executor: impl Executor<'_>,
    school: SchoolId,
    cohort: CohortId,
    people: &[PersonId],
) -> Result<BTreeSet<PersonId>> {
    let found: Vec<PersonId> = sqlx::query_scalar(
        "SELECT m.person_id FROM json_each($3) asked
         CROSS JOIN cohort_members m
         WHERE m.cohort_id = $2 AND m.person_id = unhex(asked.value, '-') AND m.school_id = $1",
    )
    .bind(school)
    .bind(cohort)
    .bind(Json(people))
    .fetch_all(executor)
    .await?;
    Ok(found.into_iter().collect())
}

/// Removes a person from a cohort. Returns false if they were not a member.
pub async fn leave_cohort(writer: &mut Connection, key: MembershipKey, deed: Attribution) -> Result<bool> {
    let left = sqlx::query("DELETE FROM cohort_members WHERE school_id = $1 AND cohort_id = $2 AND person_id = $3")
        .bind(key.school_id)
        .bind(key.cohort_id)
        .bind(key.person_id)
        .execute(&mut *writer)
        .await?;
    if left.rows_affected() == 0 {
        return Ok(false);
    }
    note_membership_act(writer, key, MembershipAct::Left, deed).await?;
    Ok(true)
}

/// Requests a person's membership. Returns false if they are already a member or already requested.
///
/// # Errors
/// If one of them belongs to another school, or the database fails.
pub async fn ask_for_member(writer: &mut Connection, key: MembershipKey, by: PersonId, at: Moment) -> Result<bool> {
    let asked = sqlx::query(
        "INSERT INTO cohort_requests (school_id, cohort_id, person_id, asked_by, asked_at)
         SELECT $1, $2, $3, $4, $5 WHERE NOT EXISTS (
           SELECT 1 FROM cohort_members WHERE cohort_id = $2 AND person_id = $3)
         ON CONFLICT (cohort_id, person_id) DO NOTHING",
    )
    .bind(key.school_id)
    .bind(key.cohort_id)
    .bind(key.person_id)
    .bind(by)
    .bind(at)
    .execute(&mut *writer)
    .await?;
    if asked.rows_affected() == 0 {
        return Ok(false);
    }
    note_membership_act(writer, key, MembershipAct::Asked, Attribution { by: Some(by), at }).await?;
    Ok(true)
}

/// Declines or withdraws a membership request. Returns false if it does not exist.
pub async fn decline_request(writer: &mut Connection, key: MembershipKey, deed: Attribution) -> Result<bool> {
    if !forget_request(writer, key).await? {
        return Ok(false);
    }
    note_membership_act(writer, key, MembershipAct::Declined, deed).await?;
    Ok(true)
}

async fn forget_request(writer: &mut Connection, key: MembershipKey) -> Result<bool> {
    sqlx::query("DELETE FROM cohort_requests WHERE school_id = $1 AND cohort_id = $2 AND person_id = $3")
        .bind(key.school_id)
        .bind(key.cohort_id)
        .bind(key.person_id)
        .execute(writer)
        .await
        .map(|done| done.rows_affected() == 1)
}

async fn note_membership_act(
    writer: &mut Connection,
    key: MembershipKey,
    act: MembershipAct,
    deed: Attribution,
) -> Result<()> {
    sqlx::query(
        "INSERT INTO cohort_acts (id, school_id, cohort_id, person_id, act, done_by, done_at)
         VALUES ($1, $2, $3, $4, $5, $6, $7)",
    )
    .bind(new_id(deed.at))
    .bind(key.school_id)
    .bind(key.cohort_id)
    .bind(key.person_id)
    .bind(act)
    .bind(deed.by)
    .bind(deed.at)
    .execute(writer)
    .await
    .map(drop)
}

/// Returns the pending membership requests of a school, optionally only those for one cohort or one
/// person, oldest first; at most 200.
pub async fn list_membership_requests(
    executor: impl Executor<'_>,
    school: SchoolId,
    cohort: Option<CohortId>,
    person: Option<PersonId>,
) -> Result<Vec<MembershipRequest>> {
    sqlx::query_as(
        "SELECT q.cohort_id, c.name AS cohort, q.person_id, p.display_name AS person, p.role,
           a.display_name AS asked_by, q.asked_at
         FROM cohort_requests q
         JOIN cohorts c ON c.school_id = q.school_id AND c.id = q.cohort_id
         JOIN people p ON p.school_id = q.school_id AND p.id = q.person_id AND p.disabled_at IS NULL
         JOIN people a ON a.school_id = q.school_id AND a.id = q.asked_by
         WHERE q.school_id = $1 AND ($2 IS NULL OR q.cohort_id = $2) AND ($3 IS NULL OR q.person_id = $3)
         ORDER BY q.asked_at, q.person_id LIMIT 200",
    )
    .bind(school)
    .bind(cohort)
    .bind(person)
    .fetch_all(executor)
    .await
}

/// Returns the latest changes to a person's cohort memberships, latest first; at most 50.
pub async fn list_membership_acts(
    executor: impl Executor<'_>,
    school: SchoolId,
    person: PersonId,
) -> Result<Vec<MembershipEvent>> {
    sqlx::query_as(
        "SELECT c.name AS cohort, d.act, p.display_name AS \"by\", d.done_at FROM cohort_acts d
         JOIN cohorts c ON c.school_id = d.school_id AND c.id = d.cohort_id
         LEFT JOIN people p ON p.school_id = d.school_id AND p.id = d.done_by
         WHERE d.school_id = $1 AND d.person_id = $2 ORDER BY d.done_at DESC, d.id DESC LIMIT 50",
    )
    .bind(school)
    .bind(person)
    .fetch_all(executor)
    .await
}

/// Returns the cohorts in which a person has a role, sorted by name.
pub async fn list_cohorts_of_person(
    executor: impl Executor<'_>,
    school: SchoolId,
    person: PersonId,
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
