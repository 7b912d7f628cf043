//! Insertion of many rows with one statement.

use sqlx::QueryBuilder;
use sqlx::query_builder::Separated;

use super::{Connection, Engine};
use crate::Result;

/// A table and the columns to be filled.
pub(crate) struct TableColumns {
    /// Name of the table.
    pub table: &'static str,
    /// Names of the columns.
    pub columns: &'static [&'static str],
}

/// Inserts rows and skips those whose key exists. `bind` binds the values of a row, in the order of
/// the columns. The engines accept about 30 000 values per statement.
pub(crate) async fn add_missing_rows<T>(
    writer: &mut Connection,
    into: &TableColumns,
    rows: &[T],
    bind: impl FnMut(Separated<'_, Engine, &'static str>, &T),
) -> Result<()> {
    if rows.is_empty() {
        return Ok(());
    }
    let TableColumns { table, columns } = into;
    let mut insert = QueryBuilder::<Engine>::new(format!("INSERT INTO {table} ({}) ", columns.join(", ")));
    insert.push_values(rows, bind).push(" ON CONFLICT DO NOTHING");
    insert.build().execute(writer).await.map(drop)
}
