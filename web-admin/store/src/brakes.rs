//! Tries to guess something, and until when they count.

use model::Moment;

use super::{Connection, Executor, Result};

/// Until when the tries by a hash count, where any still may.
pub async fn find_brake(executor: impl Executor<'_>, key_sha256: &[u8; 32]) -> Result<Option<Moment>> {
    sqlx::query_scalar("SELECT until FROM brakes WHERE key_sha256 = $1")
        .bind(key_sha256.as_slice())
        .fetch_optional(executor)
        .await
}

/// Lets the tries by a hash count until a moment.
pub async fn put_brake(writer: &mut Connection, key_sha256: &[u8; 32], until: Moment) -> Result<()> {
    sqlx::query(
        "INSERT INTO brakes (key_sha256, until) VALUES ($1, $2) ON CONFLICT (key_sha256) DO UPDATE SET until = $2",
    )
    .bind(key_sha256.as_slice())
    .bind(until)
    .execute(writer)
    .await
    .map(drop)
}

/// Forgets tries that count no more.
pub async fn forget_brakes(writer: &mut Connection, now: Moment) -> Result<()> {
    sqlx::query("DELETE FROM brakes WHERE until < $1").bind(now).execute(writer).await.map(drop)
}
