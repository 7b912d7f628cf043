//! The SQLite side of a move.

use std::path::{Path, PathBuf};
use std::str::FromStr;
use std::time::Duration;

use futures::TryStreamExt;
use sqlx::query::Query;
use sqlx::sqlite::{SqliteArguments, SqliteConnectOptions, SqliteSynchronous};
use sqlx::{AssertSqlSafe, ConnectOptions, Sqlite, SqliteConnection};

use super::CarriedTable;
use super::columns::{TablePlan, ValueKind};
use super::tuples::{FieldReader, TableTally, append_row};
use crate::{Error, Result};

/// Number of rows that SQLite's thread may read ahead of the consumer.
const ROWS: usize = 1024;
/// Maximum number of values per statement: SQLite's own limit.
const MOST_VALUES: usize = 32_766;
/// Maximum number of rows per statement.
const MOST_ROWS: usize = 200;
/// Approximate maximum size of the values of a statement, in bytes.
const MOST_BYTES: usize = 1 << 20;

/// Returns the file of an address, which is a `sqlite:` URL or a path.
pub(super) fn parse_file(given: &str) -> Result<PathBuf> {
    if given.starts_with("sqlite:") {
        return Ok(SqliteConnectOptions::from_str(given)?.get_filename().to_owned());
    }
    Ok(PathBuf::from(given))
}

/// Opens a file. `make` creates a missing file.
pub(super) async fn open_file(file: &Path, make: bool) -> Result<SqliteConnection> {
    let options = SqliteConnectOptions::new()
        .filename(file)
        .create_if_missing(make)
        // Foreign keys are checked once, at the end.
        .foreign_keys(false)
        .synchronous(SqliteSynchronous::Full)
        .pragma("cache_size", "-64000")
        .row_buffer_size(ROWS)
        .busy_timeout(Duration::from_secs(10));
    options.connect().await
}

/// Returns the version of the newest applied migration; `None` if it is not a database of the
/// service.
pub(super) async fn newest_migration(connection: &mut SqliteConnection) -> Result<Option<i64>> {
    if !is_table_there(connection, "_sqlx_migrations").await? {
        return Ok(None);
    }
    sqlx::query_scalar("SELECT max(version) FROM _sqlx_migrations").fetch_one(connection).await
}

/// Returns whether the database holds a school, or entries in the audit log.
pub(super) async fn holds_rows(connection: &mut SqliteConnection) -> Result<bool> {
    for table in ["schools", "audit_log"] {
        if is_table_there(connection, table).await? {
            let count = format!("SELECT count(*) > 0 FROM {table}");
            if sqlx::query_scalar(AssertSqlSafe(count)).fetch_one(&mut *connection).await? {
                return Ok(true);
            }
        }
    }
    Ok(false)
}

async fn is_table_there(connection: &mut SqliteConnection, name: &str) -> Result<bool> {
    sqlx::query_scalar("SELECT count(*) > 0 FROM sqlite_schema WHERE type = 'table' AND name = $1")
        .bind(name)
        .fetch_one(connection)
        .await
}

/// Returns all columns as `table.column`, except generated ones.
pub(super) async fn list_columns(connection: &mut SqliteConnection) -> Result<Vec<String>> {
    sqlx::query_scalar(
        "SELECT t.name || '.' || c.name FROM sqlite_schema t JOIN pragma_table_xinfo(t.name) c
         WHERE t.type = 'table' AND t.name <> '_sqlx_migrations' AND t.name NOT LIKE 'sqlite_%' AND c.hidden = 0",
    )
    .fetch_all(connection)
    .await
}

/// Passes every row of a table to `take`, in binary form and in an order common to both engines.
pub(super) async fn read_table(
    connection: &mut SqliteConnection,
    table: &TablePlan,
    mut take: impl AsyncFnMut(&[u8]) -> Result<()>,
) -> Result<CarriedTable> {
    let (mut tally, mut row) = (TableTally::new(table), Vec::new());
    let select = format!("SELECT {} FROM \"{}\" ORDER BY {}", table.column_list(), table.name, table.order_list());
    let mut rows = sqlx::query(AssertSqlSafe(select)).fetch(connection);
    while let Some(found) = rows.try_next().await? {
        row.clear();
        append_row(&found, table, &mut row)?;
        tally.count(&row);
        take(&row).await?;
    }
    Ok(tally.finish())
}

/// Drops the triggers, whose effects are copied as rows, and deletes rows inserted by migrations.
/// Returns the statements that restore the triggers.
pub(super) async fn make_room(connection: &mut SqliteConnection, tables: &[TablePlan]) -> Result<Vec<String>> {
    let triggers: Vec<String> =
        sqlx::query_scalar("SELECT name FROM sqlite_schema WHERE type = 'trigger' ORDER BY name")
            .fetch_all(&mut *connection)
            .await?;
    let made = sqlx::query_scalar("SELECT sql FROM sqlite_schema WHERE type = 'trigger' ORDER BY name")
        .fetch_all(&mut *connection)
        .await?;
    for trigger in triggers {
        execute(connection, format!("DROP TRIGGER \"{trigger}\"")).await?;
    }
    for table in tables {
        execute(connection, format!("DELETE FROM \"{}\"", table.name)).await?;
    }
    Ok(made)
}

/// Restores the triggers and checks the database. Returns dangling references and damaged pages.
pub(super) async fn settle(connection: &mut SqliteConnection, triggers: Vec<String>) -> Result<Vec<String>> {
    for trigger in triggers {
        execute(connection, trigger).await?;
    }
    let mut findings: Vec<String> =
        sqlx::query_scalar("SELECT integrity_check FROM pragma_integrity_check").fetch_all(&mut *connection).await?;
    findings.retain(|line| line != "ok");
    let dangling: Vec<String> =
        sqlx::query_scalar("SELECT \"table\" || ': a row points to none in ' || parent FROM pragma_foreign_key_check")
            .fetch_all(connection)
            .await?;
    Ok([findings, dangling].concat())
}

/// Executes a statement without parameters.
pub(super) async fn execute(connection: &mut SqliteConnection, statement: impl Into<String>) -> Result<u64> {
    Ok(sqlx::raw_sql(AssertSqlSafe(statement.into())).execute(connection).await?.rows_affected())
}

/// Writes the rows of a table, many per statement.
pub(super) struct TableWriter<'a> {
    connection: &'a mut SqliteConnection,
    table: &'a TablePlan,
    waiting: Vec<Vec<u8>>,
    bytes: usize,
}

impl<'a> TableWriter<'a> {
    pub fn new(connection: &'a mut SqliteConnection, table: &'a TablePlan) -> Self {
        Self { connection, table, waiting: Vec::new(), bytes: 0 }
    }

    /// Adds a row in binary form.
    pub async fn write(&mut self, row: &[u8]) -> Result<()> {
        self.bytes += row.len();
        self.waiting.push(row.to_owned());
        let most = MOST_ROWS.min(MOST_VALUES / self.table.columns.len());
        if self.waiting.len() >= most || self.bytes >= MOST_BYTES { self.flush().await } else { Ok(()) }
    }

    /// Writes the buffered rows.
    pub async fn flush(&mut self) -> Result<()> {
        if self.waiting.is_empty() {
            return Ok(());
        }
        let one = format!("({})", vec!["?"; self.table.columns.len()].join(", "));
        let values = vec![one.as_str(); self.waiting.len()].join(", ");
        let insert = format!("INSERT INTO \"{}\" ({}) VALUES {values}", self.table.name, self.table.column_list());
        let mut query = sqlx::query(AssertSqlSafe(insert));
        for row in &self.waiting {
            query = bind_row(query, row, self.table)?;
        }
        query.execute(&mut *self.connection).await?;
        self.waiting.clear();
        self.bytes = 0;
        Ok(())
    }
}

type Insert<'q> = Query<'q, Sqlite, SqliteArguments>;

fn bind_row<'q>(mut query: Insert<'q>, row: &[u8], table: &TablePlan) -> Result<Insert<'q>> {
    let broken = || Error::Protocol(format!("{}: PostgreSQL sent no row of this table", table.name));
    let mut fields = FieldReader::new(row).ok_or_else(broken)?;
    for column in &table.columns {
        query = bind_value(query, column.kind, fields.next_field().ok_or_else(broken)?).ok_or_else(broken)?;
    }
    Ok(query)
}

/// Binds a value. Returns `None` if it does not have the expected kind.
fn bind_value<'q>(query: Insert<'q>, kind: ValueKind, value: Option<&[u8]>) -> Option<Insert<'q>> {
    let Some(value) = value else { return Some(query.bind(None::<i64>)) };
    Some(match kind {
        ValueKind::Id | ValueKind::Bytes => query.bind(value.to_owned()),
        ValueKind::Whole => query.bind(i64::from_be_bytes(value.try_into().ok()?)),
        ValueKind::Real => query.bind(f64::from_be_bytes(value.try_into().ok()?)),
        ValueKind::Truth => query.bind(i64::from(*value.first()?)),
        ValueKind::Text => query.bind(std::str::from_utf8(value).ok()?.to_owned()),
    })
}
