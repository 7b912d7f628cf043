//! Web sessions of browsers. The table contains the hash of a session's id, so that a copy of the
//! database cannot be used to sign in.
//!
//! Each function fails if the database fails.

use model::Moment;
use serde_json::Value;

use crate::{Connection, Executor, Json, Result};

/// Data of a session.
#[expect(clippy::disallowed_types, reason = "tower-sessions keeps them so; nothing depends on their order")]
pub type SessionData = std::collections::HashMap<String, Value>;

/// A session to be stored.
#[derive(Clone, Copy, Debug)]
pub struct WebSessionRow<'a> {
    /// SHA-256 of the session's id.
    pub id_sha256: &'a [u8],
    /// Data of the session.
    pub data: &'a SessionData,
    /// Expiry time.
    pub expires_at: Moment,
}

/// Stores a session. With `new`, the id must be unused. Returns false if it is in use.
pub async fn put_session(writer: &mut Connection, row: WebSessionRow<'_>, new: bool) -> Result<bool> {
    let done = sqlx::query(
        "INSERT INTO web_sessions (id_sha256, data, expires_at) VALUES ($1, $2, $3)
         ON CONFLICT (id_sha256) DO UPDATE SET data = excluded.data, expires_at = excluded.expires_at
         WHERE NOT $4",
    )
    .bind(row.id_sha256)
    .bind(Json(row.data))
    .bind(row.expires_at)
    .bind(new)
    .execute(writer)
    .await?;
    Ok(done.rows_affected() == 1)
}

/// Returns the data and expiry time of a session that has not expired.
pub async fn find_session(
    executor: impl Executor<'_>,
    id_sha256: &[u8],
    now: Moment,
) -> Result<Option<(SessionData, Moment)>> {
    let row: Option<(Json<SessionData>, Moment)> =
        sqlx::query_as("SELECT data, expires_at FROM web_sessions WHERE id_sha256 = $1 AND expires_at > $2")
            .bind(id_sha256)
            .bind(now)
            .fetch_optional(executor)
            .await?;
    Ok(row.map(|(data, expires_at)| (data.0, expires_at)))
}

/// Deletes a session.
pub async fn forget_session(writer: &mut Connection, id_sha256: &[u8]) -> Result<()> {
    sqlx::query("DELETE FROM web_sessions WHERE id_sha256 = $1").bind(id_sha256).execute(writer).await.map(drop)
}

/// Deletes expired sessions.
pub async fn forget_ended_sessions(writer: &mut Connection, now: Moment) -> Result<()> {
    sqlx::query("DELETE FROM web_sessions WHERE expires_at <= $1").bind(now).execute(writer).await.map(drop)
}
