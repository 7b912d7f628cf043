//! Short-lived links that let an external viewer read one recording.

use model::ids::PersonId;
use model::{Moment, SessionKey};

use crate::recordings::sessions::Session;
use crate::{Connection, Executor, Result};

/// A link to be stored.
#[derive(Clone, Copy, Debug)]
pub struct NewRecordingLink<'a> {
    /// The attempt.
    pub session: SessionKey,
    /// Person who made the link.
    pub made_by: PersonId,
    /// SHA-256 of the secret in the link.
    pub token_sha256: &'a [u8; 32],
    /// Expiry time.
    pub expires_at: Moment,
}

/// Stores a link and deletes expired ones.
///
/// # Errors
/// If the attempt or the person belongs to another school, or the database fails.
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

/// Returns the attempt that a link refers to, provided that it has not expired and the account of
/// the person who made it is not disabled.
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
