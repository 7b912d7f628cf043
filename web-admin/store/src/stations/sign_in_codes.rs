//! Codes for signing in at stations. Only their hashes are stored.

use model::ids::{PersonId, SchoolId};
use model::{Moment, PersonKey};

use crate::people::Person;
use crate::{Connection, Executor, Result};

/// Sets or replaces a person's code. Returns false if another person of the school has the same
/// one.
pub async fn put_sign_in_code(
    writer: &mut Connection,
    PersonKey { school_id: school, person_id: person }: PersonKey,
    code_hash: &[u8; 32],
    now: Moment,
) -> Result<bool> {
    sqlx::query(
        "INSERT INTO sign_in_codes (school_id, person_id, code_hash, made_at) SELECT $1, $2, $3, $4
         WHERE NOT EXISTS (SELECT 1 FROM sign_in_codes WHERE school_id = $1 AND code_hash = $3 AND person_id <> $2)
         ON CONFLICT (person_id) DO UPDATE SET code_hash = excluded.code_hash, made_at = excluded.made_at",
    )
    .bind(school)
    .bind(person)
    .bind(code_hash.as_slice())
    .bind(now)
    .execute(writer)
    .await
    .map(|done| done.rows_affected() == 1)
}

/// Returns the person with this code.
pub async fn find_code_holder(
    executor: impl Executor<'_>,
    school: SchoolId,
    code_hash: &[u8; 32],
) -> Result<Option<Person>> {
    sqlx::query_as(
        "SELECT p.id, p.school_id, p.role, p.email, p.display_name, p.pseudonym, p.credential_version, p.disabled_at,
           p.language
         FROM sign_in_codes c JOIN people p ON p.school_id = c.school_id AND p.id = c.person_id
         WHERE c.school_id = $1 AND c.code_hash = $2",
    )
    .bind(school)
    .bind(code_hash.as_slice())
    .fetch_optional(executor)
    .await
}

/// Returns the time at which a person's code was made.
pub async fn find_code_time(executor: impl Executor<'_>, school: SchoolId, person: PersonId) -> Result<Option<Moment>> {
    sqlx::query_scalar("SELECT made_at FROM sign_in_codes WHERE school_id = $1 AND person_id = $2")
        .bind(school)
        .bind(person)
        .fetch_optional(executor)
        .await
}

/// Deletes a person's code.
pub async fn end_sign_in_code(
    writer: &mut Connection,
    PersonKey { school_id: school, person_id: person }: PersonKey,
) -> Result<()> {
    sqlx::query("DELETE FROM sign_in_codes WHERE school_id = $1 AND person_id = $2")
        .bind(school)
        .bind(person)
        .execute(writer)
        .await
        .map(drop)
}
