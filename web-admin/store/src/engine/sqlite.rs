//! SQLite: a file, one connection that writes, several that read.

use std::fs::File;
use std::io;
use std::path::{Path, PathBuf};
use std::str::FromStr;
use std::time::Duration;

use sqlx::Connection as _;
use sqlx::migrate::Migrator;
use sqlx::sqlite::{SqliteConnectOptions, SqliteJournalMode, SqlitePoolOptions, SqliteSynchronous};

use super::address::{DatabaseAddress, EngineKind};
use super::{Connection, DumpRefused, Executor};
use crate::locks::{FileLock, LockError};
use crate::{Database, Error, Result, Write};

/// The engine.
pub type Engine = sqlx::Sqlite;

/// Everything that makes the schema.
pub(crate) static MIGRATIONS: Migrator = sqlx::migrate!("../../migrations");

/// Longest that a process works without a look at what others have queued: there are none.
pub(crate) const LISTENING_PERIOD: Duration = Duration::from_secs(60);

/// Whether several processes may be at work on one database at a time.
pub(crate) const SHARED: bool = false;

/// Takes the write lock at once.
const BEGIN: &str = "BEGIN IMMEDIATE";

/// What each connection keeps of the database in memory, as `PRAGMA cache_size` reads it: 4 MB, so that the upper levels of a
/// large school's indices stay there. Whatever else is read lies in the system's own cache.
const CACHE: &str = "-4000";
/// Rows that a query may be ahead of whoever reads them: each wait for the other costs more than a row.
const ROWS: usize = 1024;
/// SQLite's result code for a full disk.
const FULL: &str = "13";
/// SQLite's result code where somebody else writes for too long.
const BUSY: &str = "5";

/// Whether a statement came to nothing because the disk is full.
#[must_use]
pub fn is_disk_full(error: &Error) -> bool {
    matches!(error, Error::Database(told) if told.code().as_deref() == Some(FULL))
}

/// Whether a statement came to nothing because the database was not to be had in time, which says nothing of what was asked.
#[must_use]
pub fn is_database_away(error: &Error) -> bool {
    match error {
        Error::PoolTimedOut | Error::PoolClosed => true,
        Error::Database(told) => told.code().as_deref() == Some(BUSY),
        _ => false,
    }
}

/// What this engine is among those of addresses.
pub(super) const KIND: EngineKind = EngineKind::Sqlite;
/// Which addresses are allowed, and how a program for others is built.
pub(super) const ALLOWED: &str = "this program is built for SQLite: allowed is a sqlite: URL or a path; one for a postgres:// URL is \
                                  built by `cargo build --release -p web-admin --features postgres`";

/// The address of a file.
pub(super) fn address_of(path: &Path) -> String {
    format!("sqlite://{}", path.display())
}

/// The address of the database in a data folder.
pub(super) fn address_in(folder: &Path) -> String {
    address_of(&folder.join("stylet.db"))
}

/// A dump of a server's database, in a database of its own: SQLite has none.
#[derive(Debug)]
pub enum DumpedDatabase {}

impl DumpedDatabase {
    /// Refuses.
    ///
    /// # Errors
    /// Always; they say what is verified instead.
    pub async fn restore(file: &Path, _beside: &DatabaseAddress) -> std::result::Result<Self, DumpRefused> {
        Err(DumpRefused {
            file: file.to_owned(),
            why: "this program is built for SQLite, of which there are no dumps; a copy of the database is verified by --database".to_owned(),
        })
    }

    /// None is there.
    #[must_use]
    pub fn database(&self) -> &Database {
        match *self {}
    }

    /// None is there.
    ///
    /// # Errors
    /// Never.
    pub async fn remove(self) -> Result<()> {
        match self {}
    }
}

/// A database that this process holds until it is dropped: a locked file beside the database's.
#[derive(Debug)]
pub struct DatabaseLock {
    _file: FileLock,
}

impl DatabaseLock {
    /// Whether this process still holds it: a file's lock is lost with the process alone.
    pub async fn is_held(&mut self) -> bool {
        true
    }
}

impl DatabaseAddress {
    /// Of a file, as a backup holds one.
    ///
    /// # Errors
    /// None: only a database that a server keeps has no file.
    pub fn of_file(path: &Path) -> io::Result<Self> {
        Ok(Self::of_url(address_of(path)))
    }

    /// The file of the database.
    ///
    /// # Errors
    /// When the address is none of a file.
    pub fn file(&self) -> io::Result<PathBuf> {
        Ok(self.options().map_err(io::Error::other)?.get_filename().to_owned())
    }

    /// The address of another file in the same folder.
    ///
    /// # Errors
    /// When this one is none of a file.
    pub fn sibling(&self, name: &str) -> Result<Self> {
        Ok(Self::of_url(address_of(&self.file()?.with_file_name(format!("{name}.db")))))
    }

    /// Makes the database anew, with nothing in it.
    ///
    /// # Errors
    /// When the file cannot be removed.
    pub async fn make_anew(&self) -> Result<()> {
        let file = self.file()?;
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

    fn options(&self) -> Result<SqliteConnectOptions> {
        SqliteConnectOptions::from_str(self.as_url())
    }
}

impl Database {
    /// Opens a database, and makes its file where it is missing.
    ///
    /// # Errors
    /// When the file cannot be opened.
    pub async fn open(address: &DatabaseAddress) -> Result<Self> {
        Self::connect(address.options()?.create_if_missing(true)).await
    }

    /// Opens a database that must be there.
    ///
    /// # Errors
    /// When it is not.
    pub async fn open_existing(address: &DatabaseAddress) -> Result<Self> {
        Self::connect(address.options()?.create_if_missing(false)).await
    }

    /// Whether there is a database: a file that holds something.
    ///
    /// # Errors
    /// When the address is none of a file.
    pub async fn is_there(address: &DatabaseAddress) -> Result<bool> {
        Ok(std::fs::metadata(address.file()?).is_ok_and(|file| file.len() > 0))
    }

    /// Keeps a database from every other process that would hold it; `holder` tells them who has it.
    ///
    /// # Errors
    /// When another process holds it, or no file can be made beside it.
    pub async fn hold(address: &DatabaseAddress, holder: &str) -> std::result::Result<DatabaseLock, LockError> {
        let file = address.file();
        let file = file.map_err(|why| LockError::Unusable { place: address.to_string(), why: why.into() })?;
        Ok(DatabaseLock { _file: FileLock::take_beside(&file, holder)? })
    }

    /// Holds a database beside others that serve it: of a file, as [`Database::hold`].
    ///
    /// # Errors
    /// As there.
    pub async fn join(address: &DatabaseAddress, holder: &str) -> std::result::Result<DatabaseLock, LockError> {
        Self::hold(address, holder).await
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
            // A file does not go away, and asking costs two changes of the thread before each statement.
            .test_before_acquire(false)
            .connect_lazy_with(options.create_if_missing(false).pragma("query_only", "ON"));
        Ok(Self { writer, reader })
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

    /// As [`Database::write`]: one process alone writes to a file, and nobody waits for it long.
    ///
    /// # Errors
    /// As there.
    pub async fn write_relaxed(&self) -> Result<Write> {
        self.write().await
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

    /// What keeps the database, and which version of it.
    ///
    /// # Errors
    /// When it does not answer.
    pub async fn engine_version(&self) -> Result<String> {
        sqlx::query_scalar("SELECT 'SQLite ' || sqlite_version()").fetch_one(&self.reader).await
    }

    /// How large the database is, in bytes.
    ///
    /// # Errors
    /// When the file cannot be read.
    pub async fn size(&self) -> Result<i64> {
        sqlx::query_scalar("SELECT page_count * page_size FROM pragma_page_count, pragma_page_size")
            .fetch_one(&self.reader)
            .await
    }

    /// After much was written: it is on the disk, and in the file itself, before anybody else waits for that.
    ///
    /// # Errors
    /// When the disk refuses.
    pub async fn settle(&self) -> Result<()> {
        self.fold_log().await?;
        let file: String = sqlx::query_scalar("SELECT file FROM pragma_database_list WHERE name = 'main'")
            .fetch_one(&self.reader)
            .await?;
        Ok(File::open(file)?.sync_all()?)
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

/// Lets a connection keep 256 MB of the database in memory, so that a large transaction goes to the disk once.
pub(crate) async fn keep_more_in_memory(writer: &mut Connection) -> Result<()> {
    sqlx::query("PRAGMA cache_size = -256000").execute(writer).await.map(drop)
}

/// Counts anew what the planner goes by: nothing, for the order of a join is as it is written.
pub(crate) async fn refresh_statistics(_writer: &mut Connection) -> Result<()> {
    Ok(())
}

/// Triggers cannot rest.
pub(crate) async fn suspend_triggers(_writer: &mut Connection) -> Result<()> {
    Ok(())
}

/// Triggers have never rested.
pub(crate) async fn resume_triggers(_writer: &mut Connection) -> Result<()> {
    Ok(())
}
