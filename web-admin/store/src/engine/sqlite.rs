//! SQLite: a file with one connection for writing and several for reading.

use std::fs::File;
use std::io;
use std::path::{Path, PathBuf};
use std::str::FromStr;
use std::time::Duration;

use sqlx::Connection as _;
use sqlx::migrate::Migrator;
use sqlx::pool::PoolOptions;
use sqlx::sqlite::{SqliteConnectOptions, SqliteJournalMode, SqliteSynchronous};

use super::address::DatabaseAddress;
use super::driver::{ConnectOptions, Engine};
use super::{Connection, EngineKind, Executor};
use crate::{Database, Result, Write};

/// The migrations.
pub(super) static MIGRATIONS: Migrator = sqlx::migrate!("../../migrations");

/// Takes the write lock immediately.
const BEGIN: &str = "BEGIN IMMEDIATE";

/// Page cache of each connection, in the unit of `PRAGMA cache_size`: 4 MB, enough for the upper
/// levels of a large school's indices. Other pages are in the page cache of the operating system.
const CACHE: &str = "-4000";
/// Number of rows that SQLite's thread may read ahead of the consumer: waiting for each other costs
/// more than reading a row.
const ROWS: usize = 1024;

/// Returns the address of a file.
pub(super) fn address_of(path: &Path) -> String {
    format!("sqlite://{}", path.display())
}

/// Returns the connection options for an address.
pub(super) fn options(address: &DatabaseAddress) -> Result<SqliteConnectOptions> {
    SqliteConnectOptions::from_str(address.as_url())
}

/// Returns the file of an address.
pub(super) fn file_of(address: &DatabaseAddress) -> io::Result<PathBuf> {
    Ok(options(address).map_err(io::Error::other)?.get_filename().to_owned())
}

/// Removes the database file and its write-ahead log.
pub(super) fn make_anew(address: &DatabaseAddress) -> Result<()> {
    let file = file_of(address)?;
    for end in ["", "-wal", "-shm"] {
        let mut name = file.clone().into_os_string();
        name.push(end);
        match std::fs::remove_file(name) {
            Err(error) if error.kind() != io::ErrorKind::NotFound => return Err(error.into()),
            _ => {}
        }
    }
    Ok(())
}

/// Opens a database. `make` creates a missing file.
pub(super) async fn open(address: &DatabaseAddress, make: bool) -> Result<Database> {
    let options = options(address)?
        .create_if_missing(make)
        .journal_mode(SqliteJournalMode::Wal)
        // A score that was shown must survive a power failure, so each commit is synced to the
        // disk.
        .synchronous(SqliteSynchronous::Full)
        .foreign_keys(true)
        .pragma("cache_size", CACHE)
        // Deleted data is overwritten with zeros instead of staying in free pages.
        .pragma("secure_delete", "ON")
        .row_buffer_size(ROWS)
        .busy_timeout(Duration::from_secs(10));
    let pool = PoolOptions::<Engine>::new();
    let writer = pool.clone().max_connections(1).connect_with(options.clone().into()).await?;
    let reading: ConnectOptions = options.create_if_missing(false).pragma("query_only", "ON").into();
    // A file cannot disconnect, and a ping costs two context switches before each statement.
    let reader = pool.max_connections(4).test_before_acquire(false).connect_lazy_with(reading);
    Ok(Database { writer, reader, kind: EngineKind::Sqlite })
}

/// Starts a write transaction. It is `IMMEDIATE` because a deferred transaction that starts to
/// write later fails at once if another one is writing, and ignores the busy timeout.
///
/// If a connection cannot begin, it is closed and a new one is tried once: after a full disk or an
/// I/O error SQLite has rolled back by itself, but the connection still counts an open transaction.
pub(super) async fn write(database: &Database) -> Result<Write> {
    if let Ok(begun) = database.writer.begin_with(BEGIN).await {
        return Ok(begun);
    }
    database.writer.acquire().await?.close().await?;
    database.writer.begin_with(BEGIN).await
}

/// Returns the triggers that the migrations up to `newest` create: name and definition.
pub(super) async fn made_triggers(newest: i64) -> Result<Vec<(String, String)>> {
    let mut fresh = Connection::connect("sqlite::memory:").await?;
    for migration in MIGRATIONS.iter().filter(|migration| migration.version <= newest) {
        sqlx::raw_sql(migration.sql.clone()).execute(&mut fresh).await?;
    }
    list_triggers(&mut fresh).await
}

/// Returns all triggers of a database: name and definition.
pub(super) async fn list_triggers(executor: impl Executor<'_>) -> Result<Vec<(String, String)>> {
    sqlx::query_as("SELECT name, sql FROM sqlite_schema WHERE type = 'trigger' ORDER BY name").fetch_all(executor).await
}

/// Runs SQLite's integrity check: returns damaged pages and dangling references.
pub(super) async fn integrity(database: &Database) -> Result<Vec<String>> {
    let mut findings: Vec<String> =
        sqlx::query_scalar("SELECT integrity_check FROM pragma_integrity_check").fetch_all(&database.reader).await?;
    findings.retain(|line| line != "ok");
    let dangling: Vec<(String, Option<i64>, String)> =
        sqlx::query_as(r#"SELECT "table", rowid, parent FROM pragma_foreign_key_check"#)
            .fetch_all(&database.reader)
            .await?;
    findings.extend(
        dangling
            .into_iter()
            .map(|(table, row, parent)| format!("{table} row {}: no such row in {parent}", row.unwrap_or_default())),
    );
    Ok(findings)
}

/// Returns damaged pages of a table.
pub(super) async fn damaged_pages(database: &Database, table: &str) -> Result<Vec<String>> {
    let mut findings: Vec<String> = sqlx::query_scalar("SELECT quick_check FROM pragma_quick_check($1)")
        .bind(table)
        .fetch_all(&database.reader)
        .await?;
    findings.retain(|line| line != "ok");
    Ok(findings.iter().map(|lines| format!("{table}: {}", lines.replace('\n', " "))).collect())
}

/// Copies a consistent snapshot of the database into a new file. Other processes can write
/// meanwhile.
pub(super) async fn copy_to(database: &Database, file: &Path) -> Result<()> {
    sqlx::query("VACUUM INTO $1").bind(file.to_string_lossy()).execute(&database.writer).await.map(drop)
}

/// Finishes a bulk write: moves the write-ahead log into the file and syncs the file to the disk.
pub(super) async fn settle(database: &Database) -> Result<()> {
    fold_log(database).await?;
    let file: String = sqlx::query_scalar("SELECT file FROM pragma_database_list WHERE name = 'main'")
        .fetch_one(&database.reader)
        .await?;
    Ok(File::open(file)?.sync_all()?)
}

/// Checkpoints the write-ahead log into the file and truncates it.
pub(super) async fn fold_log(database: &Database) -> Result<()> {
    sqlx::query("PRAGMA wal_checkpoint(TRUNCATE)").execute(&database.writer).await.map(drop)
}
