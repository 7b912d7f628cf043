//! Operations on a database and its address. Each function calls the module of the engine that the
//! address names.

use std::borrow::Cow;
use std::io;
use std::path::{Path, PathBuf};
use std::time::Duration;

use sqlx::migrate::Migrator;

use super::address::{DatabaseAddress, EngineKind};
#[cfg(feature = "postgres")]
pub use super::dump::DumpedDatabase;
#[cfg(feature = "postgres")]
use super::postgres;
use super::{Connection, Executor, sqlite, twin};
use crate::locks::{FileLock, LockError};
use crate::{Database, Error, Result, Write};

/// Error codes for a full disk: of SQLite and of PostgreSQL.
const FULL: [&str; 2] = ["13", "53100"];
/// Error codes of an unavailable database. SQLite: another process held the write lock for too long
/// (5). PostgreSQL: the server shuts down or starts (57P01, 57P02, 57P03), has closed an idle
/// session (57P05) or has no free connection (53300); a lock timed out (55P03).
const AWAY: [&str; 7] = ["5", "57P01", "57P02", "57P03", "57P05", "53300", "55P03"];
/// Class of PostgreSQL's error codes for broken connections.
const BROKEN: &str = "08";

fn code_of(error: &Error) -> Option<Cow<'_, str>> {
    if let Error::Database(told) = error { told.code() } else { None }
}

/// Returns whether a statement failed because the disk is full.
#[must_use]
pub fn is_disk_full(error: &Error) -> bool {
    code_of(error).is_some_and(|code| FULL.contains(&&*code))
}

/// Returns whether a statement failed because the database was unavailable or a lock timed out, in
/// which case the statement itself may be correct. If it was a commit, the transaction may have
/// been committed nevertheless.
#[must_use]
pub fn is_database_unavailable(error: &Error) -> bool {
    matches!(error, Error::Io(_) | Error::PoolTimedOut | Error::PoolClosed)
        || code_of(error).is_some_and(|code| AWAY.contains(&&*code) || code.starts_with(BROKEN))
}

/// Returns the migrations of an engine.
pub(crate) fn migrations(kind: EngineKind) -> &'static Migrator {
    match kind {
        EngineKind::Sqlite => &sqlite::MIGRATIONS,
        #[cfg(feature = "postgres")]
        EngineKind::Postgres => &postgres::MIGRATIONS,
    }
}

/// Placeholder for a restored dump: without the feature `postgres` it has no values.
#[cfg(not(feature = "postgres"))]
#[derive(Debug)]
pub enum DumpedDatabase {}

#[cfg(not(feature = "postgres"))]
impl DumpedDatabase {
    /// Refuses to restore a dump.
    ///
    /// # Errors
    /// Always. The error explains what can be verified instead.
    pub async fn restore(file: &Path, _beside: &DatabaseAddress) -> std::result::Result<Self, super::DumpRefused> {
        Err(super::DumpRefused::on_sqlite(file))
    }

    /// Unreachable: there are no values of this type.
    #[must_use]
    pub fn database(&self) -> &Database {
        match *self {}
    }

    /// Unreachable: there are no values of this type.
    ///
    /// # Errors
    /// Never.
    pub async fn remove(self) -> Result<()> {
        match self {}
    }
}

/// A lock on a database, held until dropped. For SQLite it is a locked file next to the database,
/// for PostgreSQL an advisory lock on a dedicated connection, which the server releases when the
/// connection ends.
#[derive(Debug)]
pub struct DatabaseLock {
    held: HeldDatabase,
}

#[derive(Debug)]
enum HeldDatabase {
    #[expect(dead_code, reason = "it is held, not read")]
    File(FileLock),
    #[cfg(feature = "postgres")]
    Server(postgres::ServerLock),
}

impl DatabaseLock {
    /// Returns whether this process still holds the lock. A file lock ends only with the process; a
    /// restarted server has lost its advisory locks.
    pub async fn is_held(&mut self) -> bool {
        match &mut self.held {
            HeldDatabase::File(_) => true,
            #[cfg(feature = "postgres")]
            HeldDatabase::Server(lock) => lock.is_held().await,
        }
    }
}

impl DatabaseAddress {
    /// Returns the address of a database file, for example of a backup.
    #[must_use]
    pub fn of_file(path: &Path) -> Self {
        Self::of_url(sqlite::address_of(path))
    }

    /// Returns the path of the database file.
    ///
    /// # Errors
    /// If the database is on a server; the error explains the alternative.
    pub fn file(&self) -> io::Result<PathBuf> {
        twin!(self, sqlite::file_of(self), postgres::refuse_file())
    }

    /// Returns the address of another database in the same folder or on the same server.
    ///
    /// # Errors
    /// If this address is invalid.
    pub fn sibling(&self, name: &str) -> Result<Self> {
        Ok(twin!(
            self,
            Self::of_file(&self.file()?.with_file_name(format!("{name}.db"))),
            Self::of_url(postgres::sibling(self, name)?),
        ))
    }

    /// Replaces the database with an empty one.
    ///
    /// # Errors
    /// If the file cannot be removed; on a server, if the database is in use or the role may not
    /// create databases.
    pub async fn make_anew(&self) -> Result<()> {
        twin!(self, sqlite::make_anew(self), postgres::make_anew(self).await)
    }
}

impl Database {
    /// Opens a database. A missing SQLite file is created; on a server the database must exist.
    ///
    /// # Errors
    /// If the file cannot be opened, or the server does not respond.
    pub async fn open(address: &DatabaseAddress) -> Result<Self> {
        twin!(address, sqlite::open(address, true).await, postgres::open(address).await)
    }

    /// Opens an existing database.
    ///
    /// # Errors
    /// If it does not exist or cannot be opened.
    pub async fn open_existing(address: &DatabaseAddress) -> Result<Self> {
        twin!(address, sqlite::open(address, false).await, postgres::open(address).await)
    }

    /// Returns whether the database exists: a file that is not empty, or a database on a server
    /// that was migrated.
    ///
    /// # Errors
    /// If the address is invalid, the server does not respond, or it has no such database.
    pub async fn is_there(address: &DatabaseAddress) -> Result<bool> {
        twin!(
            address,
            Ok(std::fs::metadata(address.file()?).is_ok_and(|file| file.len() > 0)),
            postgres::is_there(address).await,
        )
    }

    /// Takes the exclusive lock on a database. `holder` names this process in the error messages of
    /// others.
    ///
    /// # Errors
    /// If another process holds the lock, the lock file cannot be created, or the server does not
    /// respond.
    pub async fn hold(address: &DatabaseAddress, holder: &str) -> std::result::Result<DatabaseLock, LockError> {
        let held = twin!(
            address,
            HeldDatabase::File(hold_file(address, holder)?),
            HeldDatabase::Server(postgres::hold(address, holder).await?),
        );
        Ok(DatabaseLock { held })
    }

    /// Takes the shared lock of the processes that serve a database together. For a SQLite file the
    /// lock is exclusive, as with [`Database::hold`].
    ///
    /// # Errors
    /// Same as [`Database::hold`].
    pub async fn join(address: &DatabaseAddress, holder: &str) -> std::result::Result<DatabaseLock, LockError> {
        let held = twin!(
            address,
            HeldDatabase::File(hold_file(address, holder)?),
            HeldDatabase::Server(postgres::join(address, holder).await?),
        );
        Ok(DatabaseLock { held })
    }

    /// Returns the engine.
    pub(crate) const fn kind(&self) -> EngineKind {
        self.kind
    }

    /// Returns whether several processes may use the database at the same time.
    #[must_use]
    pub const fn is_shared(&self) -> bool {
        twin!(self, false, true)
    }

    /// Longest interval between two checks for jobs that other processes have queued. A SQLite file
    /// has no other processes.
    #[must_use]
    pub const fn listening_period(&self) -> Duration {
        twin!(self, Duration::from_secs(60), Duration::from_secs(2))
    }

    /// Starts a write transaction, after waiting for other writers.
    ///
    /// # Errors
    /// If another writer takes too long, or the server does not respond.
    pub async fn write(&self) -> Result<Write> {
        twin!(self, sqlite::write(self).await, postgres::write(self).await)
    }

    /// Same as [`Database::write`], with asynchronous commit on a server: for changes that will be
    /// repeated if the server's machine crashes within the next second and loses them. For a SQLite
    /// file it makes no difference: it has a single writing process, so that waits are short.
    ///
    /// # Errors
    /// Same as [`Database::write`].
    pub async fn write_relaxed(&self) -> Result<Write> {
        twin!(self, sqlite::write(self).await, postgres::write_relaxed(self).await)
    }

    /// Returns a finding for each trigger of the migrations that is missing, changed or disabled.
    /// Without these triggers, rows of the audit log could be altered or deleted.
    ///
    /// # Errors
    /// If the database cannot be read or was never migrated, or if no temporary schema can be
    /// created on the server.
    pub async fn lost_triggers(&self) -> Result<Vec<String>> {
        let newest = self.newest_migration().await?;
        let expected = twin!(self, sqlite::made_triggers(newest).await?, postgres::made_triggers(self, newest).await?);
        let found =
            twin!(self, sqlite::list_triggers(&self.reader).await?, postgres::list_triggers(&self.reader).await?);
        let lost = expected.into_iter().filter(|trigger| !found.contains(trigger));
        Ok(lost
            .map(|(name, _)| {
                format!("trigger {name} is missing or changed: the rows it protects may have been altered")
            })
            .collect())
    }

    /// Runs the engine's own integrity check and returns its findings: damaged pages, dangling
    /// references, invalid indices and constraints. Empty if there are no problems.
    ///
    /// # Errors
    /// If the database cannot be read at all.
    pub async fn integrity(&self) -> Result<Vec<String>> {
        twin!(self, sqlite::integrity(self).await, postgres::integrity(self).await)
    }

    /// Returns the names of all tables, including SQLite's schema table.
    ///
    /// # Errors
    /// If the database cannot be read at all.
    pub async fn list_tables(&self) -> Result<Vec<String>> {
        let list = twin!(
            self,
            "SELECT 'sqlite_schema' UNION ALL SELECT name FROM sqlite_schema WHERE type = 'table' AND name NOT LIKE 'sqlite_%'",
            "SELECT tablename::text FROM pg_tables WHERE schemaname = current_schema()",
        );
        sqlx::query_scalar(list).fetch_all(&self.reader).await
    }

    /// Checks the pages of one table. It is faster than [`Self::integrity`], which for SQLite also
    /// compares every index and counts the free pages.
    ///
    /// # Errors
    /// If the database cannot be read at all; on a server, if a page is damaged.
    pub async fn damaged_pages(&self, table: &str) -> Result<Vec<String>> {
        twin!(self, sqlite::damaged_pages(self, table).await, postgres::damaged_pages(self, table).await)
    }

    /// Copies a consistent snapshot of the database into a new file. Other processes can write
    /// meanwhile.
    ///
    /// # Errors
    /// If the file exists or cannot be written, or if the database is on a server; the error
    /// explains the alternative.
    pub async fn copy_to(&self, file: &Path) -> Result<()> {
        twin!(self, sqlite::copy_to(self, file).await, Ok(postgres::refuse_file()?))
    }

    /// Returns the name and version of the engine.
    ///
    /// # Errors
    /// If the database does not respond.
    pub async fn engine_version(&self) -> Result<String> {
        let version = twin!(
            self,
            "SELECT 'SQLite ' || sqlite_version()",
            "SELECT 'PostgreSQL ' || split_part(current_setting('server_version'), ' ', 1)",
        );
        sqlx::query_scalar(version).fetch_one(&self.reader).await
    }

    /// Returns the size of the database, in bytes.
    ///
    /// # Errors
    /// If the database cannot be read.
    pub async fn size(&self) -> Result<i64> {
        let size = twin!(
            self,
            "SELECT page_count * page_size FROM pragma_page_count, pragma_page_size",
            "SELECT pg_database_size(current_database())",
        );
        sqlx::query_scalar(size).fetch_one(&self.reader).await
    }

    /// Finishes a bulk write. SQLite: moves the write-ahead log into the file and syncs it to the
    /// disk, so that no later request has to wait for this. PostgreSQL: runs `VACUUM ANALYZE`, so
    /// that the planner has current statistics.
    ///
    /// # Errors
    /// If the disk cannot be written, or the server does not respond.
    pub async fn settle(&self) -> Result<()> {
        twin!(self, sqlite::settle(self).await, sqlx::raw_sql("VACUUM ANALYZE").execute(&self.writer).await.map(drop),)
    }

    /// Checkpoints the write-ahead log into the file and truncates it, so that overwritten data is
    /// no longer on the disk. If a reader prevents this, a later checkpoint does it. PostgreSQL
    /// needs no call: it vacuums deleted rows once no transaction can see them.
    pub async fn fold_log(&self) -> Result<()> {
        twin!(self, sqlite::fold_log(self).await, Ok(()))
    }
}

fn hold_file(address: &DatabaseAddress, holder: &str) -> std::result::Result<FileLock, LockError> {
    let file = address.file();
    let file = file.map_err(|why| LockError::Unusable { place: address.to_string(), why: why.into() })?;
    FileLock::take_beside(&file, holder)
}

/// Returns whether the database has a table.
pub(crate) async fn is_table_there(executor: impl Executor<'_>, name: &str) -> Result<bool> {
    let is_there = twin!(
        executor,
        "SELECT count(*) > 0 FROM sqlite_schema WHERE type = 'table' AND name = $1",
        "SELECT to_regclass($1) IS NOT NULL",
    );
    sqlx::query_scalar(is_there).bind(name).fetch_one(executor).await
}

/// Raises a connection's page cache to 256 MB, so that a large transaction is written to the disk
/// once. On a server the cache size is part of the server's configuration.
pub(crate) async fn keep_more_in_memory(writer: &mut Connection) -> Result<()> {
    twin!(writer, sqlx::query("PRAGMA cache_size = -256000").execute(writer).await.map(drop), Ok(()))
}

/// Updates the planner's statistics within a transaction: PostgreSQL's autovacuum only sees
/// committed rows. SQLite needs no statistics, because the statements fix the join order.
pub(crate) async fn refresh_statistics(writer: &mut Connection) -> Result<()> {
    twin!(
        writer,
        Ok(()),
        sqlx::raw_sql("ANALYZE sessions, scores, metrics, cohort_members").execute(writer).await.map(drop),
    )
}

/// Disables triggers and foreign keys until [`resume_triggers`] or the end of the transaction, if
/// the server permits it. The caller must then write everything that the triggers would have
/// written. SQLite's triggers stay enabled.
pub(crate) async fn suspend_triggers(writer: &mut Connection) -> Result<()> {
    twin!(writer, Ok(()), postgres::set_replication_role(writer, "replica").await)
}

/// Enables triggers and foreign keys again.
pub(crate) async fn resume_triggers(writer: &mut Connection) -> Result<()> {
    twin!(writer, Ok(()), postgres::set_replication_role(writer, "origin").await)
}
