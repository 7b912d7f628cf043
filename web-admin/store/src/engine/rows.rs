//! Many rows in one statement.

use sqlx::QueryBuilder;
use sqlx::query_builder::Separated;

use super::{Connection, Engine};
use crate::Result;

/// A table, and those of its columns that are given values.
pub(crate) struct TableColumns {
    /// Its name.
    pub table: &'static str,
    /// Their names.
    pub columns: &'static [&'static str],
}

/// Adds rows to a table, and leaves out those whose key it has. `bind` gives a row's values, in the order of the columns. Engines take some
/// thirty thousand values at a time.
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
