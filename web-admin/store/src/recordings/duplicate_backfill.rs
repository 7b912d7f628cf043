//! Backfill of motion hashes for attempts recorded before duplicate detection existed.

use model::{SessionKey, Uncounted};

use crate::recordings::sessions::Session;
use crate::{Connection, Executor, Result};

/// Returns the next attempt whose motion is not yet hashed, in order of arrival.
pub async fn list_unhashed_motions(executor: impl Executor<'_>) -> Result<Option<Session>> {
    sqlx::query_as(
        "SELECT s.* FROM (SELECT school_id, session_id FROM unhashed_motions ORDER BY rowid LIMIT 1) u
         CROSS JOIN sessions s WHERE s.school_id = u.school_id AND s.id = u.session_id",
    )
    .fetch_optional(executor)
    .await
}

/// Removes an attempt from the backfill queue.
pub async fn mark_motions_done(writer: &mut Connection, session: SessionKey) -> Result<()> {
    sqlx::query("DELETE FROM unhashed_motions WHERE school_id = $1 AND session_id = $2")
        .bind(session.school_id)
        .bind(session.id)
        .execute(writer)
        .await
        .map(drop)
}

/// Sets the motion hash of an attempt.
///
/// # Errors
/// If another counted attempt has the same motion, or the database fails.
pub async fn set_motion(writer: &mut Connection, session: SessionKey, motion_sha256: &str) -> Result<()> {
    sqlx::query("UPDATE sessions SET motion_sha256 = $3 WHERE school_id = $1 AND id = $2")
        .bind(session.school_id)
        .bind(session.id)
        .bind(motion_sha256)
        .execute(writer)
        .await
        .map(drop)
}

/// Returns whether an attempt was stored before another, independently of the clock.
pub async fn find_earlier_motion(executor: impl Executor<'_>, session: SessionKey, other: SessionKey) -> Result<bool> {
    sqlx::query_scalar(
        "SELECT (SELECT rowid FROM sessions WHERE school_id = $1 AND id = $2)
           < (SELECT rowid FROM sessions WHERE school_id = $3 AND id = $4)",
    )
    .bind(session.school_id)
    .bind(session.id)
    .bind(other.school_id)
    .bind(other.id)
    .fetch_one(executor)
    .await
}

/// Marks an attempt as a duplicate of an earlier one, so that it no longer counts.
pub async fn mark_repeated(writer: &mut Connection, session: SessionKey, first: SessionKey) -> Result<()> {
    sqlx::query("UPDATE sessions SET uncounted = $3, repeats = $4 WHERE school_id = $1 AND id = $2")
        .bind(session.school_id)
        .bind(session.id)
        .bind(Uncounted::Duplicate)
        .bind(first.id)
        .execute(writer)
        .await
        .map(drop)
}
