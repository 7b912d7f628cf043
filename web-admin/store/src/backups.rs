//! What the command that makes backups has come to.

use model::Moment;
use model::ids::BackupId;
use sqlx::FromRow;

use super::{Connection, Executor, Result};

/// So many are remembered: a year of one each night.
const REMEMBERED: i64 = 400;

/// A backup that was made and read back, or why it was not.
#[derive(Clone, Debug, PartialEq, Eq, FromRow)]
pub struct NotedBackup {
    /// When it was begun.
    pub made_at: Moment,
    /// The file's name, without its folder.
    pub file_name: String,
    /// How large it is; absent where none was made.
    pub bytes: Option<i64>,
    /// Recordings in it; absent where none was made.
    pub recordings: Option<i64>,
    /// The keys of certificates and of second factors are in it, sealed.
    pub keys_sealed: bool,
    /// Why none was made.
    pub error: Option<String>,
}

/// Notes a backup, and forgets the oldest beyond those that are remembered.
pub async fn note_backup(writer: &mut Connection, backup: &NotedBackup) -> Result<()> {
    sqlx::query(
        "INSERT INTO backups (id, made_at, file_name, bytes, recordings, keys_sealed, error)
         VALUES ($1, $2, $3, $4, $5, $6, $7)",
    )
    .bind(BackupId::made_at(backup.made_at))
    .bind(backup.made_at)
    .bind(&backup.file_name)
    .bind(backup.bytes)
    .bind(backup.recordings)
    .bind(backup.keys_sealed)
    .bind(&backup.error)
    .execute(&mut *writer)
    .await?;
    sqlx::query(
        "DELETE FROM backups WHERE id IN (
           SELECT id FROM backups ORDER BY made_at DESC, id DESC LIMIT 9223372036854775807 OFFSET $1)",
    )
    .bind(REMEMBERED)
    .execute(writer)
    .await
    .map(drop)
}

/// The latest backups, the latest first.
pub async fn list_latest_backups(executor: impl Executor<'_>, limit: u32) -> Result<Vec<NotedBackup>> {
    sqlx::query_as(
        "SELECT made_at, file_name, bytes, recordings, keys_sealed, error FROM backups
         ORDER BY made_at DESC, id DESC LIMIT $1 + 0",
    )
    .bind(i64::from(limit))
    .fetch_all(executor)
    .await
}

/// The latest backup that was made, where one was.
pub async fn find_last_backup(executor: impl Executor<'_>) -> Result<Option<NotedBackup>> {
    sqlx::query_as(
        "SELECT made_at, file_name, bytes, recordings, keys_sealed, error FROM backups WHERE error IS NULL
         ORDER BY made_at DESC, id DESC LIMIT 1",
    )
    .fetch_optional(executor)
    .await
}
