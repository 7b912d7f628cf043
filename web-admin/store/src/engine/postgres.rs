//! PostgreSQL: a server, whose database is made by whoever runs it.

use std::io::{self, ErrorKind};
use std::path::{Path, PathBuf};
use std::str::FromStr;
use std::time::Duration;

use sqlx::migrate::Migrator;
use sqlx::postgres::{PgConnectOptions, PgPoolOptions};
use sqlx::{ConnectOptions as _, Connection as _};

use super::address::{DatabaseAddress, EngineKind};
pub use super::dump::DumpedDatabase;
use super::{Connection, Executor};
use crate::locks::{BETWEEN_TRIES, LockError, TRIES};
use crate::{Database, Error, Result, Write};

/// The engine.
pub type Engine = sqlx::Postgres;

/// Everything that makes the schema.
pub(crate) static MIGRATIONS: Migrator = sqlx::migrate!("../../migrations/postgres");

/// Names the lock that whoever writes holds, among those of the database.
pub(crate) const WRITING: i64 = 0x7374_796c_6574;
/// Names the lock of those that serve the database, or of the process that has it to itself.
const HOLDING: i64 = WRITING + 1;
/// Longest that a process works without a look at what others have queued.
pub(crate) const LISTENING_PERIOD: Duration = Duration::from_secs(2);
/// Whether several processes may be at work on one database at a time.
pub(crate) const SHARED: bool = true;
/// How long a statement waits for a lock before it fails.
const PATIENCE: &str = "10s";
/// PostgreSQL's code for a full disk.
const FULL: &str = "53100";
/// How long a request waits for a connection: one that is free, answers, and leads to the database.
const LONGEST_CONNECTING: Duration = Duration::from_secs(10);
/// How long a connection that has answered is taken to answer still: whoever borrows it again does not wait until it has.
const LONGEST_BELIEVED: Duration = Duration::from_secs(1);
/// Statements that the server keeps prepared for each connection: all that pages use. Of a hundred, the usual number, it would have
/// forgotten most when they come again.
const PREPARED: usize = 1000;
/// How the server ends sessions whose other end has fallen silent, so that nobody's lock outlives them: by TCP, in s and ms, and, where a
/// transaction does nothing at all, by its time.
const VIGILANCE: [(&str, &str); 5] = [
    ("tcp_keepalives_idle", "10"),
    ("tcp_keepalives_interval", "5"),
    ("tcp_keepalives_count", "3"),
    ("tcp_user_timeout", "25000"),
    ("idle_in_transaction_session_timeout", "60s"),
];
/// PostgreSQL's codes for a server that stops, starts, or has no place left, and for a lock that was not to be had in time; `08` begins those
/// for broken connections.
const AWAY: [&str; 6] = ["57P01", "57P02", "57P03", "57P05", "53300", "55P03"];

/// Whether a statement came to nothing because the disk is full.
#[must_use]
pub fn is_disk_full(error: &Error) -> bool {
    matches!(error, Error::Database(told) if told.code().as_deref() == Some(FULL))
}

/// Whether a statement came to nothing because the database does not answer, which says nothing of what was asked. What was being committed
/// may be there all the same.
#[must_use]
pub fn is_database_away(error: &Error) -> bool {
    match error {
        Error::Io(_) | Error::PoolTimedOut | Error::PoolClosed => true,
        Error::Database(told) => told.code().is_some_and(|code| AWAY.contains(&&*code) || code.starts_with("08")),
        _ => false,
    }
}

/// What this engine is among those of addresses.
pub(super) const KIND: EngineKind = EngineKind::Postgres;
/// Which addresses are allowed, and how a program for others is built.
pub(super) const ALLOWED: &str = "this program is built for PostgreSQL: allowed is a postgres:// URL; one for a sqlite: URL or a path is \
                                  built by `cargo build --release -p web-admin`";
/// What does for a server what copies of a file do otherwise.
const COPIES: &str = "this database is kept by a PostgreSQL server and is no file: pg_dump copies it while it is served, `web-admin verify --dump` \
                      checks the copy, pg_restore puts it back, or the server archives its write-ahead log (WAL archiving); recordings are \
                      copied as files";

/// The address of what no file can be.
pub(super) fn address_of(path: &Path) -> String {
    path.display().to_string()
}

/// The database `stylet` of the server that PGHOST and the like name, or else of this machine's.
pub(super) fn address_in(_folder: &Path) -> String {
    "postgres:///stylet".to_owned()
}

/// A database that this process holds until it is dropped: a lock of a connection of its own, which the server lets go of when that ends.
#[derive(Debug)]
pub struct DatabaseLock {
    connection: Connection,
}

impl DatabaseLock {
    /// Whether the server still lets this process hold it: a server that was started anew knows of no lock.
    pub async fn is_held(&mut self) -> bool {
        let asked = tokio::time::timeout(LONGEST_CONNECTING, self.connection.ping()).await;
        asked.is_ok_and(|answered| answered.is_ok())
    }
}

/// A pool whose connections answer, or are given up: neither who asks for one waits for long, nor is one kept that does not answer.
fn pool() -> PgPoolOptions {
    PgPoolOptions::new()
        .acquire_timeout(LONGEST_CONNECTING)
        .test_before_acquire(false)
        .before_acquire(|connection, lent| {
            Box::pin(async move {
                if lent.idle_for > LONGEST_BELIEVED {
                    connection.ping().await?;
                }
                Ok(true)
            })
        })
        .after_release(|connection, _| {
            Box::pin(async move {
                match tokio::time::timeout(LONGEST_CONNECTING, connection.ping()).await {
                    Ok(answered) => answered.map(|()| true),
                    // An error has it dropped without a word; one that is closed in order says so, and waits.
                    Err(_silent) => Err(Error::PoolTimedOut),
                }
            })
        })
}

impl DatabaseAddress {
    /// Of a file, as a backup holds one: a server has none.
    ///
    /// # Errors
    /// Always; they say what to do instead.
    pub fn of_file(_path: &Path) -> io::Result<Self> {
        Err(io::Error::new(ErrorKind::Unsupported, COPIES))
    }

    /// The file of the database: a server has none.
    ///
    /// # Errors
    /// Always; they say what to do instead.
    pub fn file(&self) -> io::Result<PathBuf> {
        Err(io::Error::new(ErrorKind::Unsupported, COPIES))
    }

    /// The address of another database of the same server.
    ///
    /// # Errors
    /// When this one is none of a server.
    pub fn sibling(&self, name: &str) -> Result<Self> {
        Ok(Self::of_url(PgConnectOptions::from_str(self.as_url())?.database(name).to_url_lossy().into()))
    }

    /// Makes the database anew, with nothing in it.
    ///
    /// # Errors
    /// When somebody has it open, or may not make one.
    pub async fn make_anew(&self) -> Result<()> {
        let options = PgConnectOptions::from_str(self.as_url())?;
        let name = options.get_database().unwrap_or_default().replace('"', "\"\"");
        let mut server = options.database("postgres").connect().await?;
        for statement in [
            format!("DROP DATABASE IF EXISTS \"{name}\""),
            format!("CREATE DATABASE \"{name}\" ENCODING 'UTF8' TEMPLATE template0"),
        ] {
            sqlx::raw_sql(sqlx::AssertSqlSafe(statement)).execute(&mut server).await?;
        }
        Ok(())
    }

    pub(crate) fn options(&self) -> Result<PgConnectOptions> {
        // No statement of ours is so long that compiling it would be worth the time, and none may take every processor from the others.
        let options = [("lock_timeout", PATIENCE), ("jit", "off"), ("max_parallel_workers_per_gather", "0")];
        let connecting = PgConnectOptions::from_str(self.as_url())?.statement_cache_capacity(PREPARED);
        Ok(connecting.options(options).options(VIGILANCE))
    }
}

impl Database {
    /// Opens a database, which the server must have.
    ///
    /// # Errors
    /// When the address is none of a server, or the server does not answer.
    pub async fn open(address: &DatabaseAddress) -> Result<Self> {
        let options = address.options()?;
        // Who reads twice in a transaction reads the same, as from SQLite.
        let reading = options
            .clone()
            .options([("default_transaction_read_only", "on"), ("default_transaction_isolation", "repeatable read")]);
        let writer = match pool().max_connections(1).connect_with(options.clone()).await {
            // A pool says only that it has waited: the server itself says why.
            Err(Error::PoolTimedOut) => return Err(options.connect().await.err().unwrap_or(Error::PoolTimedOut)),
            connected => connected?,
        };
        let reader = pool().max_connections(4).connect_lazy_with(reading);
        Ok(Self { writer, reader })
    }

    /// Opens a database that must be there.
    ///
    /// # Errors
    /// When it is not.
    pub async fn open_existing(address: &DatabaseAddress) -> Result<Self> {
        Self::open(address).await
    }

    /// Whether there is a database: one that was ever migrated.
    ///
    /// # Errors
    /// When the server does not answer, or has no such database.
    pub async fn is_there(address: &DatabaseAddress) -> Result<bool> {
        let mut connection = address.options()?.connect().await?;
        is_table_there(&mut connection, "_sqlx_migrations").await
    }

    /// Keeps a database from every other process that would hold it; `holder` tells them who has it.
    ///
    /// # Errors
    /// When another process holds it, or the server does not answer.
    pub async fn hold(address: &DatabaseAddress, holder: &str) -> std::result::Result<DatabaseLock, LockError> {
        Self::lock(address, holder, "SELECT pg_try_advisory_lock($1)").await
    }

    /// Holds a database beside others that serve it.
    ///
    /// # Errors
    /// When a process has it to itself, or the server does not answer.
    pub async fn join(address: &DatabaseAddress, holder: &str) -> std::result::Result<DatabaseLock, LockError> {
        Self::lock(address, holder, "SELECT pg_try_advisory_lock_shared($1)").await
    }

    async fn lock(
        address: &DatabaseAddress,
        holder: &str,
        attempt: &'static str,
    ) -> std::result::Result<DatabaseLock, LockError> {
        let unusable = |why: Error| LockError::Unusable { place: address.to_string(), why: why.into() };
        let options = address.options().map_err(unusable)?.application_name(holder);
        let mut connection = options.connect().await.map_err(unusable)?;
        for left in (0..TRIES).rev() {
            let held: bool =
                sqlx::query_scalar(attempt).bind(HOLDING).fetch_one(&mut connection).await.map_err(unusable)?;
            if held {
                return Ok(DatabaseLock { connection });
            }
            if left > 0 {
                tokio::time::sleep(BETWEEN_TRIES).await;
            }
        }
        let holder: Option<String> = sqlx::query_scalar(
            "SELECT a.application_name FROM pg_locks l JOIN pg_stat_activity a USING (pid) WHERE l.locktype = 'advisory' AND l.granted
               AND l.database = (SELECT oid FROM pg_database WHERE datname = current_database())
               AND (l.classid::BIGINT << 32) + l.objid::BIGINT = $1",
        )
        .bind(HOLDING)
        .fetch_optional(&mut connection)
        .await
        .map_err(unusable)?;
        Err(LockError::Held {
            place: address.to_string(),
            holder: holder.unwrap_or_else(|| "another process".to_owned()),
        })
    }

    /// Starts a transaction that may write, once nobody else does.
    ///
    /// # Errors
    /// When somebody writes for too long, or the server does not answer.
    pub async fn write(&self) -> Result<Write> {
        let mut begun = self.writer.begin().await?;
        sqlx::query("SELECT pg_advisory_xact_lock($1)").bind(WRITING).execute(&mut *begun).await?;
        Ok(begun)
    }

    /// As [`Database::write`], for what is done again should the server's machine lose it within the next second: whoever waits to write does
    /// not wait for the disk.
    ///
    /// # Errors
    /// As there.
    pub async fn write_relaxed(&self) -> Result<Write> {
        let mut begun = self.writer.begin().await?;
        sqlx::query("SELECT pg_advisory_xact_lock($1), set_config('synchronous_commit', 'off', TRUE)")
            .bind(WRITING)
            .execute(&mut *begun)
            .await?;
        Ok(begun)
    }

    /// Triggers that the migrations made and that are gone, changed or switched off: without them the audit log may shrink.
    ///
    /// # Errors
    /// When the server does not answer, or no schema may be made beside the database's own.
    pub async fn lost_triggers(&self) -> Result<Vec<String>> {
        let newest = self.newest_migration().await?;
        let mut tx = self.writer.begin().await?;
        let found = triggers(&mut *tx).await?;
        sqlx::raw_sql("CREATE SCHEMA fresh; SET LOCAL search_path = fresh").execute(&mut *tx).await?;
        for migration in MIGRATIONS.iter().filter(|migration| migration.version <= newest) {
            sqlx::raw_sql(migration.sql.clone()).execute(&mut *tx).await?;
        }
        let expected = triggers(&mut *tx).await?;
        tx.rollback().await?;
        let lost = expected.into_iter().filter(|trigger| !found.contains(trigger));
        Ok(lost
            .map(|(name, _)| format!("trigger {name} is gone or changed: rows that it keeps may have been altered"))
            .collect())
    }

    /// What PostgreSQL itself knows to be wrong: indices and references that do not hold. Empty when all is well.
    ///
    /// # Errors
    /// When the server does not answer.
    pub async fn integrity(&self) -> Result<Vec<String>> {
        sqlx::query_scalar(
            "SELECT indexrelid::regclass || ': the index is not valid' FROM pg_index WHERE NOT indisvalid
             UNION ALL SELECT conrelid::regclass || ': ' || conname || ' was never checked' FROM pg_constraint WHERE NOT convalidated",
        )
        .fetch_all(&self.reader)
        .await
    }

    /// Every table.
    ///
    /// # Errors
    /// When the server does not answer.
    pub async fn list_tables(&self) -> Result<Vec<String>> {
        sqlx::query_scalar("SELECT tablename::text FROM pg_tables WHERE schemaname = current_schema()")
            .fetch_all(&self.reader)
            .await
    }

    /// What is wrong with the pages of a table: PostgreSQL says so of each that it reads.
    ///
    /// # Errors
    /// When a page is damaged, or the server does not answer.
    pub async fn damaged_pages(&self, table: &str) -> Result<Vec<String>> {
        let read = format!("SELECT count(t.*) FROM {table} t");
        sqlx::query(sqlx::AssertSqlSafe(read)).execute(&self.reader).await?;
        Ok(Vec::new())
    }

    /// Copies the database into a file: what `pg_dump` does for a server.
    ///
    /// # Errors
    /// Always; they say what to do instead.
    pub async fn copy_to(&self, _file: &Path) -> Result<()> {
        Err(io::Error::new(ErrorKind::Unsupported, COPIES).into())
    }

    /// What keeps the database, and which version of it.
    ///
    /// # Errors
    /// When it does not answer.
    pub async fn engine_version(&self) -> Result<String> {
        sqlx::query_scalar("SELECT 'PostgreSQL ' || split_part(current_setting('server_version'), ' ', 1)")
            .fetch_one(&self.reader)
            .await
    }

    /// How large the database is, in bytes.
    ///
    /// # Errors
    /// When the server does not answer.
    pub async fn size(&self) -> Result<i64> {
        sqlx::query_scalar("SELECT pg_database_size(current_database())").fetch_one(&self.reader).await
    }

    /// After much was written: what was is found quickly from now on.
    ///
    /// # Errors
    /// When the server does not answer.
    pub async fn settle(&self) -> Result<()> {
        sqlx::raw_sql("VACUUM ANALYZE").execute(&self.writer).await.map(drop)
    }

    /// Lets go of what was overwritten: a server does so by itself, when nobody can see it any more.
    pub async fn fold_log(&self) -> Result<()> {
        Ok(())
    }
}

/// Every trigger of the schema that is written to: name, and all that it does.
async fn triggers(executor: impl Executor<'_>) -> Result<Vec<(String, String)>> {
    sqlx::query_as(
        "SELECT t.tgname::text, concat(pg_get_triggerdef(t.oid, TRUE), ' ', t.tgenabled, ' ', p.prosrc)
         FROM pg_trigger t JOIN pg_class c ON c.oid = t.tgrelid JOIN pg_proc p ON p.oid = t.tgfoid
         WHERE NOT t.tgisinternal AND c.relnamespace = current_schema()::regnamespace ORDER BY t.tgname",
    )
    .fetch_all(executor)
    .await
}

/// Whether the database has a table.
pub(crate) async fn is_table_there(executor: impl Executor<'_>, name: &str) -> Result<bool> {
    sqlx::query_scalar("SELECT to_regclass($1) IS NOT NULL").bind(name).fetch_one(executor).await
}

/// Lets a connection keep more of the database in memory: what a server keeps there is said where it is started.
pub(crate) async fn keep_more_in_memory(_writer: &mut Connection) -> Result<()> {
    Ok(())
}

/// Counts anew what the planner goes by, in the middle of a transaction: the server does so by itself, but only between two of them.
pub(crate) async fn refresh_statistics(writer: &mut Connection) -> Result<()> {
    sqlx::raw_sql("ANALYZE sessions, scores, metrics, cohort_members").execute(writer).await.map(drop)
}

/// Has triggers and references rest until [`resume_triggers`], or the transaction's end, where the server lets us: whoever writes then
/// writes what would follow, too.
pub(crate) async fn suspend_triggers(writer: &mut Connection) -> Result<()> {
    set_replication_role(writer, "replica").await
}

/// Has triggers and references hold again.
pub(crate) async fn resume_triggers(writer: &mut Connection) -> Result<()> {
    set_replication_role(writer, "origin").await
}

async fn set_replication_role(writer: &mut Connection, role: &str) -> Result<()> {
    sqlx::query(
        "SELECT set_config('session_replication_role', $1, TRUE) FROM pg_roles WHERE rolname = current_user AND rolsuper",
    )
    .bind(role)
    .execute(writer)
    .await
    .map(drop)
}
