//! Tables and columns from PostgreSQL's catalogue. Its types determine the kinds of values, because
//! SQLite uses one type for several kinds.

use std::collections::BTreeMap;

use sqlx::FromRow;
use sqlx::postgres::PgConnection;

use crate::Result;

/// Kind of the values of a column.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum ValueKind {
    /// A 16-byte id: UUID in PostgreSQL, BLOB in SQLite.
    Id,
    /// Bytes.
    Bytes,
    /// A 64-bit integer.
    Whole,
    /// A 64-bit floating-point number.
    Real,
    /// A boolean: 0 or 1 in SQLite.
    Truth,
    /// A text.
    Text,
}

impl ValueKind {
    fn parse(name: &str) -> Option<Self> {
        Some(match name {
            "uuid" => Self::Id,
            "bytea" => Self::Bytes,
            "bigint" => Self::Whole,
            "double precision" => Self::Real,
            "boolean" => Self::Truth,
            "text" => Self::Text,
            _ => return None,
        })
    }
}

/// A column to be copied.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct CarriedColumn {
    pub name: String,
    pub kind: ValueKind,
}

/// A table to be copied.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct TablePlan {
    pub name: String,
    pub columns: Vec<CarriedColumn>,
    /// Columns that determine the order of the rows.
    pub order: Vec<String>,
    /// It has an identity column for the order of insertion, which SQLite provides implicitly.
    pub counts_arrivals: bool,
}

impl TablePlan {
    /// Returns the column names, for use in a statement.
    pub fn column_list(&self) -> String {
        self.columns.iter().map(|column| format!("\"{}\"", column.name)).collect::<Vec<_>>().join(", ")
    }

    /// Returns the sort order of the rows, for use in a statement: the primary key, or all columns
    /// without one.
    pub fn order_list(&self) -> String {
        self.order.iter().map(|name| format!("\"{name}\" NULLS FIRST")).collect::<Vec<_>>().join(", ")
    }
}

#[derive(FromRow)]
struct ListedColumn {
    table: String,
    column: String,
    kind: String,
    key_place: Option<i32>,
    is_identity: bool,
}

/// Returns all tables except the one of the migrations, with their columns except generated ones.
/// If a column has an unsupported type, the inner error names it.
pub(super) async fn list_tables(connection: &mut PgConnection) -> Result<std::result::Result<Vec<TablePlan>, String>> {
    let listed: Vec<ListedColumn> = sqlx::query_as(
        "SELECT c.relname::TEXT AS table, a.attname::TEXT AS column, format_type(a.atttypid, NULL) AS kind,
             array_position(i.indkey::INT2[], a.attnum) AS key_place, a.attidentity <> '' AS is_identity
         FROM pg_class c JOIN pg_attribute a ON a.attrelid = c.oid AND a.attnum > 0 AND NOT a.attisdropped AND a.attgenerated = ''
         LEFT JOIN pg_index i ON i.indrelid = c.oid AND i.indisprimary
         WHERE c.relnamespace = current_schema()::regnamespace AND c.relkind = 'r' AND c.relname <> '_sqlx_migrations'
         ORDER BY c.relname, a.attnum",
    )
    .fetch_all(connection)
    .await?;
    Ok(plan_tables(&listed))
}

fn plan_tables(listed: &[ListedColumn]) -> std::result::Result<Vec<TablePlan>, String> {
    let mut tables: BTreeMap<&str, Vec<&ListedColumn>> = BTreeMap::new();
    for column in listed {
        tables.entry(&column.table).or_default().push(column);
    }
    tables.into_iter().map(|(name, columns)| plan_table(name, &columns)).collect()
}

fn plan_table(name: &str, listed: &[&ListedColumn]) -> std::result::Result<TablePlan, String> {
    let carried = |column: &&ListedColumn| match ValueKind::parse(&column.kind) {
        Some(kind) => Ok(CarriedColumn { name: column.column.clone(), kind }),
        None => Err(format!("{name}.{}: {} is not a known type", column.column, column.kind)),
    };
    let columns = listed.iter().map(carried).collect::<std::result::Result<_, _>>()?;
    let mut key: Vec<_> = listed.iter().filter_map(|column| Some((column.key_place?, column.column.clone()))).collect();
    key.sort();
    let mut order: Vec<String> = key.into_iter().map(|(_, column)| column).collect();
    if order.is_empty() {
        order.extend(listed.iter().map(|column| column.column.clone()));
    }
    Ok(TablePlan {
        name: name.to_owned(),
        columns,
        order,
        counts_arrivals: listed.iter().any(|column| column.is_identity),
    })
}
