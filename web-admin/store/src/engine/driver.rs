//! A driver for sqlx that wraps the drivers for SQLite and PostgreSQL. The address of the database
//! selects the one that a connection uses.

use std::str::FromStr;
use std::time::Duration;

use futures::future::BoxFuture;
use futures::stream::{self, BoxStream};
use futures::{FutureExt, StreamExt, TryFutureExt, TryStreamExt};
use log::LevelFilter;
use sqlx::database::HasStatementCache;
use sqlx::migrate::{AppliedMigration, Migrate, MigrateError, Migration};
#[cfg(feature = "postgres")]
use sqlx::postgres::{PgConnectOptions, PgConnection, PgTransactionManager, Postgres};
use sqlx::sqlite::{Sqlite, SqliteConnectOptions, SqliteConnection, SqliteTransactionManager};
use sqlx::{Acquire, Database, Describe, Either, Execute, SqlStr, Transaction};
use sqlx_core::Url;
use sqlx_core::transaction::TransactionManager;

use super::answers::{AnswerColumn, AnswerRow, PreparedStatement, QueryResult};
use super::values::{AnswerValue, Argument, Arguments, TypeInfo, ValueRef};
use super::{EngineKind, native};
use crate::{Error, Result};

/// The database engine: SQLite, or PostgreSQL with the feature `postgres`.
#[derive(Debug)]
pub struct Engine;

impl Database for Engine {
    type Connection = Connection;
    type TransactionManager = Transactions;
    type Row = AnswerRow;
    type QueryResult = QueryResult;
    type Column = AnswerColumn;
    type TypeInfo = TypeInfo;
    type Value = AnswerValue;
    type ValueRef<'r> = ValueRef<'r>;
    type Arguments = Arguments;
    type ArgumentBuffer = Vec<Argument>;
    type Statement = PreparedStatement;

    const NAME: &'static str = "SQLite or PostgreSQL";
    const URL_SCHEMES: &'static [&'static str] = &["sqlite", "postgres", "postgresql"];
}

impl HasStatementCache for Engine {}

/// A database connection.
#[derive(Debug)]
pub enum Connection {
    /// A connection to a SQLite file.
    Sqlite(SqliteConnection),
    /// A connection to a PostgreSQL server.
    #[cfg(feature = "postgres")]
    Postgres(PgConnection),
}

impl Connection {
    /// Returns the engine.
    pub(crate) const fn kind(&self) -> EngineKind {
        match self {
            Self::Sqlite(_) => EngineKind::Sqlite,
            #[cfg(feature = "postgres")]
            Self::Postgres(_) => EngineKind::Postgres,
        }
    }
}

impl sqlx::Connection for Connection {
    type Database = Engine;
    type Options = ConnectOptions;

    async fn close(self) -> Result<()> {
        native!(Self, self, own => own.close().await)
    }

    async fn close_hard(self) -> Result<()> {
        native!(Self, self, own => own.close_hard().await)
    }

    async fn ping(&mut self) -> Result<()> {
        match self {
            // A file cannot disconnect, and a ping of SQLite's thread costs two context switches
            // each time a connection returns to its pool.
            Self::Sqlite(_) => Ok(()),
            #[cfg(feature = "postgres")]
            Self::Postgres(own) => own.ping().await,
        }
    }

    async fn begin(&mut self) -> Result<Transaction<'_, Engine>> {
        Transaction::begin(self, None).await
    }

    fn cached_statements_size(&self) -> usize {
        native!(Self, self, own => own.cached_statements_size())
    }

    async fn clear_cached_statements(&mut self) -> Result<()> {
        native!(Self, self, own => own.clear_cached_statements().await)
    }

    fn shrink_buffers(&mut self) {
        native!(Self, self, own => own.shrink_buffers());
    }

    async fn flush(&mut self) -> Result<()> {
        native!(Self, self, own => own.flush().await)
    }

    fn should_flush(&self) -> bool {
        native!(Self, self, own => own.should_flush())
    }
}

/// Connection options.
#[derive(Clone, Debug)]
pub enum ConnectOptions {
    /// For a SQLite file.
    Sqlite(Box<SqliteConnectOptions>),
    /// For a PostgreSQL server.
    #[cfg(feature = "postgres")]
    Postgres(Box<PgConnectOptions>),
}

impl ConnectOptions {
    /// Returns the engine.
    pub(crate) const fn kind(&self) -> EngineKind {
        match self {
            Self::Sqlite(_) => EngineKind::Sqlite,
            #[cfg(feature = "postgres")]
            Self::Postgres(_) => EngineKind::Postgres,
        }
    }
}

impl From<SqliteConnectOptions> for ConnectOptions {
    fn from(own: SqliteConnectOptions) -> Self {
        Self::Sqlite(Box::new(own))
    }
}

#[cfg(feature = "postgres")]
impl From<PgConnectOptions> for ConnectOptions {
    fn from(own: PgConnectOptions) -> Self {
        Self::Postgres(Box::new(own))
    }
}

impl FromStr for ConnectOptions {
    type Err = Error;

    fn from_str(url: &str) -> Result<Self> {
        match EngineKind::of(url) {
            Some(EngineKind::Sqlite) => SqliteConnectOptions::from_str(url).map(Self::from),
            #[cfg(feature = "postgres")]
            Some(EngineKind::Postgres) => PgConnectOptions::from_str(url).map(Self::from),
            None => Err(Error::Configuration(super::AddressRefused::ALLOWED.into())),
        }
    }
}

impl sqlx::ConnectOptions for ConnectOptions {
    type Connection = Connection;

    fn from_url(url: &Url) -> Result<Self> {
        Self::from_str(url.as_str())
    }

    fn to_url_lossy(&self) -> Url {
        native!(Self, self, own => own.to_url_lossy())
    }

    async fn connect(&self) -> Result<Connection> {
        Ok(match self {
            Self::Sqlite(own) => Connection::Sqlite(own.connect().await?),
            #[cfg(feature = "postgres")]
            Self::Postgres(own) => Connection::Postgres(own.connect().await?),
        })
    }

    fn log_statements(self, level: LevelFilter) -> Self {
        native!(Self, self, own => own.log_statements(level).into())
    }

    fn log_slow_statements(self, level: LevelFilter, duration: Duration) -> Self {
        native!(Self, self, own => own.log_slow_statements(level, duration).into())
    }
}

/// Begins and ends transactions.
#[derive(Debug)]
pub struct Transactions;

impl TransactionManager for Transactions {
    type Database = Engine;

    async fn begin(connection: &mut Connection, statement: Option<SqlStr>) -> Result<()> {
        match connection {
            Connection::Sqlite(own) => SqliteTransactionManager::begin(own, statement).await,
            #[cfg(feature = "postgres")]
            Connection::Postgres(own) => PgTransactionManager::begin(own, statement).await,
        }
    }

    async fn commit(connection: &mut Connection) -> Result<()> {
        match connection {
            Connection::Sqlite(own) => SqliteTransactionManager::commit(own).await,
            #[cfg(feature = "postgres")]
            Connection::Postgres(own) => PgTransactionManager::commit(own).await,
        }
    }

    async fn rollback(connection: &mut Connection) -> Result<()> {
        match connection {
            Connection::Sqlite(own) => SqliteTransactionManager::rollback(own).await,
            #[cfg(feature = "postgres")]
            Connection::Postgres(own) => PgTransactionManager::rollback(own).await,
        }
    }

    fn start_rollback(connection: &mut Connection) {
        match connection {
            Connection::Sqlite(own) => SqliteTransactionManager::start_rollback(own),
            #[cfg(feature = "postgres")]
            Connection::Postgres(own) => PgTransactionManager::start_rollback(own),
        }
    }

    fn get_transaction_depth(connection: &Connection) -> usize {
        match connection {
            Connection::Sqlite(own) => SqliteTransactionManager::get_transaction_depth(own),
            #[cfg(feature = "postgres")]
            Connection::Postgres(own) => PgTransactionManager::get_transaction_depth(own),
        }
    }
}

/// A statement for the native driver.
struct NativeQuery<E: Database> {
    sql: SqlStr,
    arguments: Option<E::Arguments>,
    is_persistent: bool,
}

impl<E: Database> Execute<'_, E> for NativeQuery<E> {
    fn sql(self) -> SqlStr {
        self.sql
    }

    fn statement(&self) -> Option<&E::Statement> {
        None
    }

    fn take_arguments(&mut self) -> std::result::Result<Option<E::Arguments>, sqlx::error::BoxDynError> {
        Ok(self.arguments.take())
    }

    fn persistent(&self) -> bool {
        self.is_persistent
    }
}

impl<E: Database> NativeQuery<E>
where
    Arguments: TryInto<E::Arguments, Error = sqlx::error::BoxDynError>,
{
    fn of<'q>(mut query: impl Execute<'q, Engine>) -> Result<Self> {
        let arguments = query.take_arguments().and_then(|given| given.map(Arguments::try_into).transpose());
        let (arguments, is_persistent) = (arguments.map_err(Error::Encode)?, query.persistent());
        Ok(Self { sql: query.sql(), arguments, is_persistent })
    }
}

impl<'c> sqlx::Executor<'c> for &'c mut Connection {
    type Database = Engine;

    fn fetch_many<'e, 'q: 'e, E>(self, query: E) -> BoxStream<'e, Result<Either<QueryResult, AnswerRow>>>
    where
        'c: 'e,
        E: 'q + Execute<'q, Engine>,
    {
        match self {
            Connection::Sqlite(own) => match NativeQuery::<Sqlite>::of(query) {
                Ok(query) => own
                    .fetch_many(query)
                    .map_ok(|step| step.map_either(|done| done.rows_affected().into(), AnswerRow::from))
                    .boxed(),
                Err(error) => stream::once(async { Err(error) }).boxed(),
            },
            #[cfg(feature = "postgres")]
            Connection::Postgres(own) => match NativeQuery::<Postgres>::of(query) {
                Ok(query) => own
                    .fetch_many(query)
                    .map_ok(|step| step.map_either(|done| done.rows_affected().into(), AnswerRow::from))
                    .boxed(),
                Err(error) => stream::once(async { Err(error) }).boxed(),
            },
        }
    }

    fn fetch_optional<'e, 'q: 'e, E>(self, query: E) -> BoxFuture<'e, Result<Option<AnswerRow>>>
    where
        'c: 'e,
        E: 'q + Execute<'q, Engine>,
    {
        match self {
            Connection::Sqlite(own) => match NativeQuery::<Sqlite>::of(query) {
                Ok(query) => own.fetch_optional(query).map_ok(|row| row.map(AnswerRow::from)).boxed(),
                Err(error) => async { Err(error) }.boxed(),
            },
            #[cfg(feature = "postgres")]
            Connection::Postgres(own) => match NativeQuery::<Postgres>::of(query) {
                Ok(query) => own.fetch_optional(query).map_ok(|row| row.map(AnswerRow::from)).boxed(),
                Err(error) => async { Err(error) }.boxed(),
            },
        }
    }

    fn prepare_with<'e>(self, sql: SqlStr, _parameters: &'e [TypeInfo]) -> BoxFuture<'e, Result<PreparedStatement>>
    where
        'c: 'e,
    {
        native!(Connection, self, own => own.prepare_with(sql, &[]).map_ok(PreparedStatement::of).boxed())
    }

    fn describe<'e>(self, sql: SqlStr) -> BoxFuture<'e, Result<Describe<Engine>>>
    where
        'c: 'e,
    {
        native!(Connection, self, own => own.describe(sql).map_ok(|found| Describe {
            columns: found.columns.iter().map(AnswerColumn::of).collect(),
            parameters: None,
            nullable: found.nullable,
        }).boxed())
    }
}

impl<'c> Acquire<'c> for &'c mut Connection {
    type Database = Engine;
    type Connection = Self;

    fn acquire(self) -> BoxFuture<'c, Result<Self>> {
        async { Ok(self) }.boxed()
    }

    fn begin(self) -> BoxFuture<'c, Result<Transaction<'c, Engine>>> {
        Transaction::begin(self, None)
    }
}

type Migrated<'e, T> = BoxFuture<'e, std::result::Result<T, MigrateError>>;

impl Migrate for Connection {
    fn create_schema_if_not_exists<'e>(&'e mut self, schema_name: &'e str) -> Migrated<'e, ()> {
        native!(Self, self, own => own.create_schema_if_not_exists(schema_name))
    }

    fn ensure_migrations_table<'e>(&'e mut self, table_name: &'e str) -> Migrated<'e, ()> {
        native!(Self, self, own => own.ensure_migrations_table(table_name))
    }

    fn dirty_version<'e>(&'e mut self, table_name: &'e str) -> Migrated<'e, Option<i64>> {
        native!(Self, self, own => own.dirty_version(table_name))
    }

    fn list_applied_migrations<'e>(&'e mut self, table_name: &'e str) -> Migrated<'e, Vec<AppliedMigration>> {
        native!(Self, self, own => own.list_applied_migrations(table_name))
    }

    fn lock(&mut self) -> Migrated<'_, ()> {
        native!(Self, self, own => own.lock())
    }

    fn unlock(&mut self) -> Migrated<'_, ()> {
        native!(Self, self, own => own.unlock())
    }

    fn apply<'e>(&'e mut self, table_name: &'e str, migration: &'e Migration) -> Migrated<'e, Duration> {
        native!(Self, self, own => own.apply(table_name, migration))
    }

    fn revert<'e>(&'e mut self, table_name: &'e str, migration: &'e Migration) -> Migrated<'e, Duration> {
        native!(Self, self, own => own.revert(table_name, migration))
    }
}
