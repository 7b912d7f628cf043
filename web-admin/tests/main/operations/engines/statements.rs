//! What SQLite is asked in `plans`, PostgreSQL is asked here: whether each statement of the storage is one, and what it answers with.

use sqlx::postgres::PgConnection;
use sqlx::{AssertSqlSafe, Column, Executor, SqlSafeStr, Statement, TypeInfo};

use super::BothEngines;
use crate::support::statements::{StoredStatement, TwinPlace, stored_statements};

/// Kinds of columns that the storage reads.
const KINDS: [&str; 6] = ["UUID", "BYTEA", "INT8", "FLOAT8", "BOOL", "TEXT"];

/// What PostgreSQL says of an argument of which nothing is asked but whether it is there: the storage tells its kind, this test does not.
const UNKNOWN: &str = "could not determine data type of parameter $";

/// The kinds of what a statement answers with. An argument of unknown kind is tried as each.
async fn kinds(postgres: &mut PgConnection, statement: &str) -> Result<Vec<String>, String> {
    let sql = AssertSqlSafe(statement.to_owned()).into_sql_str();
    let told = match postgres.prepare(sql).await {
        Ok(prepared) => {
            return Ok(prepared.columns().iter().map(|column| column.type_info().name().to_owned()).collect());
        }
        Err(error) => error.to_string(),
    };
    let Some((_, number)) = told.split_once(UNKNOWN) else { return Err(told) };
    let number = number.split(|c: char| !c.is_ascii_digit()).next().unwrap_or_default();
    let bare = format!("${number} IS NULL");
    if !statement.contains(&bare) {
        // A parameter that stands nowhere.
        return Ok(Vec::new());
    }
    for kind in ["UUID", "TEXT", "BIGINT"] {
        let known = statement.replace(&bare, &format!("CAST(${number} AS {kind}) IS NULL"));
        if let Ok(kinds) = Box::pin(kinds(postgres, &known)).await {
            return Ok(kinds);
        }
    }
    Err(told)
}

#[tokio::test]
async fn postgresql_prepares_every_statement_with_readable_types() {
    let Some(mut both) = BothEngines::start().await else { return };
    let (mut prepared, mut refused) = (0, Vec::new());
    for StoredStatement { sql, place } in stored_statements(TwinPlace::Second) {
        prepared += 1;
        match kinds(&mut both.postgres, &sql).await {
            // Nobody reads what it answers.
            Ok(_) if sql == "SELECT 1" => {}
            Ok(kinds) if kinds.iter().all(|kind| KINDS.contains(&kind.as_str())) => {}
            Ok(kinds) => refused.push(format!("{}: {kinds:?}: {sql}", place.display())),
            Err(error) => refused.push(format!("{}: {error}: {sql}", place.display())),
        }
    }
    assert!(prepared > 250, "only {prepared} statements found");
    assert!(refused.is_empty(), "{} statements are none to PostgreSQL:\n{}", refused.len(), refused.join("\n"));
}
