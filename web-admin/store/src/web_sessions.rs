//! Signed-in browsers. The table keeps the hash of a session's id, so that a copy of the file signs nobody in.
//!
//! Each function fails when the database does.

use model::Moment;
use serde_json::Value;

use crate::{Connection, Executor, Json, Result};

/// What a session holds.
#[expect(clippy::disallowed_types, reason = "tower-sessions keeps them so; nothing depends on their order")]
pub type SessionData = std::collections::HashMap<String, Value>;

/// A browser's session, to be kept.
#[derive(Clone, Copy, Debug)]
pub struct WebSessionRow<'a> {
    /// SHA-256 of its id.
    pub id_sha256: &'a [u8],
    /// What it holds.
    pub data: &'a SessionData,
    /// When it ends.
    pub expires_at: Moment,
}

/// Keeps a session; a `new` one only under an id that nobody has. False where somebody has it.
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

/// What a session holds that has not ended, and when it will.
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

/// Forgets a session.
pub async fn forget_session(writer: &mut Connection, id_sha256: &[u8]) -> Result<()> {
    sqlx::query("DELETE FROM web_sessions WHERE id_sha256 = $1").bind(id_sha256).execute(writer).await.map(drop)
}

/// Forgets the sessions that have ended.
pub async fn forget_ended_sessions(writer: &mut Connection, now: Moment) -> Result<()> {
    sqlx::query("DELETE FROM web_sessions WHERE expires_at <= $1").bind(now).execute(writer).await.map(drop)
}
