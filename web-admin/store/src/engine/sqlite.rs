//! SQLite: a file, one connection that writes, several that read.

use std::path::{Path, PathBuf};
use std::str::FromStr;
use std::time::Duration;

use sqlx::Connection as _;
use sqlx::migrate::Migrator;
use sqlx::sqlite::{SqliteConnectOptions, SqliteJournalMode, SqlitePoolOptions, SqliteSynchronous};

use super::{Connection, Executor};
use crate::{Database, Error, Result};

/// The engine.
pub type Engine = sqlx::Sqlite;

/// Everything that makes the schema.
pub(crate) static MIGRATIONS: Migrator = sqlx::migrate!("../../migrations");

/// Longest that a process works without a look at what others have queued: there are none.
pub(crate) const LISTENING_PERIOD: Duration = Duration::from_secs(60);

/// Whether several processes may be at work on one database at a time.
pub(crate) const SHARED: bool = false;

/// Takes the write lock at once.
pub(crate) const BEGIN: &str = "BEGIN IMMEDIATE";

/// What each connection keeps of the database in memory, as `PRAGMA cache_size` reads it: 4 MB, so that the upper levels of a
/// large school's indices stay there. Whatever else is read lies in the system's own cache.
const CACHE: &str = "-4000";
/// Rows that a query may be ahead of whoever reads them: each wait for the other costs more than a row.
const ROWS: usize = 1024;
/// SQLite's result code for a full disk.
const FULL: &str = "13";

/// Whether a statement came to nothing because the disk is full.
#[must_use]
pub fn is_disk_full(error: &Error) -> bool {
    matches!(error, Error::Database(told) if told.code().as_deref() == Some(FULL))
}

impl Database {
    /// Opens the database of a `sqlite:` URL, and makes the file where it is missing.
    ///
    /// # Errors
    /// When the URL is no SQLite URL, or the file cannot be opened.
    pub async fn open(url: &str) -> Result<Self> {
        Self::connect(SqliteConnectOptions::from_str(url)?.create_if_missing(true)).await
    }

    /// Opens a database that must be there.
    ///
    /// # Errors
    /// When it is not.
    pub async fn open_existing(url: &str) -> Result<Self> {
        Self::connect(SqliteConnectOptions::from_str(url)?.create_if_missing(false)).await
    }

    /// Opens a database where its file is there and holds something.
    ///
    /// # Errors
    /// When the URL is no SQLite URL, or what is there cannot be opened.
    pub async fn open_if_there(url: &str) -> Result<Option<Self>> {
        let there = std::fs::metadata(Self::file_of(url)?).is_ok_and(|file| file.len() > 0);
        if there { Self::open_existing(url).await.map(Some) } else { Ok(None) }
    }

    /// The file of a `sqlite:` URL.
    ///
    /// # Errors
    /// When the URL is no SQLite URL.
    pub fn file_of(url: &str) -> Result<PathBuf> {
        Ok(SqliteConnectOptions::from_str(url)?.get_filename().to_owned())
    }

    async fn connect(options: SqliteConnectOptions) -> Result<Self> {
        let options = options
            .journal_mode(SqliteJournalMode::Wal)
            // A score that was shown must survive a power cut, so each commit reaches the disk.
            .synchronous(SqliteSynchronous::Full)
            .foreign_keys(true)
            .pragma("cache_size", CACHE)
            // What was erased is overwritten, and not left in pages that are free.
            .pragma("secure_delete", "ON")
            .row_buffer_size(ROWS)
            .busy_timeout(Duration::from_secs(10));
        let writer = SqlitePoolOptions::new().max_connections(1).connect_with(options.clone()).await?;
        let reader = SqlitePoolOptions::new()
            .max_connections(4)
            .connect_lazy_with(options.create_if_missing(false).pragma("query_only", "ON"));
        Ok(Self { writer, reader })
    }

    /// Triggers that the migrations made and that are gone or changed: without them the audit log may shrink.
    ///
    /// # Errors
    /// When the file cannot be read, or was never migrated.
    pub async fn lost_triggers(&self) -> Result<Vec<String>> {
        let newest = self.newest_migration().await?;
        let mut fresh = Connection::connect("sqlite::memory:").await?;
        for migration in MIGRATIONS.iter().filter(|migration| migration.version <= newest) {
            sqlx::raw_sql(migration.sql.clone()).execute(&mut fresh).await?;
        }
        let (expected, found) = (triggers(&mut fresh).await?, triggers(&self.reader).await?);
        let lost = expected.into_iter().filter(|trigger| !found.contains(trigger));
        Ok(lost
            .map(|(name, _)| format!("trigger {name} is gone or changed: rows that it keeps may have been altered"))
            .collect())
    }

    /// What SQLite itself finds wrong with the file: damaged pages and rows that point nowhere. Empty when all is well.
    ///
    /// # Errors
    /// When the file cannot be read at all.
    pub async fn integrity(&self) -> Result<Vec<String>> {
        let mut findings: Vec<String> =
            sqlx::query_scalar("SELECT integrity_check FROM pragma_integrity_check").fetch_all(&self.reader).await?;
        findings.retain(|line| line != "ok");
        let dangling: Vec<(String, Option<i64>, String)> =
            sqlx::query_as(r#"SELECT "table", rowid, parent FROM pragma_foreign_key_check"#)
                .fetch_all(&self.reader)
                .await?;
        findings.extend(
            dangling.into_iter().map(|(table, row, parent)| {
                format!("{table} row {}: no such row in {parent}", row.unwrap_or_default())
            }),
        );
        Ok(findings)
    }

    /// Every table, that of the schema included.
    ///
    /// # Errors
    /// When the file cannot be read at all.
    pub async fn list_tables(&self) -> Result<Vec<String>> {
        sqlx::query_scalar(
            "SELECT 'sqlite_schema' UNION ALL SELECT name FROM sqlite_schema WHERE type = 'table' AND name NOT LIKE 'sqlite_%'",
        )
        .fetch_all(&self.reader)
        .await
    }

    /// What SQLite finds wrong with the pages of a table: quicker than [`Self::integrity`], which also compares every index and counts
    /// the pages that are free.
    ///
    /// # Errors
    /// When the file cannot be read at all.
    pub async fn damaged_pages(&self, table: &str) -> Result<Vec<String>> {
        let mut findings: Vec<String> = sqlx::query_scalar("SELECT quick_check FROM pragma_quick_check($1)")
            .bind(table)
            .fetch_all(&self.reader)
            .await?;
        findings.retain(|line| line != "ok");
        Ok(findings.iter().map(|lines| format!("{table}: {}", lines.replace('\n', " "))).collect())
    }

    /// Copies the database as it is at one moment into a file that must not exist. Others go on writing meanwhile.
    ///
    /// # Errors
    /// When the file exists, or the disk refuses.
    pub async fn copy_to(&self, file: &Path) -> Result<()> {
        sqlx::query("VACUUM INTO $1").bind(file.to_string_lossy()).execute(&self.writer).await.map(drop)
    }

    /// Folds the write-ahead log into the file and empties it, so that what was overwritten stands nowhere on the disk. Where a reader is
    /// in the way, the next one that writes much does it.
    pub async fn fold_log(&self) -> Result<()> {
        sqlx::query("PRAGMA wal_checkpoint(TRUNCATE)").execute(&self.writer).await.map(drop)
    }
}

/// Every trigger of a database: name and definition.
async fn triggers(executor: impl Executor<'_>) -> Result<Vec<(String, String)>> {
    sqlx::query_as("SELECT name, sql FROM sqlite_schema WHERE type = 'trigger' ORDER BY name").fetch_all(executor).await
}

/// Whether the database has a table.
pub(crate) async fn is_table_there(executor: impl Executor<'_>, name: &str) -> Result<bool> {
    sqlx::query_scalar("SELECT count(*) > 0 FROM sqlite_schema WHERE type = 'table' AND name = $1")
        .bind(name)
        .fetch_one(executor)
        .await
}
