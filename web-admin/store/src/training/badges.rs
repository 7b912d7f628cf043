//! Issued badges, and their places in the status lists.

use model::ids::{BadgeId, PersonId, SchoolId};
use model::{Moment, Needed, PersonKey};
use sqlx::FromRow;

use crate::{Connection, Executor, Result};

/// The mastery that a badge certifies. A person has one valid badge for each.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct BadgeGround<'a> {
    /// The person who mastered the course.
    pub person: PersonKey,
    /// Id of the course.
    pub curriculum_id: &'a str,
    /// SHA-256 of the mastered revision.
    pub curriculum_sha256: &'a str,
    /// Evidence that the counted attempts have.
    pub needed: Needed,
}

/// An issued badge.
#[derive(Clone, Copy, Debug, PartialEq, Eq, FromRow)]
pub struct StoredBadge {
    /// Id.
    pub id: BadgeId,
    /// Place in the status lists, counted through all lists.
    pub place: i64,
}

/// A badge that was not revoked.
#[derive(Clone, Debug, PartialEq, Eq, FromRow)]
pub struct ValidBadge {
    /// Place in the status lists.
    pub place: i64,
    /// School of the person.
    pub school_id: SchoolId,
    /// The person.
    pub person_id: PersonId,
    /// Id of the mastered course.
    pub curriculum_id: String,
    /// Evidence that the counted attempts have.
    pub needed: Needed,
}

/// Returns the valid badge for a mastery.
pub async fn find_badge(executor: impl Executor<'_>, ground: BadgeGround<'_>) -> Result<Option<StoredBadge>> {
    sqlx::query_as(
        "SELECT id, place FROM badges
         WHERE school_id = $1 AND person_id = $2 AND curriculum_sha256 = $3 AND needed = $4 AND revoked_at IS NULL",
    )
    .bind(ground.person.school_id)
    .bind(ground.person.person_id)
    .bind(ground.curriculum_sha256)
    .bind(ground.needed)
    .fetch_optional(executor)
    .await
}

/// Stores a badge at the next free place.
pub async fn add_badge(writer: &mut Connection, ground: BadgeGround<'_>, now: Moment) -> Result<StoredBadge> {
    sqlx::query_as(
        "INSERT INTO badges (place, id, school_id, person_id, curriculum_id, curriculum_sha256, needed, issued_at)
         SELECT coalesce(max(place) + 1, 0), $1, $2, $3, $4, $5, $6, $7 FROM badges RETURNING id, place",
    )
    .bind(BadgeId::random())
    .bind(ground.person.school_id)
    .bind(ground.person.person_id)
    .bind(ground.curriculum_id)
    .bind(ground.curriculum_sha256)
    .bind(ground.needed)
    .bind(now)
    .fetch_one(writer)
    .await
}

/// Returns the next valid badges of all schools from a place on.
pub async fn list_valid_badges(executor: impl Executor<'_>, from: i64, most: u32) -> Result<Vec<ValidBadge>> {
    sqlx::query_as(
        "SELECT place, school_id, person_id, curriculum_id, needed FROM badges
         WHERE place >= $1 AND revoked_at IS NULL ORDER BY place LIMIT $2 + 0",
    )
    .bind(from)
    .bind(i64::from(most))
    .fetch_all(executor)
    .await
}

/// Returns the places of the revoked badges from a place to before another.
pub async fn list_revoked_places(executor: impl Executor<'_>, from: i64, to: i64) -> Result<Vec<i64>> {
    sqlx::query_scalar(
        "SELECT place FROM badges WHERE place >= $1 AND place < $2 AND revoked_at IS NOT NULL ORDER BY place",
    )
    .bind(from)
    .bind(to)
    .fetch_all(executor)
    .await
}

/// Returns whether a badge was issued at a place.
pub async fn is_place_taken(executor: impl Executor<'_>, place: i64) -> Result<bool> {
    let found: Option<i64> =
        sqlx::query_scalar("SELECT place FROM badges WHERE place = $1").bind(place).fetch_optional(executor).await?;
    Ok(found.is_some())
}

/// Revokes a badge, for good. Returns false if it was revoked before.
pub async fn revoke_badge(writer: &mut Connection, place: i64, now: Moment) -> Result<bool> {
    let revoked = sqlx::query("UPDATE badges SET revoked_at = $2 WHERE place = $1 AND revoked_at IS NULL")
        .bind(place)
        .bind(now)
        .execute(writer)
        .await?;
    Ok(revoked.rows_affected() > 0)
}

/// Revokes all badges of a person. Returns their number.
pub async fn revoke_badges_of(writer: &mut Connection, person: PersonKey, now: Moment) -> Result<u64> {
    let revoked =
        sqlx::query("UPDATE badges SET revoked_at = $3 WHERE school_id = $1 AND person_id = $2 AND revoked_at IS NULL")
            .bind(person.school_id)
            .bind(person.person_id)
            .bind(now)
            .execute(writer)
            .await?;
    Ok(revoked.rows_affected())
}
