//! PostgreSQL: a server, whose database is made by whoever runs it.

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

/// Everything that makes the schema.
pub(super) static MIGRATIONS: Migrator = sqlx::migrate!("../../migrations/postgres");

/// Names the lock that whoever writes holds, among those of the database.
pub(crate) const WRITING: i64 = 0x7374_796c_6574;
/// Names the lock of those that serve the database, or of the process that has it to itself.
const HOLDING: i64 = WRITING + 1;
/// How long a statement waits for a lock before it fails.
const PATIENCE: &str = "10s";
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
/// What does for a server what copies of a file do otherwise.
const COPIES: &str = "this database is kept by a PostgreSQL server and is no file: pg_dump copies it while it is served, `web-admin verify --dump` \
                      checks the copy, pg_restore puts it back, or the server archives its write-ahead log (WAL archiving); recordings are \
                      copied as files";

/// A database that this process holds until it is dropped: a lock of a connection of its own, which the server lets go of when that ends.
#[derive(Debug)]
pub(super) struct ServerLock {
    connection: PgConnection,
}

impl ServerLock {
    /// Whether the server still lets this process hold it: a server that was started anew knows of no lock.
    pub(super) async fn is_held(&mut self) -> bool {
        let asked = tokio::time::timeout(LONGEST_CONNECTING, self.connection.ping()).await;
        asked.is_ok_and(|answered| answered.is_ok())
    }
}

/// A pool whose connections answer, or are given up: neither who asks for one waits for long, nor is one kept that does not answer.
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
                    // An error has it dropped without a word; one that is closed in order says so, and waits.
                    Err(_silent) => Err(Error::PoolTimedOut),
                }
            })
        })
}

/// How to connect to the database of an address.
pub(crate) fn options(address: &DatabaseAddress) -> Result<PgConnectOptions> {
    // No statement of ours is so long that compiling it would be worth the time, and none may take every processor from the others.
    let options = [("lock_timeout", PATIENCE), ("jit", "off"), ("max_parallel_workers_per_gather", "0")];
    let connecting = PgConnectOptions::from_str(address.as_url())?.statement_cache_capacity(PREPARED);
    Ok(connecting.options(options).options(VIGILANCE))
}

/// The address of another database of the same server.
pub(super) fn sibling(address: &DatabaseAddress, name: &str) -> Result<String> {
    Ok(PgConnectOptions::from_str(address.as_url())?.database(name).to_url_lossy().into())
}

/// Refuses what a file can do and a server cannot; says what to do instead.
pub(super) fn refuse_file<T>() -> io::Result<T> {
    Err(io::Error::new(io::ErrorKind::Unsupported, COPIES))
}

/// Makes the database anew, with nothing in it.
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

/// Opens a database, which the server must have.
pub(super) async fn open(address: &DatabaseAddress) -> Result<Database> {
    let options = options(address)?;
    // Who reads twice in a transaction reads the same, as from SQLite.
    let reading = options
        .clone()
        .options([("default_transaction_read_only", "on"), ("default_transaction_isolation", "repeatable read")]);
    let writer = match pool().max_connections(1).connect_with(options.clone().into()).await {
        // A pool says only that it has waited: the server itself says why.
        Err(Error::PoolTimedOut) => return Err(options.connect().await.err().unwrap_or(Error::PoolTimedOut)),
        connected => connected?,
    };
    let reader = pool().max_connections(4).connect_lazy_with(reading.into());
    Ok(Database { writer, reader, kind: EngineKind::Postgres })
}

/// Whether there is a database: one that was ever migrated.
pub(super) async fn is_there(address: &DatabaseAddress) -> Result<bool> {
    let mut connection = Connection::Postgres(options(address)?.connect().await?);
    is_table_there(&mut connection, "_sqlx_migrations").await
}

/// Keeps a database from every other process that would hold it.
pub(super) async fn hold(address: &DatabaseAddress, holder: &str) -> std::result::Result<ServerLock, LockError> {
    lock(address, holder, "SELECT pg_try_advisory_lock($1)").await
}

/// Holds a database beside others that serve it.
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

/// Starts a transaction that may write, once nobody else does.
pub(super) async fn write(database: &Database) -> Result<Write> {
    let mut begun = database.writer.begin().await?;
    sqlx::query("SELECT pg_advisory_xact_lock($1)").bind(WRITING).execute(&mut *begun).await?;
    Ok(begun)
}

/// As [`write`], for what is done again should the server's machine lose it within the next second: whoever waits to write does not wait
/// for the disk.
pub(super) async fn write_relaxed(database: &Database) -> Result<Write> {
    let mut begun = database.writer.begin().await?;
    sqlx::query("SELECT pg_advisory_xact_lock($1), set_config('synchronous_commit', 'off', TRUE)")
        .bind(WRITING)
        .execute(&mut *begun)
        .await?;
    Ok(begun)
}

/// The triggers that migrations as far as one make, in a schema beside the database's own.
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

/// Every trigger of the schema that is written to: name, and all that it does.
pub(super) async fn list_triggers(executor: impl Executor<'_>) -> Result<Vec<(String, String)>> {
    sqlx::query_as(
        "SELECT t.tgname::text, concat(pg_get_triggerdef(t.oid, TRUE), ' ', t.tgenabled, ' ', p.prosrc)
         FROM pg_trigger t JOIN pg_class c ON c.oid = t.tgrelid JOIN pg_proc p ON p.oid = t.tgfoid
         WHERE NOT t.tgisinternal AND c.relnamespace = current_schema()::regnamespace ORDER BY t.tgname",
    )
    .fetch_all(executor)
    .await
}

/// What PostgreSQL itself knows to be wrong: indices and references that do not hold.
pub(super) async fn integrity(database: &Database) -> Result<Vec<String>> {
    sqlx::query_scalar(
        "SELECT indexrelid::regclass || ': the index is not valid' FROM pg_index WHERE NOT indisvalid
         UNION ALL SELECT conrelid::regclass || ': ' || conname || ' was never checked' FROM pg_constraint WHERE NOT convalidated",
    )
    .fetch_all(&database.reader)
    .await
}

/// What is wrong with the pages of a table: PostgreSQL says so of each that it reads.
pub(super) async fn damaged_pages(database: &Database, table: &str) -> Result<Vec<String>> {
    let read = format!("SELECT count(t.*) FROM {table} t");
    sqlx::query(sqlx::AssertSqlSafe(read)).execute(&database.reader).await?;
    Ok(Vec::new())
}

/// Has triggers and references rest, or hold again, until the transaction's end, where the server lets us.
pub(super) async fn set_replication_role(writer: &mut Connection, role: &str) -> Result<()> {
    sqlx::query(
        "SELECT set_config('session_replication_role', $1, TRUE) FROM pg_roles WHERE rolname = current_user AND rolsuper",
    )
    .bind(role)
    .execute(writer)
    .await
    .map(drop)
}
