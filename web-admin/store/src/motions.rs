//! What the hand did, by its hash: attempts of before there was one.

use model::{SessionKey, Uncounted};

use super::sessions::Session;
use super::{Connection, Executor, Result};

/// The next attempt whose motion has no hash yet, in the order in which they came.
pub async fn list_unhashed_motions(executor: impl Executor<'_>) -> Result<Option<Session>> {
    sqlx::query_as(
        "SELECT s.* FROM (SELECT school_id, session_id FROM unhashed_motions ORDER BY rowid LIMIT 1) u
         CROSS JOIN sessions s WHERE s.school_id = u.school_id AND s.id = u.session_id",
    )
    .fetch_optional(executor)
    .await
}

/// Takes an attempt from those whose motion is to be hashed.
pub async fn mark_motions_done(writer: &mut Connection, session: SessionKey) -> Result<()> {
    sqlx::query("DELETE FROM unhashed_motions WHERE school_id = $1 AND session_id = $2")
        .bind(session.school_id)
        .bind(session.id)
        .execute(writer)
        .await
        .map(drop)
}

/// Sets the hash of an attempt's motion.
///
/// # Errors
/// When the database fails, or another attempt of this motion counts as this one does.
pub async fn set_motion(writer: &mut Connection, session: SessionKey, motion_sha256: &str) -> Result<()> {
    sqlx::query("UPDATE sessions SET motion_sha256 = $3 WHERE school_id = $1 AND id = $2")
        .bind(session.school_id)
        .bind(session.id)
        .bind(motion_sha256)
        .execute(writer)
        .await
        .map(drop)
}

/// Whether an attempt was kept before another, whatever the clock said.
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

/// An attempt repeats the motion of an earlier one, and counts nowhere from now on.
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
