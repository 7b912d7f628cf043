//! Result rows, columns and prepared statements of either engine.

use std::sync::OnceLock;

#[cfg(feature = "postgres")]
use sqlx::postgres::PgRow;
use sqlx::sqlite::SqliteRow;
use sqlx::{ColumnIndex, Either, SqlStr};

use super::driver::Engine;
use super::native;
use super::values::{Arguments, TypeInfo, ValueRef};
use crate::Result;

/// A result row.
#[derive(Debug)]
pub struct AnswerRow {
    own: NativeRow,
    /// Filled on demand: most rows are only read by column name or index.
    columns: OnceLock<Vec<AnswerColumn>>,
}

#[derive(Debug)]
enum NativeRow {
    Sqlite(SqliteRow),
    #[cfg(feature = "postgres")]
    Postgres(PgRow),
}

impl From<SqliteRow> for AnswerRow {
    fn from(own: SqliteRow) -> Self {
        Self { own: NativeRow::Sqlite(own), columns: OnceLock::new() }
    }
}

#[cfg(feature = "postgres")]
impl From<PgRow> for AnswerRow {
    fn from(own: PgRow) -> Self {
        Self { own: NativeRow::Postgres(own), columns: OnceLock::new() }
    }
}

impl sqlx::Row for AnswerRow {
    type Database = Engine;

    fn len(&self) -> usize {
        native!(NativeRow, &self.own, own => own.len())
    }

    fn columns(&self) -> &[AnswerColumn] {
        let made = || native!(NativeRow, &self.own, own => own.columns().iter().map(AnswerColumn::of).collect());
        self.columns.get_or_init(made)
    }

    fn try_get_raw<I: ColumnIndex<Self>>(&self, index: I) -> Result<ValueRef<'_>> {
        let index = index.index(self)?;
        native!(NativeRow, &self.own, own => own.try_get_raw(index).map(ValueRef::from))
    }
}

impl ColumnIndex<AnswerRow> for usize {
    fn index(&self, row: &AnswerRow) -> Result<usize> {
        native!(NativeRow, &row.own, own => self.index(own))
    }
}

impl ColumnIndex<AnswerRow> for &str {
    fn index(&self, row: &AnswerRow) -> Result<usize> {
        native!(NativeRow, &row.own, own => self.index(own))
    }
}

/// A column of a result.
#[derive(Clone, Debug)]
pub struct AnswerColumn {
    ordinal: usize,
    name: String,
    kind: TypeInfo,
}

impl AnswerColumn {
    /// Wraps a native column.
    pub(super) fn of<C: sqlx::Column>(own: &C) -> Self
    where
        TypeInfo: From<<C::Database as sqlx::Database>::TypeInfo>,
    {
        Self { ordinal: own.ordinal(), name: own.name().to_owned(), kind: own.type_info().clone().into() }
    }
}

impl sqlx::Column for AnswerColumn {
    type Database = Engine;

    fn ordinal(&self) -> usize {
        self.ordinal
    }

    fn name(&self) -> &str {
        &self.name
    }

    fn type_info(&self) -> &TypeInfo {
        &self.kind
    }
}

/// Outcome of a statement.
#[derive(Debug, Default)]
pub struct QueryResult {
    rows: u64,
}

impl QueryResult {
    /// Number of rows written.
    #[must_use]
    pub const fn rows_affected(&self) -> u64 {
        self.rows
    }
}

impl From<u64> for QueryResult {
    fn from(rows: u64) -> Self {
        Self { rows }
    }
}

impl Extend<Self> for QueryResult {
    fn extend<T: IntoIterator<Item = Self>>(&mut self, done: T) {
        self.rows += done.into_iter().map(|done| done.rows).sum::<u64>();
    }
}

/// A prepared statement.
#[derive(Clone, Debug)]
pub struct PreparedStatement {
    sql: SqlStr,
    parameters: usize,
    columns: Vec<AnswerColumn>,
}

impl PreparedStatement {
    /// Wraps a native statement.
    pub(super) fn of<S: sqlx::Statement>(own: S) -> Self
    where
        TypeInfo: From<<S::Database as sqlx::Database>::TypeInfo>,
    {
        let parameters = match own.parameters() {
            Some(Either::Left(kinds)) => kinds.len(),
            Some(Either::Right(count)) => count,
            None => 0,
        };
        let columns = own.columns().iter().map(AnswerColumn::of).collect();
        Self { sql: own.into_sql(), parameters, columns }
    }
}

impl sqlx::Statement for PreparedStatement {
    type Database = Engine;

    sqlx_core::impl_statement_query!(Arguments);

    fn into_sql(self) -> SqlStr {
        self.sql
    }

    fn sql(&self) -> &SqlStr {
        &self.sql
    }

    fn parameters(&self) -> Option<Either<&[TypeInfo], usize>> {
        Some(Either::Right(self.parameters))
    }

    fn columns(&self) -> &[AnswerColumn] {
        &self.columns
    }
}
