//! History of backup runs.

use model::Moment;
use model::ids::BackupId;
use sqlx::FromRow;

use crate::{Connection, Executor, Result};

/// Number of runs to keep: one per night for more than a year.
const REMEMBERED: i64 = 400;

/// A backup run: the verified file, or the error.
#[derive(Clone, Debug, PartialEq, Eq, FromRow)]
pub struct NotedBackup {
    /// Start time.
    pub made_at: Moment,
    /// Name of the file, without its folder.
    pub file_name: String,
    /// Size of the file; `None` if the backup failed.
    pub bytes: Option<i64>,
    /// Number of recordings in the backup; `None` if it failed.
    pub recordings: Option<i64>,
    /// The backup contains the keys of certificates and second factors, encrypted.
    pub keys_sealed: bool,
    /// Reason for the failure.
    pub error: Option<String>,
}

/// Records a backup run and deletes the oldest runs beyond the number to keep.
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

/// Returns the latest backup runs, latest first.
pub async fn list_latest_backups(executor: impl Executor<'_>, limit: u32) -> Result<Vec<NotedBackup>> {
    sqlx::query_as(
        "SELECT made_at, file_name, bytes, recordings, keys_sealed, error FROM backups
         ORDER BY made_at DESC, id DESC LIMIT $1 + 0",
    )
    .bind(i64::from(limit))
    .fetch_all(executor)
    .await
}

/// Returns the latest successful backup.
pub async fn find_last_backup(executor: impl Executor<'_>) -> Result<Option<NotedBackup>> {
    sqlx::query_as(
        "SELECT made_at, file_name, bytes, recordings, keys_sealed, error FROM backups WHERE error IS NULL
         ORDER BY made_at DESC, id DESC LIMIT 1",
    )
    .fetch_optional(executor)
    .await
}
