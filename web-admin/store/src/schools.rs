//! Schools.

use model::ids::SchoolId;
use model::{Moment, Needed};
use sqlx::{FromRow, SqliteConnection, SqliteExecutor};

use super::Result;

/// A school.
#[derive(Clone, Debug, PartialEq, Eq, FromRow)]
pub struct School {
    /// Id.
    pub id: SchoolId,
    /// Name, unique.
    pub name: String,
}

/// Every school, by name.
pub async fn list_schools(executor: impl SqliteExecutor<'_>) -> Result<Vec<School>> {
    sqlx::query_as("SELECT id, name FROM schools ORDER BY name").fetch_all(executor).await
}

/// The name of a school.
///
/// # Errors
/// When there is none, or the database fails.
pub async fn find_school_name(executor: impl SqliteExecutor<'_>, id: SchoolId) -> Result<String> {
    sqlx::query_scalar("SELECT name FROM schools WHERE id = $1").bind(id).fetch_one(executor).await
}

/// The time zone of a school, a name of the IANA database.
///
/// # Errors
/// When there is none, or the database fails.
pub async fn find_time_zone(executor: impl SqliteExecutor<'_>, id: SchoolId) -> Result<String> {
    sqlx::query_scalar("SELECT time_zone FROM schools WHERE id = $1").bind(id).fetch_one(executor).await
}

/// Sets the time zone of a school.
pub async fn set_time_zone(writer: &mut SqliteConnection, id: SchoolId, zone: &str) -> Result<()> {
    sqlx::query("UPDATE schools SET time_zone = $2 WHERE id = $1").bind(id).bind(zone).execute(writer).await.map(drop)
}

/// What must be proved of an attempt for it to count towards a certificate of a school.
///
/// # Errors
/// When there is none, or the database fails.
pub async fn certificate_needs(executor: impl SqliteExecutor<'_>, id: SchoolId) -> Result<Needed> {
    sqlx::query_scalar("SELECT certificate_needs FROM schools WHERE id = $1").bind(id).fetch_one(executor).await
}

/// Sets what must be proved of an attempt for it to count towards a certificate.
pub async fn set_certificate_needs(writer: &mut SqliteConnection, id: SchoolId, needed: Needed) -> Result<()> {
    sqlx::query("UPDATE schools SET certificate_needs = $2 WHERE id = $1")
        .bind(id)
        .bind(needed)
        .execute(writer)
        .await
        .map(drop)
}

/// Whether the recordings of a school go with whoever made them.
///
/// # Errors
/// When there is none, or the database fails.
pub async fn erases_recordings(executor: impl SqliteExecutor<'_>, id: SchoolId) -> Result<bool> {
    sqlx::query_scalar("SELECT erase_recordings FROM schools WHERE id = $1").bind(id).fetch_one(executor).await
}

/// The school of a name, made where it is missing.
pub async fn find_or_create(writer: &mut SqliteConnection, name: &str, now: Moment) -> Result<School> {
    sqlx::query_as(
        "INSERT INTO schools (id, name, created_at) VALUES ($1, $2, $3)
         ON CONFLICT (name) DO UPDATE SET name = excluded.name RETURNING id, name",
    )
    .bind(SchoolId::made_at(now))
    .bind(name)
    .bind(now)
    .fetch_one(writer)
    .await
}

/// Whether there is more than one.
pub async fn are_schools_several(executor: impl SqliteExecutor<'_>) -> Result<bool> {
    sqlx::query_scalar("SELECT count(*) > 1 FROM (SELECT 1 FROM schools LIMIT 2)").fetch_one(executor).await
}
