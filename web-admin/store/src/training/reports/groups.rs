//! Cohorts and trainees that a person may see.

use std::collections::BTreeMap;

use model::ids::{CohortId, PersonId, SchoolId};
use model::training::cohort::CohortSummary;
use model::{CurrentPerson, Role};
use sqlx::FromRow;

use crate::{Executor, Result};

/// An id with a name.
#[derive(Clone, Debug, PartialEq, Eq, FromRow)]
pub struct NamedItem<Id> {
    /// Id of a person or a cohort.
    pub id: Id,
    /// Name.
    pub name: String,
}

/// Selects cohorts of school `$1` that person `$2` teaches, or all if `$3`.
macro_rules! cohorts {
    ($rest:literal) => {
        concat!(
            "SELECT c.id, c.name FROM cohorts c WHERE c.school_id = $1 AND ($3 OR EXISTS (SELECT 1 FROM cohort_members m
               WHERE m.cohort_id = c.id AND m.person_id = $2 AND m.role = 'instructor')) ",
            $rest
        )
    };
}

/// Returns the cohorts that a person may see: those they teach, or all of the school for an
/// administrator.
pub async fn cohorts(executor: impl Executor<'_>, viewer: &CurrentPerson) -> Result<Vec<NamedItem<CohortId>>> {
    sqlx::query_as(cohorts!("ORDER BY c.name"))
        .bind(viewer.school_id)
        .bind(viewer.id)
        .bind(viewer.role == Role::Administrator)
        .fetch_all(executor)
        .await
}

/// Returns one of the cohorts that a person may see; see [`cohorts`].
pub async fn cohort(
    executor: impl Executor<'_>,
    viewer: &CurrentPerson,
    id: CohortId,
) -> Result<Option<NamedItem<CohortId>>> {
    sqlx::query_as(cohorts!("AND c.id = $4"))
        .bind(viewer.school_id)
        .bind(viewer.id)
        .bind(viewer.role == Role::Administrator)
        .bind(id)
        .fetch_optional(executor)
        .await
}

/// Returns summaries of the cohorts that a person may see, sorted by name, starting after `after`.
pub async fn cohorts_in_short(
    executor: impl Executor<'_>,
    viewer: &CurrentPerson,
    after: &str,
    limit: u32,
) -> Result<Vec<CohortSummary>> {
    sqlx::query_as(
        "SELECT c.id, c.name,
           (SELECT count(*) FROM cohort_members m WHERE m.cohort_id = c.id AND m.role = 'trainee') AS trainees,
           (SELECT CAST(coalesce(sum(t.attempts), 0) AS BIGINT) FROM tallies t
             WHERE t.school_id = c.school_id AND t.cohort_id = c.id) AS attempts,
           (SELECT CAST(coalesce(sum(t.passes), 0) AS BIGINT) FROM tallies t
             WHERE t.school_id = c.school_id AND t.cohort_id = c.id) AS passes
         FROM cohorts c WHERE c.school_id = $1 AND c.name > $4 AND ($3 OR EXISTS (SELECT 1 FROM cohort_members m
           WHERE m.cohort_id = c.id AND m.person_id = $2 AND m.role = 'instructor')) ORDER BY c.name LIMIT $5 + 0",
    )
    .bind(viewer.school_id)
    .bind(viewer.id)
    .bind(viewer.role == Role::Administrator)
    .bind(after)
    .bind(i64::from(limit))
    .fetch_all(executor)
    .await
}

/// Returns the enabled members of a cohort with a role, sorted by name.
pub async fn members(
    executor: impl Executor<'_>,
    school: SchoolId,
    cohort: CohortId,
    role: Role,
) -> Result<Vec<NamedItem<PersonId>>> {
    sqlx::query_as(
        "SELECT p.id, p.display_name AS name FROM cohort_members m
         JOIN people p ON p.school_id = m.school_id AND p.id = m.person_id
         WHERE m.school_id = $1 AND m.cohort_id = $2 AND m.role = $3 AND p.disabled_at IS NULL
         ORDER BY p.display_name, p.id",
    )
    .bind(school)
    .bind(cohort)
    .bind(role)
    .fetch_all(executor)
    .await
}

/// Returns the known registration numbers of a cohort's trainees.
pub async fn registrar_ids(
    executor: impl Executor<'_>,
    school: SchoolId,
    cohort: CohortId,
) -> Result<BTreeMap<PersonId, String>> {
    let rows: Vec<(PersonId, String)> = sqlx::query_as(
        "SELECT p.id, p.registrar_id FROM cohort_members m
         JOIN people p ON p.school_id = m.school_id AND p.id = m.person_id
         WHERE m.school_id = $1 AND m.cohort_id = $2 AND m.role = 'trainee' AND p.registrar_id IS NOT NULL",
    )
    .bind(school)
    .bind(cohort)
    .fetch_all(executor)
    .await?;
    Ok(rows.into_iter().collect())
}

/// Returns the pseudonyms of a cohort's trainees, which distinguish people with equal names in a
/// file and identify their recordings.
pub async fn pseudonyms(
    executor: impl Executor<'_>,
    school: SchoolId,
    cohort: CohortId,
) -> Result<BTreeMap<PersonId, String>> {
    let found: Vec<(PersonId, String)> = sqlx::query_as(
        "SELECT p.id, p.pseudonym FROM cohort_members m
         JOIN people p ON p.school_id = m.school_id AND p.id = m.person_id
         WHERE m.school_id = $1 AND m.cohort_id = $2 AND m.role = 'trainee'",
    )
    .bind(school)
    .bind(cohort)
    .fetch_all(executor)
    .await?;
    Ok(found.into_iter().collect())
}

/// Returns a person whose practice the viewer may see: themselves, a trainee of a cohort they
/// teach, or for an administrator any trainee.
pub async fn trainee(
    executor: impl Executor<'_>,
    viewer: &CurrentPerson,
    id: PersonId,
) -> Result<Option<NamedItem<PersonId>>> {
    sqlx::query_as(
        "SELECT p.id, p.display_name AS name FROM people p
         WHERE p.school_id = $1 AND p.id = $3 AND (p.id = $2 OR p.role = 'trainee' AND ($4 OR EXISTS (
           SELECT 1 FROM taught_trainees taught WHERE taught.teacher_id = $2 AND taught.trainee_id = p.id)))",
    )
    .bind(viewer.school_id)
    .bind(viewer.id)
    .bind(id)
    .bind(viewer.role == Role::Administrator)
    .fetch_optional(executor)
    .await
}
