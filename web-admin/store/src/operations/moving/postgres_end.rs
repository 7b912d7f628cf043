//! The PostgreSQL side of a move.

use futures::TryStreamExt;
use sqlx::AssertSqlSafe;
use sqlx::postgres::{PgConnection, PgCopyIn};

use super::CarriedTable;
use super::columns::{TablePlan, ValueKind};
use super::tuples::{HEADER, RowReader, TRAILER, TableTally};
use crate::Result;

/// Size of the chunks sent to the server, in bytes.
const PIECE: usize = 1 << 16;

/// Executes a statement without parameters.
pub(super) async fn execute(connection: &mut PgConnection, statement: impl Into<String>) -> Result<u64> {
    Ok(sqlx::raw_sql(AssertSqlSafe(statement.into())).execute(connection).await?.rows_affected())
}

/// Returns the version of the newest applied migration; `None` if it is not a database of the
/// service.
pub(super) async fn newest_migration(connection: &mut PgConnection) -> Result<Option<i64>> {
    if !is_table_there(&mut *connection, "_sqlx_migrations").await? {
        return Ok(None);
    }
    sqlx::query_scalar("SELECT max(version) FROM _sqlx_migrations").fetch_one(connection).await
}

async fn is_table_there(connection: &mut PgConnection, name: &str) -> Result<bool> {
    sqlx::query_scalar("SELECT to_regclass($1) IS NOT NULL").bind(name).fetch_one(connection).await
}

/// Returns whether the database holds a school, or entries in the audit log.
pub(super) async fn holds_rows(connection: &mut PgConnection) -> Result<bool> {
    for table in ["schools", "audit_log"] {
        if is_table_there(&mut *connection, table).await? {
            let count = format!("SELECT count(*) > 0 FROM {table}");
            if sqlx::query_scalar(AssertSqlSafe(count)).fetch_one(&mut *connection).await? {
                return Ok(true);
            }
        }
    }
    Ok(false)
}

/// Passes every row of a table to `take`, in binary form and in an order common to both engines.
/// Adding zero turns −0.0 into 0.0, because SQLite does not store the sign of zero.
pub(super) async fn read_table(
    connection: &mut PgConnection,
    table: &TablePlan,
    mut take: impl AsyncFnMut(&[u8]) -> Result<()>,
) -> Result<CarriedTable> {
    let values = table.columns.iter().map(|column| match column.kind {
        ValueKind::Real => format!("\"{}\" + 0::DOUBLE PRECISION", column.name),
        _ => format!("\"{}\"", column.name),
    });
    let values = values.collect::<Vec<_>>().join(", ");
    let copy = format!(
        "COPY (SELECT {values} FROM \"{}\" ORDER BY {}) TO STDOUT (FORMAT binary)",
        table.name,
        table.order_list()
    );
    let (mut tally, mut reader) = (TableTally::new(table), RowReader::default());
    let mut pieces = connection.copy_out_raw(&copy).await?;
    while let Some(piece) = pieces.try_next().await? {
        reader.add(&piece);
        while let Some(row) = reader.next_row() {
            tally.count(row);
            take(row).await?;
        }
    }
    Ok(tally.finish())
}

/// Drops the foreign keys, disables the triggers and deletes rows inserted by migrations. Returns
/// the statements that restore the foreign keys; each then checks all rows at once.
pub(super) async fn make_room(connection: &mut PgConnection, tables: &[TablePlan]) -> Result<Vec<String>> {
    let references: Vec<ForeignKey> = sqlx::query_as(
        "SELECT conrelid::regclass::TEXT AS table, quote_ident(conname) AS name, pg_get_constraintdef(oid) AS definition
         FROM pg_constraint WHERE contype = 'f' AND connamespace = current_schema()::regnamespace ORDER BY conrelid, conname",
    )
    .fetch_all(&mut *connection)
    .await?;
    for ForeignKey { table, name, .. } in &references {
        execute(connection, format!("ALTER TABLE {table} DROP CONSTRAINT {name}")).await?;
    }
    set_triggers(connection, tables, "DISABLE").await?;
    let names = tables.iter().map(|table| format!("\"{}\"", table.name)).collect::<Vec<_>>().join(", ");
    execute(connection, format!("TRUNCATE {names}")).await?;
    let add = |ForeignKey { table, name, definition }: &ForeignKey| {
        format!("ALTER TABLE {table} ADD CONSTRAINT {name} {definition}")
    };
    Ok(references.iter().map(add).collect())
}

/// A foreign key.
#[derive(sqlx::FromRow)]
struct ForeignKey {
    table: String,
    name: String,
    definition: String,
}

/// Enables (`ENABLE`) or disables (`DISABLE`) the triggers of the tables.
async fn set_triggers(connection: &mut PgConnection, tables: &[TablePlan], does: &str) -> Result<()> {
    for table in tables {
        execute(connection, format!("ALTER TABLE \"{}\" {does} TRIGGER USER", table.name)).await?;
    }
    Ok(())
}

/// Restores foreign keys and triggers, sets the sequences to the number after the last row, and
/// updates the planner's statistics, so that the first queries are not slow until autovacuum has
/// run.
pub(super) async fn settle(connection: &mut PgConnection, tables: &[TablePlan], references: Vec<String>) -> Result<()> {
    for reference in references {
        execute(connection, reference).await?;
    }
    set_triggers(connection, tables, "ENABLE").await?;
    for table in tables.iter().filter(|table| table.counts_arrivals) {
        let count = format!(
            "SELECT setval(pg_get_serial_sequence('\"{0}\"', 'rowid'), coalesce(max(rowid), 0) + 1, FALSE) FROM \"{0}\"",
            table.name
        );
        execute(connection, count).await?;
    }
    execute(connection, "ANALYZE").await.map(drop)
}

/// Writes the rows of a table with `COPY`.
pub(super) struct TableSender<'a> {
    copy: PgCopyIn<&'a mut PgConnection>,
    waiting: Vec<u8>,
}

impl<'a> TableSender<'a> {
    pub async fn begin(connection: &'a mut PgConnection, table: &TablePlan) -> Result<Self> {
        let copy = format!("COPY \"{}\" ({}) FROM STDIN (FORMAT binary)", table.name, table.column_list());
        Ok(Self { copy: connection.copy_in_raw(&copy).await?, waiting: HEADER.to_vec() })
    }

    /// Adds a row in binary form.
    pub async fn write(&mut self, row: &[u8]) -> Result<()> {
        self.waiting.extend(row);
        if self.waiting.len() >= PIECE {
            self.copy.send(&*self.waiting).await?;
            self.waiting.clear();
        }
        Ok(())
    }

    pub async fn finish(mut self) -> Result<()> {
        self.waiting.extend(TRAILER);
        self.copy.send(&*self.waiting).await?;
        self.copy.finish().await.map(drop)
    }
}
