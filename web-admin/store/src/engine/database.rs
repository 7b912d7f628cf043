//! The database and its address: each function calls the module of the engine that the address names.

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

/// SQLite's result code for a full disk, and PostgreSQL's.
const FULL: [&str; 2] = ["13", "53100"];
/// SQLite's result code when another process writes for too long; PostgreSQL's codes for a server that stops, starts, or has no place left,
/// and for a lock that was not to be had in time.
const AWAY: [&str; 7] = ["5", "57P01", "57P02", "57P03", "57P05", "53300", "55P03"];
/// What begins PostgreSQL's codes for broken connections.
const BROKEN: &str = "08";

fn code_of(error: &Error) -> Option<Cow<'_, str>> {
    if let Error::Database(told) = error { told.code() } else { None }
}

/// Whether a statement failed because the disk is full.
#[must_use]
pub fn is_disk_full(error: &Error) -> bool {
    code_of(error).is_some_and(|code| FULL.contains(&&*code))
}

/// Whether a statement failed because the database does not answer, or could not be locked in time, which says nothing of the statement.
/// What it was committing may be kept all the same.
#[must_use]
pub fn is_database_away(error: &Error) -> bool {
    matches!(error, Error::Io(_) | Error::PoolTimedOut | Error::PoolClosed)
        || code_of(error).is_some_and(|code| AWAY.contains(&&*code) || code.starts_with(BROKEN))
}

/// Everything that makes the schema.
pub(crate) fn migrations(kind: EngineKind) -> &'static Migrator {
    match kind {
        EngineKind::Sqlite => &sqlite::MIGRATIONS,
        #[cfg(feature = "postgres")]
        EngineKind::Postgres => &postgres::MIGRATIONS,
    }
}

/// A dump of a server's database, in a database of its own: this program speaks to no server.
#[cfg(not(feature = "postgres"))]
#[derive(Debug)]
pub enum DumpedDatabase {}

#[cfg(not(feature = "postgres"))]
impl DumpedDatabase {
    /// Refuses.
    ///
    /// # Errors
    /// Always; they say what is verified instead.
    pub async fn restore(file: &Path, _beside: &DatabaseAddress) -> std::result::Result<Self, super::DumpRefused> {
        Err(super::DumpRefused::on_sqlite(file))
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

/// A database that this process holds until it is dropped: a locked file beside the database's, or a lock of a connection of its own,
/// which the server lets go of when that ends.
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
    /// Whether this process still holds it: a file's lock is lost with the process alone, and a server that was started anew knows of no
    /// lock.
    pub async fn is_held(&mut self) -> bool {
        match &mut self.held {
            HeldDatabase::File(_) => true,
            #[cfg(feature = "postgres")]
            HeldDatabase::Server(lock) => lock.is_held().await,
        }
    }
}

impl DatabaseAddress {
    /// Of a file, as a backup holds one.
    #[must_use]
    pub fn of_file(path: &Path) -> Self {
        Self::of_url(sqlite::address_of(path))
    }

    /// The file of the database.
    ///
    /// # Errors
    /// When a server keeps it; they say what to do instead.
    pub fn file(&self) -> io::Result<PathBuf> {
        twin!(self, sqlite::file_of(self), postgres::refuse_file())
    }

    /// The address of another database in the same folder, or of the same server.
    ///
    /// # Errors
    /// When this one is none of a file or a server.
    pub fn sibling(&self, name: &str) -> Result<Self> {
        Ok(twin!(
            self,
            Self::of_file(&self.file()?.with_file_name(format!("{name}.db"))),
            Self::of_url(postgres::sibling(self, name)?),
        ))
    }

    /// Makes the database anew, with nothing in it.
    ///
    /// # Errors
    /// When the file cannot be removed; when somebody has the server's database open, or may not make one.
    pub async fn make_anew(&self) -> Result<()> {
        twin!(self, sqlite::make_anew(self), postgres::make_anew(self).await)
    }
}

impl Database {
    /// Opens a database, and makes its file where it is missing. A server must have it.
    ///
    /// # Errors
    /// When the file cannot be opened, or the server does not answer.
    pub async fn open(address: &DatabaseAddress) -> Result<Self> {
        twin!(address, sqlite::open(address, true).await, postgres::open(address).await)
    }

    /// Opens a database that must be there.
    ///
    /// # Errors
    /// When it is not.
    pub async fn open_existing(address: &DatabaseAddress) -> Result<Self> {
        twin!(address, sqlite::open(address, false).await, postgres::open(address).await)
    }

    /// Whether there is a database: a file that holds something, or one of a server that was ever migrated.
    ///
    /// # Errors
    /// When the address is none of a file; when the server does not answer, or has no such database.
    pub async fn is_there(address: &DatabaseAddress) -> Result<bool> {
        twin!(
            address,
            Ok(std::fs::metadata(address.file()?).is_ok_and(|file| file.len() > 0)),
            postgres::is_there(address).await,
        )
    }

    /// Keeps a database from every other process that would hold it; `holder` tells them who has it.
    ///
    /// # Errors
    /// When another process holds it, no file can be made beside it, or the server does not answer.
    pub async fn hold(address: &DatabaseAddress, holder: &str) -> std::result::Result<DatabaseLock, LockError> {
        let held = twin!(
            address,
            HeldDatabase::File(hold_file(address, holder)?),
            HeldDatabase::Server(postgres::hold(address, holder).await?),
        );
        Ok(DatabaseLock { held })
    }

    /// Holds a database beside others that serve it: of a file, as [`Database::hold`].
    ///
    /// # Errors
    /// As there.
    pub async fn join(address: &DatabaseAddress, holder: &str) -> std::result::Result<DatabaseLock, LockError> {
        let held = twin!(
            address,
            HeldDatabase::File(hold_file(address, holder)?),
            HeldDatabase::Server(postgres::join(address, holder).await?),
        );
        Ok(DatabaseLock { held })
    }

    /// Which engine keeps it.
    pub(crate) const fn kind(&self) -> EngineKind {
        self.kind
    }

    /// Whether several processes may be at work on one database at a time.
    #[must_use]
    pub const fn is_shared(&self) -> bool {
        twin!(self, false, true)
    }

    /// Longest between two looks at what others have queued. To a file there are no others.
    #[must_use]
    pub const fn listening_period(&self) -> Duration {
        twin!(self, Duration::from_secs(60), Duration::from_secs(2))
    }

    /// Starts a transaction that may write, once nobody else does.
    ///
    /// # Errors
    /// When somebody writes for too long, or the server does not answer.
    pub async fn write(&self) -> Result<Write> {
        twin!(self, sqlite::write(self).await, postgres::write(self).await)
    }

    /// As [`Database::write`], for what is done again should a server's machine lose it within the next second. To a file one process alone
    /// writes, and nobody waits for it long.
    ///
    /// # Errors
    /// As there.
    pub async fn write_relaxed(&self) -> Result<Write> {
        twin!(self, sqlite::write(self).await, postgres::write_relaxed(self).await)
    }

    /// Triggers that the migrations made and that are gone, changed or switched off: without them the audit log may shrink.
    ///
    /// # Errors
    /// When the database cannot be read, or was never migrated; when no schema may be made beside a server's own.
    pub async fn lost_triggers(&self) -> Result<Vec<String>> {
        let newest = self.newest_migration().await?;
        let expected = twin!(self, sqlite::made_triggers(newest).await?, postgres::made_triggers(self, newest).await?);
        let found =
            twin!(self, sqlite::list_triggers(&self.reader).await?, postgres::list_triggers(&self.reader).await?);
        let lost = expected.into_iter().filter(|trigger| !found.contains(trigger));
        Ok(lost
            .map(|(name, _)| format!("trigger {name} is gone or changed: rows that it keeps may have been altered"))
            .collect())
    }

    /// What the engine itself finds wrong with its data: damaged pages, rows that point nowhere, indices and references that do not hold.
    /// Empty when all is well.
    ///
    /// # Errors
    /// When the database cannot be read at all.
    pub async fn integrity(&self) -> Result<Vec<String>> {
        twin!(self, sqlite::integrity(self).await, postgres::integrity(self).await)
    }

    /// Every table; SQLite's own of the schema included.
    ///
    /// # Errors
    /// When the database cannot be read at all.
    pub async fn list_tables(&self) -> Result<Vec<String>> {
        let list = twin!(
            self,
            "SELECT 'sqlite_schema' UNION ALL SELECT name FROM sqlite_schema WHERE type = 'table' AND name NOT LIKE 'sqlite_%'",
            "SELECT tablename::text FROM pg_tables WHERE schemaname = current_schema()",
        );
        sqlx::query_scalar(list).fetch_all(&self.reader).await
    }

    /// What the engine finds wrong with the pages of a table: quicker than [`Self::integrity`], which of SQLite also compares every index
    /// and counts the pages that are free.
    ///
    /// # Errors
    /// When the database cannot be read at all; of a server, when a page is damaged.
    pub async fn damaged_pages(&self, table: &str) -> Result<Vec<String>> {
        twin!(self, sqlite::damaged_pages(self, table).await, postgres::damaged_pages(self, table).await)
    }

    /// Copies the database as it is at one moment into a file that must not exist. Others go on writing meanwhile.
    ///
    /// # Errors
    /// When the file exists, or the disk refuses; when a server keeps it: they say what to do instead.
    pub async fn copy_to(&self, file: &Path) -> Result<()> {
        twin!(self, sqlite::copy_to(self, file).await, Ok(postgres::refuse_file()?))
    }

    /// What keeps the database, and which version of it.
    ///
    /// # Errors
    /// When it does not answer.
    pub async fn engine_version(&self) -> Result<String> {
        let version = twin!(
            self,
            "SELECT 'SQLite ' || sqlite_version()",
            "SELECT 'PostgreSQL ' || split_part(current_setting('server_version'), ' ', 1)",
        );
        sqlx::query_scalar(version).fetch_one(&self.reader).await
    }

    /// How large the database is, in bytes.
    ///
    /// # Errors
    /// When it cannot be read.
    pub async fn size(&self) -> Result<i64> {
        let size = twin!(
            self,
            "SELECT page_count * page_size FROM pragma_page_count, pragma_page_size",
            "SELECT pg_database_size(current_database())",
        );
        sqlx::query_scalar(size).fetch_one(&self.reader).await
    }

    /// After much was written: it is on the disk, and in the file itself, before anybody else waits for that; a server finds it quickly from
    /// now on.
    ///
    /// # Errors
    /// When the disk refuses, or the server does not answer.
    pub async fn settle(&self) -> Result<()> {
        twin!(self, sqlite::settle(self).await, sqlx::raw_sql("VACUUM ANALYZE").execute(&self.writer).await.map(drop),)
    }

    /// Folds the write-ahead log into the file and empties it, so that what was overwritten stands nowhere on the disk. Where a reader is
    /// in the way, the next one that writes much does it. A server lets go by itself, when nobody can see it any more.
    pub async fn fold_log(&self) -> Result<()> {
        twin!(self, sqlite::fold_log(self).await, Ok(()))
    }
}

fn hold_file(address: &DatabaseAddress, holder: &str) -> std::result::Result<FileLock, LockError> {
    let file = address.file();
    let file = file.map_err(|why| LockError::Unusable { place: address.to_string(), why: why.into() })?;
    FileLock::take_beside(&file, holder)
}

/// Whether the database has a table.
pub(crate) async fn is_table_there(executor: impl Executor<'_>, name: &str) -> Result<bool> {
    let is_there = twin!(
        executor,
        "SELECT count(*) > 0 FROM sqlite_schema WHERE type = 'table' AND name = $1",
        "SELECT to_regclass($1) IS NOT NULL",
    );
    sqlx::query_scalar(is_there).bind(name).fetch_one(executor).await
}

/// Lets a connection keep 256 MB of the database in memory, so that a large transaction goes to the disk once: what a server keeps there
/// is said where it is started.
pub(crate) async fn keep_more_in_memory(writer: &mut Connection) -> Result<()> {
    twin!(writer, sqlx::query("PRAGMA cache_size = -256000").execute(writer).await.map(drop), Ok(()))
}

/// Counts anew what the planner goes by, in the middle of a transaction: a server does so by itself, but only between two of them. SQLite
/// goes by nothing of it, for the order of a join is as it is written.
pub(crate) async fn refresh_statistics(writer: &mut Connection) -> Result<()> {
    twin!(
        writer,
        Ok(()),
        sqlx::raw_sql("ANALYZE sessions, scores, metrics, cohort_members").execute(writer).await.map(drop),
    )
}

/// Has triggers and references rest until [`resume_triggers`], or the transaction's end, where a server lets us: whoever writes then
/// writes what would follow, too. SQLite's never rest.
pub(crate) async fn suspend_triggers(writer: &mut Connection) -> Result<()> {
    twin!(writer, Ok(()), postgres::set_replication_role(writer, "replica").await)
}

/// Has triggers and references hold again.
pub(crate) async fn resume_triggers(writer: &mut Connection) -> Result<()> {
    twin!(writer, Ok(()), postgres::set_replication_role(writer, "origin").await)
}
