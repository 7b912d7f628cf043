//! PostgreSQL. The database on the server is created by its administrator.

use std::io;
use std::str::FromStr;
use std::time::Duration;

use sqlx::migrate::Migrator;
use sqlx::pool::PoolOptions;
use sqlx::postgres::{PgConnectOptions, PgConnection};
use sqlx::{ConnectOptions as _, Connection as _};

use super::address::DatabaseAddress;
use super::driver::Engine;
use super::{Connection, EngineKind, Executor, is_table_there};
use crate::locks::{BETWEEN_TRIES, LockError, TRIES};
use crate::{Database, Error, Result, Write};

/// The migrations.
pub(super) static MIGRATIONS: Migrator = sqlx::migrate!("../../migrations/postgres");

/// Key of the advisory lock that serializes writers.
pub(crate) const WRITING: i64 = 0x7374_796c_6574;
/// Key of the advisory lock held by all processes that serve the database, or exclusively by one
/// process.
const HOLDING: i64 = WRITING + 1;
/// Lock timeout of a statement.
const PATIENCE: &str = "10s";
/// Timeout for a request to get a working connection from the pool.
const LONGEST_CONNECTING: Duration = Duration::from_secs(10);
/// Longest idle time after which a connection is reused without a ping.
const LONGEST_BELIEVED: Duration = Duration::from_secs(1);
/// Number of prepared statements cached per connection: enough for the statements of all pages.
/// With the default of 100, most would be evicted before they are used again.
const PREPARED: usize = 1000;
/// Settings by which the server ends sessions with unresponsive clients, so that their locks are
/// released: TCP keepalive in s, TCP user timeout in ms, and the timeout for idle transactions.
const VIGILANCE: [(&str, &str); 5] = [
    ("tcp_keepalives_idle", "10"),
    ("tcp_keepalives_interval", "5"),
    ("tcp_keepalives_count", "3"),
    ("tcp_user_timeout", "25000"),
    ("idle_in_transaction_session_timeout", "60s"),
];
/// Error message: the alternatives to copying the database as a file.
const COPIES: &str = "this database is on a PostgreSQL server, not in a file: copy it with pg_dump while it is served, check the copy with `web-admin verify --dump` and restore it with pg_restore, or let the server archive its write-ahead log (WAL archiving); recordings are copied as files";

/// A lock on a database, held until dropped: an advisory lock on a dedicated connection, which the
/// server releases when the connection ends.
#[derive(Debug)]
pub(super) struct ServerLock {
    connection: PgConnection,
}

impl ServerLock {
    /// Returns whether the lock is still held. A restarted server has lost its advisory locks.
    pub(super) async fn is_held(&mut self) -> bool {
        let asked = tokio::time::timeout(LONGEST_CONNECTING, self.connection.ping()).await;
        asked.is_ok_and(|answered| answered.is_ok())
    }
}

/// Makes a pool that discards unresponsive connections, so that no request waits for one longer
/// than the timeout.
fn pool() -> PoolOptions<Engine> {
    PoolOptions::new()
        .acquire_timeout(LONGEST_CONNECTING)
        .test_before_acquire(false)
        .before_acquire(|connection: &mut Connection, lent| {
            Box::pin(async move {
                if lent.idle_for > LONGEST_BELIEVED {
                    connection.ping().await?;
                }
                Ok(true)
            })
        })
        .after_release(|connection: &mut Connection, _| {
            Box::pin(async move {
                match tokio::time::timeout(LONGEST_CONNECTING, connection.ping()).await {
                    Ok(answered) => answered.map(|()| true),
                    // The error makes the pool drop the connection at once. An orderly close would
                    // send a message and wait for the unresponsive server.
                    Err(_silent) => Err(Error::PoolTimedOut),
                }
            })
        })
}

/// Returns the connection options for an address.
pub(crate) fn options(address: &DatabaseAddress) -> Result<PgConnectOptions> {
    // JIT compilation would take longer than any of our statements runs, and parallel workers would
    // let one statement occupy all processors.
    let options = [("lock_timeout", PATIENCE), ("jit", "off"), ("max_parallel_workers_per_gather", "0")];
    let connecting = PgConnectOptions::from_str(address.as_url())?.statement_cache_capacity(PREPARED);
    Ok(connecting.options(options).options(VIGILANCE))
}

/// Returns the address of another database on the same server.
pub(super) fn sibling(address: &DatabaseAddress, name: &str) -> Result<String> {
    Ok(PgConnectOptions::from_str(address.as_url())?.database(name).to_url_lossy().into())
}

/// Returns the error for an operation that needs a database file; it explains the alternatives.
pub(super) fn refuse_file<T>() -> io::Result<T> {
    Err(io::Error::new(io::ErrorKind::Unsupported, COPIES))
}

/// Replaces the database with an empty one.
pub(super) async fn make_anew(address: &DatabaseAddress) -> Result<()> {
    let options = PgConnectOptions::from_str(address.as_url())?;
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

/// Opens a database, which must exist on the server.
pub(super) async fn open(address: &DatabaseAddress) -> Result<Database> {
    let options = options(address)?;
    // Repeated reads in a transaction return the same rows, as with SQLite.
    let reading = options
        .clone()
        .options([("default_transaction_read_only", "on"), ("default_transaction_isolation", "repeatable read")]);
    let writer = match pool().max_connections(1).connect_with(options.clone().into()).await {
        // The pool reports only a timeout; a direct connection attempt returns the server's error.
        Err(Error::PoolTimedOut) => return Err(options.connect().await.err().unwrap_or(Error::PoolTimedOut)),
        connected => connected?,
    };
    let reader = pool().max_connections(4).connect_lazy_with(reading.into());
    Ok(Database { writer, reader, kind: EngineKind::Postgres })
}

/// Returns whether the database was ever migrated.
pub(super) async fn is_there(address: &DatabaseAddress) -> Result<bool> {
    let mut connection = Connection::Postgres(options(address)?.connect().await?);
    is_table_there(&mut connection, "_sqlx_migrations").await
}

/// Takes the exclusive lock on a database.
pub(super) async fn hold(address: &DatabaseAddress, holder: &str) -> std::result::Result<ServerLock, LockError> {
    lock(address, holder, "SELECT pg_try_advisory_lock($1)").await
}

/// Takes the shared lock of the processes that serve a database together.
pub(super) async fn join(address: &DatabaseAddress, holder: &str) -> std::result::Result<ServerLock, LockError> {
    lock(address, holder, "SELECT pg_try_advisory_lock_shared($1)").await
}

async fn lock(
    address: &DatabaseAddress,
    holder: &str,
    attempt: &'static str,
) -> std::result::Result<ServerLock, LockError> {
    let unusable = |why: Error| LockError::Unusable { place: address.to_string(), why: why.into() };
    let connecting = options(address).map_err(unusable)?.application_name(holder);
    let mut connection = connecting.connect().await.map_err(unusable)?;
    for left in (0..TRIES).rev() {
        let held: bool =
            sqlx::query_scalar(attempt).bind(HOLDING).fetch_one(&mut connection).await.map_err(unusable)?;
        if held {
            return Ok(ServerLock { connection });
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
    Err(LockError::Held { place: address.to_string(), holder: holder.unwrap_or_else(|| "another process".to_owned()) })
}

/// Starts a write transaction, after waiting for other writers.
pub(super) async fn write(database: &Database) -> Result<Write> {
    let mut begun = database.writer.begin().await?;
    sqlx::query("SELECT pg_advisory_xact_lock($1)").bind(WRITING).execute(&mut *begun).await?;
    Ok(begun)
}

/// Same as [`write`], with asynchronous commit, so that waiting writers need not wait for the disk:
/// for changes that will be repeated if the server's machine crashes within the next second and
/// loses them.
pub(super) async fn write_relaxed(database: &Database) -> Result<Write> {
    let mut begun = database.writer.begin().await?;
    sqlx::query("SELECT pg_advisory_xact_lock($1), set_config('synchronous_commit', 'off', TRUE)")
        .bind(WRITING)
        .execute(&mut *begun)
        .await?;
    Ok(begun)
}

/// Returns the triggers that the migrations up to `newest` create. They are run in a temporary
/// schema.
pub(super) async fn made_triggers(database: &Database, newest: i64) -> Result<Vec<(String, String)>> {
    let mut tx = database.writer.begin().await?;
    sqlx::raw_sql("CREATE SCHEMA fresh; SET LOCAL search_path = fresh").execute(&mut *tx).await?;
    for migration in MIGRATIONS.iter().filter(|migration| migration.version <= newest) {
        sqlx::raw_sql(migration.sql.clone()).execute(&mut *tx).await?;
    }
    let made = list_triggers(&mut *tx).await?;
    tx.rollback().await?;
    Ok(made)
}

/// Returns all triggers of the current schema: name, and definition, state and source code.
pub(super) async fn list_triggers(executor: impl Executor<'_>) -> Result<Vec<(String, String)>> {
    sqlx::query_as(
        "SELECT t.tgname::text, concat(pg_get_triggerdef(t.oid, TRUE), ' ', t.tgenabled, ' ', p.prosrc)
         FROM pg_trigger t JOIN pg_class c ON c.oid = t.tgrelid JOIN pg_proc p ON p.oid = t.tgfoid
         WHERE NOT t.tgisinternal AND c.relnamespace = current_schema()::regnamespace ORDER BY t.tgname",
    )
    .fetch_all(executor)
    .await
}

/// Returns invalid indices and constraints that were never validated.
pub(super) async fn integrity(database: &Database) -> Result<Vec<String>> {
    sqlx::query_scalar(
        "SELECT indexrelid::regclass || ': the index is not valid' FROM pg_index WHERE NOT indisvalid
         UNION ALL SELECT conrelid::regclass || ': ' || conname || ' was never checked' FROM pg_constraint WHERE NOT convalidated",
    )
    .fetch_all(&database.reader)
    .await
}

/// Reads all rows of a table. PostgreSQL returns an error for a damaged page.
pub(super) async fn damaged_pages(database: &Database, table: &str) -> Result<Vec<String>> {
    let read = format!("SELECT count(t.*) FROM {table} t");
    sqlx::query(sqlx::AssertSqlSafe(read)).execute(&database.reader).await?;
    Ok(Vec::new())
}

/// Disables triggers and foreign keys (`replica`) or enables them (`origin`) until the end of the
/// transaction, if the role is a superuser.
pub(super) async fn set_replication_role(writer: &mut Connection, role: &str) -> Result<()> {
    sqlx::query(
        "SELECT set_config('session_replication_role', $1, TRUE) FROM pg_roles WHERE rolname = current_user AND rolsuper",
    )
    .bind(role)
    .execute(writer)
    .await
    .map(drop)
}
