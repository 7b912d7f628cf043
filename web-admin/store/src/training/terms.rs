//! Terms of a school and the cohorts that belong to them.

use model::Moment;
use model::ids::{CohortId, PersonId, SchoolId, TermId};
use model::training::term::{CohortTerm, Term};

use crate::{Connection, Executor, Result};

/// A term to be stored.
#[derive(Clone, Copy, Debug)]
pub struct NewTerm<'a> {
    /// Name.
    pub name: &'a str,
    /// First day, as 2026-10-12.
    pub starts_on: &'a str,
    /// When that day begins.
    pub starts_at: Moment,
}

/// Stores a term. Returns its id; `None` if another term of the school has the name.
pub async fn add_term(
    writer: &mut Connection,
    school: SchoolId,
    new: NewTerm<'_>,
    now: Moment,
) -> Result<Option<TermId>> {
    sqlx::query_scalar(
        "INSERT INTO terms (id, school_id, name, starts_on, starts_at) VALUES ($1, $2, $3, $4, $5)
         ON CONFLICT (school_id, name) DO NOTHING RETURNING id",
    )
    .bind(TermId::made_at(now))
    .bind(school)
    .bind(new.name)
    .bind(new.starts_on)
    .bind(new.starts_at)
    .fetch_optional(writer)
    .await
}

/// Deletes a term; the cohorts that belonged to it belong to none.
pub async fn remove_term(writer: &mut Connection, school: SchoolId, id: TermId) -> Result<bool> {
    sqlx::query("DELETE FROM cohort_terms WHERE school_id = $1 AND term_id = $2")
        .bind(school)
        .bind(id)
        .execute(&mut *writer)
        .await?;
    sqlx::query("DELETE FROM terms WHERE school_id = $1 AND id = $2")
        .bind(school)
        .bind(id)
        .execute(writer)
        .await
        .map(|done| done.rows_affected() == 1)
}

/// Returns the terms of a school, latest first.
pub async fn list_terms(executor: impl Executor<'_>, school: SchoolId) -> Result<Vec<Term>> {
    sqlx::query_as(
        "SELECT t.id, t.name, t.starts_on, t.starts_at,
           (SELECT count(*) FROM cohort_terms c WHERE c.school_id = t.school_id AND c.term_id = t.id) AS cohorts
         FROM terms t WHERE t.school_id = $1 ORDER BY t.starts_at DESC, t.name",
    )
    .bind(school)
    .fetch_all(executor)
    .await
}

/// Sets the term of a cohort, or removes it.
///
/// # Errors
/// If either belongs to another school, or the database fails.
pub async fn put_cohort_term(
    writer: &mut Connection,
    school: SchoolId,
    cohort: CohortId,
    term: Option<TermId>,
) -> Result<()> {
    sqlx::query("DELETE FROM cohort_terms WHERE school_id = $1 AND cohort_id = $2")
        .bind(school)
        .bind(cohort)
        .execute(&mut *writer)
        .await?;
    if let Some(term) = term {
        sqlx::query("INSERT INTO cohort_terms (cohort_id, school_id, term_id) VALUES ($1, $2, $3)")
            .bind(cohort)
            .bind(school)
            .bind(term)
            .execute(writer)
            .await?;
    }
    Ok(())
}

/// Returns the cohorts of a school that belong to a term, the latest term first.
pub async fn list_cohort_terms(executor: impl Executor<'_>, school: SchoolId) -> Result<Vec<CohortTerm>> {
    sqlx::query_as(
        "SELECT b.cohort_id, c.name AS cohort, b.term_id, t.name AS term, t.starts_at
         FROM terms t CROSS JOIN cohort_terms b CROSS JOIN cohorts c
         WHERE t.school_id = $1 AND b.school_id = t.school_id AND b.term_id = t.id
           AND c.school_id = b.school_id AND c.id = b.cohort_id
         ORDER BY t.starts_at DESC, c.name",
    )
    .bind(school)
    .fetch_all(executor)
    .await
}

/// Returns the trainees of a cohort, including those whose account is disabled or erased.
pub async fn list_cohort_trainees(
    executor: impl Executor<'_>,
    school: SchoolId,
    cohort: CohortId,
) -> Result<Vec<PersonId>> {
    sqlx::query_scalar(
        "SELECT person_id FROM cohort_members WHERE school_id = $1 AND cohort_id = $2 AND role = 'trainee'",
    )
    .bind(school)
    .bind(cohort)
    .fetch_all(executor)
    .await
}
