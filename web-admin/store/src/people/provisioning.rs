//! Provisioning by directories: their tokens, and people and cohorts as they see them.

use model::ids::{CohortId, PersonId, ProvisioningTokenId, SchoolId};
use model::people::email::normalize_email;
use model::people::scim::{ScimGroup, ScimUser};
use model::{Moment, PersonKey, count_u32};
use sqlx::FromRow;

use crate::{Connection, Executor, Result};

/// A token of a directory.
#[derive(Clone, Debug, PartialEq, Eq, FromRow)]
pub struct ProvisioningToken {
    /// Id.
    pub id: ProvisioningTokenId,
    /// School.
    pub school_id: SchoolId,
    /// Name.
    pub name: String,
    /// Whether it may disable instructors and administrators.
    pub may_disable_staff: bool,
    /// Time of creation.
    pub made_at: Moment,
    /// Expiry.
    pub expires_at: Moment,
    /// Time of the last use, to the hour.
    pub last_used_at: Option<Moment>,
}

/// Stores a token.
pub async fn add_token(writer: &mut Connection, token: &ProvisioningToken, token_sha256: &[u8; 32]) -> Result<()> {
    sqlx::query(
        "INSERT INTO provisioning_tokens (id, school_id, name, token_sha256, may_disable_staff, made_at, expires_at)
         VALUES ($1, $2, $3, $4, $5, $6, $7)",
    )
    .bind(token.id)
    .bind(token.school_id)
    .bind(&token.name)
    .bind(token_sha256.as_slice())
    .bind(token.may_disable_staff)
    .bind(token.made_at)
    .bind(token.expires_at)
    .execute(writer)
    .await
    .map(drop)
}

/// Returns the token with this hash, unless it was revoked. It may have expired.
pub async fn find_token(executor: impl Executor<'_>, token_sha256: &[u8; 32]) -> Result<Option<ProvisioningToken>> {
    sqlx::query_as(
        "SELECT id, school_id, name, may_disable_staff, made_at, expires_at, last_used_at FROM provisioning_tokens
         WHERE token_sha256 = $1 AND revoked_at IS NULL",
    )
    .bind(token_sha256.as_slice())
    .fetch_optional(executor)
    .await
}

/// Returns the tokens of a school that were not revoked, newest first.
pub async fn list_tokens(executor: impl Executor<'_>, school: SchoolId) -> Result<Vec<ProvisioningToken>> {
    sqlx::query_as(
        "SELECT id, school_id, name, may_disable_staff, made_at, expires_at, last_used_at FROM provisioning_tokens
         WHERE school_id = $1 AND revoked_at IS NULL ORDER BY made_at DESC, id DESC",
    )
    .bind(school)
    .fetch_all(executor)
    .await
}

/// Records the use of a token.
pub async fn note_token_use(writer: &mut Connection, id: ProvisioningTokenId, now: Moment) -> Result<()> {
    sqlx::query("UPDATE provisioning_tokens SET last_used_at = $2 WHERE id = $1")
        .bind(id)
        .bind(now)
        .execute(writer)
        .await
        .map(drop)
}

/// Revokes a token. Returns false if it does not exist or was already revoked.
pub async fn revoke_token(
    writer: &mut Connection,
    school: SchoolId,
    id: ProvisioningTokenId,
    now: Moment,
) -> Result<bool> {
    sqlx::query(
        "UPDATE provisioning_tokens SET revoked_at = $3 WHERE school_id = $1 AND id = $2 AND revoked_at IS NULL",
    )
    .bind(school)
    .bind(id)
    .bind(now)
    .execute(writer)
    .await
    .map(|done| done.rows_affected() == 1)
}

/// Selects people of school `$1` whom its directory may see.
macro_rules! select_users {
    ($rest:literal) => {
        concat!(
            "SELECT p.id, coalesce(v.user_name, p.email) AS user_name, p.display_name, p.registrar_id AS external_id, p.email,
               p.role, p.disabled_at
             FROM people p LEFT JOIN provisioned_people v ON v.school_id = p.school_id AND v.person_id = p.id
             WHERE p.school_id = $1 AND p.role <> 'guest' AND p.erased_at IS NULL AND v.deleted_at IS NULL ",
            $rest
        )
    };
}

/// Returns a person.
pub async fn find_user(executor: impl Executor<'_>, school: SchoolId, id: PersonId) -> Result<Option<ScimUser>> {
    sqlx::query_as(select_users!("AND p.id = $2")).bind(school).bind(id).fetch_optional(executor).await
}

/// Returns the people with a unique name, in any case.
pub async fn list_users_by_name(executor: impl Executor<'_>, school: SchoolId, name: &str) -> Result<Vec<ScimUser>> {
    sqlx::query_as(select_users!(
        "AND p.id IN (SELECT person_id FROM provisioned_people WHERE school_id = $1 AND user_name_key = $2
                      UNION ALL SELECT id FROM people WHERE school_id = $1 AND email = $3)"
    ))
    .bind(school)
    .bind(name.to_lowercase())
    .bind(normalize_email(name))
    .fetch_all(executor)
    .await
}

/// Returns the person with a registration number.
pub async fn find_user_by_number(
    executor: impl Executor<'_>,
    school: SchoolId,
    number: &str,
) -> Result<Option<ScimUser>> {
    sqlx::query_as(select_users!("AND p.registrar_id = $2")).bind(school).bind(number).fetch_optional(executor).await
}

/// Returns people by id, from an offset.
pub async fn list_users(
    executor: impl Executor<'_>,
    school: SchoolId,
    offset: u32,
    limit: u32,
) -> Result<Vec<ScimUser>> {
    sqlx::query_as(select_users!("ORDER BY p.id LIMIT $2 + 0 OFFSET $3 + 0"))
        .bind(school)
        .bind(i64::from(limit))
        .bind(i64::from(offset))
        .fetch_all(executor)
        .await
}

/// Returns the number of people.
pub async fn count_users(executor: impl Executor<'_>, school: SchoolId) -> Result<u32> {
    let count: i64 = sqlx::query_scalar(
        "SELECT count(*) FROM people p LEFT JOIN provisioned_people v ON v.school_id = p.school_id AND v.person_id = p.id
         WHERE p.school_id = $1 AND p.role <> 'guest' AND p.erased_at IS NULL AND v.deleted_at IS NULL",
    )
    .bind(school)
    .fetch_one(executor)
    .await?;
    Ok(count_u32(count))
}

/// Returns who was deleted by the directory and had a unique name.
pub async fn find_deleted_user(
    executor: impl Executor<'_>,
    school: SchoolId,
    user_name: &str,
) -> Result<Option<PersonId>> {
    sqlx::query_scalar(
        "SELECT v.person_id FROM provisioned_people v JOIN people p ON p.id = v.person_id
         WHERE v.school_id = $1 AND v.user_name_key = $2 AND v.deleted_at IS NOT NULL AND p.erased_at IS NULL",
    )
    .bind(school)
    .bind(user_name.to_lowercase())
    .fetch_optional(executor)
    .await
}

/// Stores the unique name of a person. Returns false if another person has it.
pub async fn put_user_name(writer: &mut Connection, key: PersonKey, user_name: &str) -> Result<bool> {
    let is_taken: bool = sqlx::query_scalar(
        "SELECT EXISTS (SELECT 1 FROM provisioned_people WHERE school_id = $1 AND user_name_key = $3 AND person_id <> $2)
             OR EXISTS (SELECT 1 FROM people p WHERE p.school_id = $1 AND p.email = $4 AND p.id <> $2
                        AND NOT EXISTS (SELECT 1 FROM provisioned_people v WHERE v.school_id = $1 AND v.person_id = p.id))",
    )
    .bind(key.school_id)
    .bind(key.person_id)
    .bind(user_name.to_lowercase())
    .bind(normalize_email(user_name))
    .fetch_one(&mut *writer)
    .await?;
    if is_taken {
        return Ok(false);
    }
    sqlx::query(
        "INSERT INTO provisioned_people (school_id, person_id, user_name, user_name_key) VALUES ($1, $2, $3, $4)
         ON CONFLICT (person_id) DO UPDATE SET user_name = excluded.user_name, user_name_key = excluded.user_name_key,
           deleted_at = NULL",
    )
    .bind(key.school_id)
    .bind(key.person_id)
    .bind(user_name)
    .bind(user_name.to_lowercase())
    .execute(writer)
    .await
    .map(|done| done.rows_affected() == 1)
}

/// Hides a person from the directory, because it has deleted them.
pub async fn hide_user(writer: &mut Connection, key: PersonKey, user_name: &str, now: Moment) -> Result<()> {
    sqlx::query(
        "INSERT INTO provisioned_people (school_id, person_id, user_name, user_name_key, deleted_at)
         VALUES ($1, $2, $3, $4, $5) ON CONFLICT (person_id) DO UPDATE SET deleted_at = excluded.deleted_at",
    )
    .bind(key.school_id)
    .bind(key.person_id)
    .bind(user_name)
    .bind(user_name.to_lowercase())
    .bind(now)
    .execute(writer)
    .await
    .map(drop)
}

/// Changes what a directory may change of a person.
pub async fn change_user(writer: &mut Connection, key: PersonKey, number: Option<&str>, search: &str) -> Result<()> {
    sqlx::query("UPDATE people SET registrar_id = $3, search = $4 WHERE school_id = $1 AND id = $2")
        .bind(key.school_id)
        .bind(key.person_id)
        .bind(number)
        .bind(search)
        .execute(writer)
        .await
        .map(drop)
}

/// Returns the number of enabled administrators of a school.
pub async fn count_administrators(executor: impl Executor<'_>, school: SchoolId) -> Result<i64> {
    sqlx::query_scalar(
        "SELECT count(*) FROM people WHERE school_id = $1 AND role = 'administrator' AND disabled_at IS NULL",
    )
    .bind(school)
    .fetch_one(executor)
    .await
}

#[derive(FromRow)]
struct GroupRow {
    id: CohortId,
    name: String,
    external_id: Option<String>,
}

impl From<GroupRow> for ScimGroup {
    fn from(row: GroupRow) -> Self {
        Self { id: row.id, name: row.name, external_id: row.external_id, members: Vec::new() }
    }
}

/// Selects cohorts of school `$1` that its directory may see.
macro_rules! select_groups {
    ($rest:literal) => {
        concat!(
            "SELECT c.id, c.name, g.external_id FROM cohorts c
             LEFT JOIN provisioned_cohorts g ON g.school_id = c.school_id AND g.cohort_id = c.id
             WHERE c.school_id = $1 AND g.deleted_at IS NULL ",
            $rest
        )
    };
}

/// Returns the cohorts of a school by name, without their members.
pub async fn list_groups(executor: impl Executor<'_>, school: SchoolId) -> Result<Vec<ScimGroup>> {
    let rows: Vec<GroupRow> =
        sqlx::query_as(select_groups!("ORDER BY c.name, c.id")).bind(school).fetch_all(executor).await?;
    Ok(rows.into_iter().map(ScimGroup::from).collect())
}

/// Returns a cohort, without its members.
pub async fn find_group(executor: impl Executor<'_>, school: SchoolId, id: CohortId) -> Result<Option<ScimGroup>> {
    let row: Option<GroupRow> =
        sqlx::query_as(select_groups!("AND c.id = $2")).bind(school).bind(id).fetch_optional(executor).await?;
    Ok(row.map(ScimGroup::from))
}

/// Returns the trainees of a cohort, by id.
pub async fn list_group_members(
    executor: impl Executor<'_>,
    school: SchoolId,
    cohort: CohortId,
) -> Result<Vec<PersonId>> {
    sqlx::query_scalar(
        "SELECT m.person_id FROM cohort_members m WHERE m.school_id = $1 AND m.cohort_id = $2 AND m.role = 'trainee'
         ORDER BY m.person_id",
    )
    .bind(school)
    .bind(cohort)
    .fetch_all(executor)
    .await
}

/// Stores the name of a cohort, its id in the directory, and whether the directory has deleted it.
pub async fn put_group(
    writer: &mut Connection,
    school: SchoolId,
    group: &ScimGroup,
    deleted_at: Option<Moment>,
) -> Result<()> {
    sqlx::query("UPDATE cohorts SET name = $3 WHERE school_id = $1 AND id = $2 AND name <> $3")
        .bind(school)
        .bind(group.id)
        .bind(&group.name)
        .execute(&mut *writer)
        .await?;
    sqlx::query(
        "INSERT INTO provisioned_cohorts (school_id, cohort_id, external_id, deleted_at) VALUES ($1, $2, $3, $4)
         ON CONFLICT (cohort_id) DO UPDATE SET external_id = excluded.external_id, deleted_at = excluded.deleted_at",
    )
    .bind(school)
    .bind(group.id)
    .bind(&group.external_id)
    .bind(deleted_at)
    .execute(writer)
    .await
    .map(drop)
}
