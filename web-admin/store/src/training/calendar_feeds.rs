//! Secret addresses of calendars. Only the hashes of their secrets are stored.

use model::ids::{PersonId, SchoolId};
use model::{Moment, PersonKey};
use sqlx::FromRow;

use crate::{Connection, Executor, Result};

/// Sets or replaces the address of a person's calendar.
pub async fn put_feed(writer: &mut Connection, owner: PersonKey, secret_sha256: &[u8; 32], now: Moment) -> Result<()> {
    sqlx::query(
        "INSERT INTO calendar_feeds (school_id, person_id, secret_sha256, made_at) VALUES ($1, $2, $3, $4)
         ON CONFLICT (person_id) DO UPDATE SET secret_sha256 = excluded.secret_sha256, made_at = excluded.made_at",
    )
    .bind(owner.school_id)
    .bind(owner.person_id)
    .bind(secret_sha256.as_slice())
    .bind(now)
    .execute(writer)
    .await
    .map(drop)
}

/// Returns when the address of a person's calendar was created.
pub async fn find_feed_time(executor: impl Executor<'_>, owner: PersonKey) -> Result<Option<Moment>> {
    sqlx::query_scalar("SELECT made_at FROM calendar_feeds WHERE school_id = $1 AND person_id = $2")
        .bind(owner.school_id)
        .bind(owner.person_id)
        .fetch_optional(executor)
        .await
}

/// The owner of a calendar.
#[derive(Clone, Debug, PartialEq, Eq, FromRow)]
pub struct FeedOwner {
    /// School.
    pub school_id: SchoolId,
    /// The person.
    pub person_id: PersonId,
    /// Name of the school.
    pub school: String,
    /// Code of the language chosen by the person, or else by the school.
    pub language: Option<String>,
}

/// Returns whose calendar has this secret, unless they are disabled or erased.
pub async fn find_feed_owner(executor: impl Executor<'_>, secret_sha256: &[u8; 32]) -> Result<Option<FeedOwner>> {
    sqlx::query_as(
        "SELECT f.school_id, f.person_id, s.name AS school, coalesce(p.language, s.letter_language) AS language
         FROM calendar_feeds f JOIN people p ON p.school_id = f.school_id AND p.id = f.person_id
         JOIN schools s ON s.id = f.school_id
         WHERE f.secret_sha256 = $1 AND p.disabled_at IS NULL AND p.erased_at IS NULL",
    )
    .bind(secret_sha256.as_slice())
    .fetch_optional(executor)
    .await
}

/// Deletes the address of a person's calendar. Returns false if there is none.
pub async fn end_feed(writer: &mut Connection, owner: PersonKey) -> Result<bool> {
    sqlx::query("DELETE FROM calendar_feeds WHERE school_id = $1 AND person_id = $2")
        .bind(owner.school_id)
        .bind(owner.person_id)
        .execute(writer)
        .await
        .map(|done| done.rows_affected() == 1)
}
