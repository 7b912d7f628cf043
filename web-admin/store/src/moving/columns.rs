//! Tables and their columns as PostgreSQL's catalogue lists them: its kinds say what a value is, where SQLite keeps two by one kind.

use std::collections::BTreeMap;

use sqlx::FromRow;
use sqlx::postgres::PgConnection;

use crate::Result;

/// What the values of a column are.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum ValueKind {
    /// An id of 16 bytes: a UUID to one, a BLOB to the other.
    Id,
    /// Bytes.
    Bytes,
    /// A whole number.
    Whole,
    /// A number of floating point.
    Real,
    /// A truth value: 0 or 1 to SQLite.
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

/// A column whose values are carried.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct CarriedColumn {
    pub name: String,
    pub kind: ValueKind,
}

/// A table whose rows are carried.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct TablePlan {
    pub name: String,
    pub columns: Vec<CarriedColumn>,
    /// The columns that settle the order of its rows.
    pub order: Vec<String>,
    /// It counts rows as they arrive, as SQLite does by itself.
    pub counts_arrivals: bool,
}

impl TablePlan {
    /// The names of its columns, for a statement.
    pub fn column_list(&self) -> String {
        self.columns.iter().map(|column| format!("\"{}\"", column.name)).collect::<Vec<_>>().join(", ")
    }

    /// What its rows are read in the order of, for a statement: its key, or every column where it has none.
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

/// Every table but that of the migrations, with the columns that are not computed of others. A column that is none of ours is told
/// by its name.
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
        None => Err(format!("{name}.{}: {} is no kind of ours", column.column, column.kind)),
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
