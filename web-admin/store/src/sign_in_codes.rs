//! The codes by which people sign in at a station: only their hashes are here.

use model::ids::{PersonId, SchoolId};
use model::{Moment, PersonKey};

use super::people::Person;
use super::{Connection, Executor, Result};

/// Gives a person a code, in place of the one they had. False when somebody of the school has the same.
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

/// Whose code this is.
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

/// Since when a person has had their code.
pub async fn find_code_time(executor: impl Executor<'_>, school: SchoolId, person: PersonId) -> Result<Option<Moment>> {
    sqlx::query_scalar("SELECT made_at FROM sign_in_codes WHERE school_id = $1 AND person_id = $2")
        .bind(school)
        .bind(person)
        .fetch_optional(executor)
        .await
}

/// Ends the code of a person.
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
