//! Everything that is SQL. Functions that read take any executor; functions that write take a connection, which only
//! [`Database::write`] hands out, so that a writer always holds `BEGIN IMMEDIATE`.
//!
//! What a viewer may see of trainees is in one place, the view `taught_trainees`.
//!
//! Whatever asks the database fails when the database does; a function says only what else it refuses.

use std::path::{Path, PathBuf};
use std::str::FromStr;
use std::time::Duration;

use model::Moment;
use serde::{Deserialize, Deserializer};
use sqlx::migrate::Migrator;
use sqlx::sqlite::{SqliteConnectOptions, SqliteJournalMode, SqlitePool, SqlitePoolOptions, SqliteSynchronous};
use sqlx::{Connection, Sqlite, SqliteConnection, SqliteExecutor, Transaction};

pub mod account_links;
pub mod assignments;
pub mod audit;
pub mod audit_search;
pub mod backups;
pub mod cohorts;
pub mod comments;
pub mod curricula;
pub mod deadlines;
pub mod directory;
pub mod drafts;
pub mod exercises;
pub mod experts;
pub mod exports;
pub mod generated;
pub mod grades;
pub mod instruments;
pub mod jobs;
pub mod links;
pub mod logos;
pub mod mails;
pub mod motions;
pub mod notices;
pub mod origins;
pub mod passkeys;
pub mod people;
pub mod pictures;
pub mod practice;
pub mod proofs;
pub mod ratings;
pub mod regradings;
pub mod reports;
pub mod research;
pub mod retention;
pub mod reviews;
pub mod rosters;
pub mod schools;
pub mod scores;
pub mod second_factors;
pub mod segments;
pub mod service;
pub mod sessions;
pub mod sign_in_codes;
pub mod stations;
pub mod studies;
pub mod supervisions;
pub mod surveys;
pub mod tallies;
pub mod texts;
pub mod tokens;
pub mod tries;
pub mod uploads;
pub mod web_sessions;

/// What a query may come to.
pub type Result<T> = std::result::Result<T, sqlx::Error>;

/// Why a query came to nothing.
pub type Error = sqlx::Error;

/// What each connection keeps of the database in memory, as `PRAGMA cache_size` reads it: 4 MB, so that the upper levels of a
/// large school's indices stay there. Whatever else is read lies in the system's own cache.
const CACHE: &str = "-4000";
/// Rows that a query may be ahead of whoever reads them: each wait for the other costs more than a row.
const ROWS: usize = 1024;

/// A number within JSON that SQLite has written, or none. As a text of 17 digits it is the very number that was stored: as a
/// number of JSON it would have 15.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ExactNumber(pub Option<f64>);

impl<'de> Deserialize<'de> for ExactNumber {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> std::result::Result<Self, D::Error> {
        let text: Option<&str> = Option::deserialize(deserializer)?;
        text.map(str::parse).transpose().map(Self).map_err(serde::de::Error::custom)
    }
}

/// Everything that makes the schema.
static MIGRATIONS: Migrator = sqlx::migrate!("../../migrations");

/// Takes the write lock at once.
const BEGIN: &str = "BEGIN IMMEDIATE";

/// A transaction that holds the write lock from its first moment.
pub type Write = Transaction<'static, Sqlite>;

/// The database: one connection that writes, several that read.
#[derive(Clone, Debug)]
pub struct Database {
    writer: SqlitePool,
    reader: SqlitePool,
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

    /// Brings the schema up to date.
    ///
    /// # Errors
    /// When a migration fails, or the database is newer than this program.
    pub async fn migrate(&self) -> std::result::Result<(), sqlx::migrate::MigrateError> {
        MIGRATIONS.run(&self.writer).await?;
        Ok(directory::fill_search_texts(&self.writer).await?)
    }

    /// The newest migration that the database has had; 0 where it had none.
    async fn newest_migration(&self) -> Result<i64> {
        sqlx::query_scalar("SELECT coalesce(max(version), 0) FROM _sqlx_migrations").fetch_one(&self.reader).await
    }

    /// How many migrations this program knows and the database has not had: 0 when it is up to date.
    ///
    /// # Errors
    /// When the file cannot be read, or was never migrated.
    pub async fn count_missing_migrations(&self) -> Result<usize> {
        let newest = self.newest_migration().await?;
        Ok(MIGRATIONS.iter().filter(|migration| migration.version > newest).count())
    }

    /// Triggers that the migrations made and that are gone or changed: without them the audit log may shrink.
    ///
    /// # Errors
    /// When the file cannot be read, or was never migrated.
    pub async fn lost_triggers(&self) -> Result<Vec<String>> {
        let newest = self.newest_migration().await?;
        let mut fresh = SqliteConnection::connect("sqlite::memory:").await?;
        for migration in MIGRATIONS.iter().filter(|migration| migration.version <= newest) {
            sqlx::raw_sql(migration.sql.clone()).execute(&mut fresh).await?;
        }
        let (expected, found) = (triggers(&mut fresh).await?, triggers(&self.reader).await?);
        let lost = expected.into_iter().filter(|trigger| !found.contains(trigger));
        Ok(lost
            .map(|(name, _)| format!("trigger {name} is gone or changed: rows that it keeps may have been altered"))
            .collect())
    }

    /// Connections that read. Only one file may be open for writing at a time, so these refuse to write.
    #[must_use]
    pub fn reader(&self) -> &SqlitePool {
        &self.reader
    }

    /// Starts a transaction that may write. `IMMEDIATE`: a deferred one that turns to writing later is refused at once
    /// and ignores the busy timeout.
    ///
    /// A connection that cannot begin is thrown away and the next one tried once: after a full disk or an I/O error SQLite
    /// has rolled back by itself, and the connection still counts a transaction that is no more.
    ///
    /// # Errors
    /// When the lock is not to be had within the busy timeout.
    pub async fn write(&self) -> Result<Write> {
        if let Ok(begun) = self.writer.begin_with(BEGIN).await {
            return Ok(begun);
        }
        self.writer.acquire().await?.close().await?;
        self.writer.begin_with(BEGIN).await
    }

    /// Reads and writes a row, as everything that is acknowledged must.
    ///
    /// # Errors
    /// When the database does not answer, or takes nothing.
    pub async fn beat(&self, now: Moment) -> Result<()> {
        sqlx::query("SELECT 1").execute(&self.reader).await?;
        let mut tx = self.write().await?;
        sqlx::query("UPDATE heartbeat SET beaten_at = $1").bind(now).execute(&mut *tx).await?;
        tx.commit().await
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

    /// Closes every connection, so that the write-ahead log is folded into the file.
    pub async fn close(&self) {
        self.reader.close().await;
        self.writer.close().await;
    }
}

/// Every trigger of a database: name and definition.
async fn triggers(executor: impl SqliteExecutor<'_>) -> Result<Vec<(String, String)>> {
    sqlx::query_as("SELECT name, sql FROM sqlite_schema WHERE type = 'trigger' ORDER BY name").fetch_all(executor).await
}
