//! Addresses under which a viewer elsewhere may read one recording for a short while.

use model::ids::PersonId;
use model::{Moment, SessionKey};

use super::sessions::Session;
use super::{Connection, Executor, Result};

/// A link to a recording, about to be kept.
#[derive(Clone, Copy, Debug)]
pub struct NewRecordingLink<'a> {
    /// The attempt.
    pub session: SessionKey,
    /// Whoever made the link.
    pub made_by: PersonId,
    /// The hash of the secret in it.
    pub token_sha256: &'a [u8; 32],
    /// When it ends.
    pub expires_at: Moment,
}

/// Keeps a link by its hash, and throws away those that have expired.
///
/// # Errors
/// When attempt or person are of another school, or the database fails.
pub async fn add_recording_link(writer: &mut Connection, link: NewRecordingLink<'_>, now: Moment) -> Result<()> {
    sqlx::query("DELETE FROM recording_links WHERE expires_at <= $1").bind(now).execute(&mut *writer).await?;
    sqlx::query(
        "INSERT INTO recording_links (token_sha256, school_id, session_id, made_by, expires_at)
         VALUES ($1, $2, $3, $4, $5)",
    )
    .bind(link.token_sha256.as_slice())
    .bind(link.session.school_id)
    .bind(link.session.id)
    .bind(link.made_by)
    .bind(link.expires_at)
    .execute(writer)
    .await
    .map(drop)
}

/// The attempt that a link opens, while it lasts and whoever made it may sign in.
pub async fn find_linked_session(
    executor: impl Executor<'_>,
    token_sha256: &[u8; 32],
    now: Moment,
) -> Result<Option<Session>> {
    sqlx::query_as(
        "SELECT s.* FROM recording_links l
         JOIN sessions s ON s.school_id = l.school_id AND s.id = l.session_id
         JOIN people p ON p.school_id = l.school_id AND p.id = l.made_by AND p.disabled_at IS NULL
         WHERE l.token_sha256 = $1 AND l.expires_at > $2",
    )
    .bind(token_sha256.as_slice())
    .bind(now)
    .fetch_optional(executor)
    .await
}
