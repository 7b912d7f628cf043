//! PostgreSQL's plans. No statement reads a table that grows from end to end for want of an index. It is told to read by indices wherever it
//! can, and that its tables are large. Which of several indices it takes is its own choice, by what it knows of a school: `web-admin bench`
//! shows what comes of that.

use std::collections::BTreeMap;

use serde_json::Value;
use sqlx::{AssertSqlSafe, Row};
use store::Connection;

use crate::operations::crowd::crowded;
use crate::operations::plans::{BIG, LISTED, WHOLE};
use crate::support::database::connect;
use crate::support::statements::{StoredStatement, TwinPlace, stored_statements};

/// The plan within the answer to `EXPLAIN`, which is JSON.
fn plan_in(explained: &str) -> Value {
    serde_json::from_str::<Value>(explained).unwrap()[0]["Plan"].clone()
}

/// The plan of a statement, whatever is asked of it.
async fn plan(connection: &mut Connection, sql: &str) -> Result<Value, String> {
    const KINDS: [&str; 3] = ["uuid", "text", "bigint"];
    let mut kinds: Vec<&str> = Vec::new();
    let mut prepare = format!("PREPARE asked AS {sql}");
    let mut tried = None;
    // An argument of which PostgreSQL cannot tell the kind is tried as each.
    while let Err(error) = sqlx::raw_sql(AssertSqlSafe(prepare.clone())).execute(&mut *connection).await {
        let told = error.to_string();
        let number = told
            .split_once("could not determine data type of parameter $")
            .and_then(|(_, number)| number.split(|c: char| !c.is_ascii_digit()).next()?.parse::<usize>().ok());
        let (number, kind) = match (number, tried) {
            (Some(number), _) => (number, 0),
            (None, Some((number, kind))) if kind + 1 < KINDS.len() => (number, kind + 1),
            _ => return Err(told),
        };
        tried = Some((number, kind));
        kinds.resize(kinds.len().max(number), "unknown");
        kinds[number - 1] = KINDS[kind];
        prepare = format!("PREPARE asked ({}) AS {sql}", kinds.join(", "));
    }
    let count: i32 =
        sqlx::query_scalar("SELECT cardinality(parameter_types) FROM pg_prepared_statements WHERE name = 'asked'")
            .fetch_one(&mut *connection)
            .await
            .unwrap();
    let nothing = vec!["NULL"; count.try_into().unwrap()].join(", ");
    let given = if nothing.is_empty() { nothing } else { format!("({nothing})") };
    let explained = sqlx::raw_sql(AssertSqlSafe(format!("EXPLAIN (FORMAT JSON) EXECUTE asked{given}")))
        .fetch_one(&mut *connection)
        .await
        .map_err(|error| error.to_string());
    sqlx::raw_sql("DEALLOCATE asked").execute(connection).await.unwrap();
    explained.map(|row| plan_in(&row.get_unchecked::<String, _>(0)))
}

/// Reads of a plan that go through a big table from end to end. What an index of few rows holds may be read whole.
fn whole_reads(plan: &Value, tables: &BTreeMap<String, String>) -> Vec<String> {
    let text = |name: &str| plan[name].as_str().unwrap_or_default();
    let table = match text("Node Type") {
        "Seq Scan" => Some(text("Relation Name")),
        _ if text("Index Cond").is_empty() => tables.get(text("Index Name")).map(String::as_str),
        _ => None,
    };
    let big = table.filter(|table| BIG.contains(table) || LISTED.contains(table));
    let inner = plan["Plans"].as_array().into_iter().flatten().flat_map(|inner| whole_reads(inner, tables));
    big.map(str::to_owned).into_iter().chain(inner).collect()
}

#[tokio::test]
async fn every_query_of_a_big_table_uses_an_index_on_postgresql() {
    only_on!(Postgres, "about a server");
    let app = crowded().await;
    let mut connection = connect(app.folder.path()).await;
    // Of these a crowd has none, and what an empty table is read by says nothing.
    let rows = "INSERT INTO supervisions (school_id, session_id, trainee_id, confirmed_by, confirmed_at)
                  SELECT school_id, id, trainee_id, trainee_id, 0 FROM sessions;
                INSERT INTO assignment_extensions (school_id, assignment_id, person_id, days, due_at)
                  SELECT p.school_id, (SELECT min(a.id::text)::uuid FROM assignments a), p.id, 1, 0 FROM people p";
    // As if each table that holds something had ten thousand times as many rows, and nothing were known of the others.
    let many = "UPDATE pg_class SET reltuples = CASE WHEN reltuples <= 0 THEN -1 ELSE reltuples * 10000 END
                WHERE relnamespace = 'public'::regnamespace AND relkind IN ('r', 'i')";
    for statement in [rows, "ANALYZE", many] {
        sqlx::raw_sql(statement).execute(&mut connection).await.unwrap();
    }
    for setting in [
        "plan_cache_mode = force_generic_plan",
        "enable_seqscan = off",
        "enable_bitmapscan = off",
        "enable_hashjoin = off",
        "enable_mergejoin = off",
    ] {
        sqlx::raw_sql(AssertSqlSafe(format!("SET {setting}"))).execute(&mut connection).await.unwrap();
    }
    // The table of each index that holds all of its rows.
    let tables: BTreeMap<String, String> = sqlx::query_as(
        "SELECT i.relname::text, t.relname::text
         FROM pg_index x JOIN pg_class i ON i.oid = x.indexrelid JOIN pg_class t ON t.oid = x.indrelid WHERE x.indpred IS NULL",
    )
    .fetch_all(&mut connection)
    .await
    .unwrap()
    .into_iter()
    .collect();
    let (mut planned, mut slow) = (0, Vec::new());
    for StoredStatement { sql, place } in stored_statements(TwinPlace::Second) {
        let plan =
            plan(&mut connection, &sql).await.unwrap_or_else(|told| panic!("{}: {told}: {sql}", place.display()));
        planned += 1;
        let added = sql.starts_with("INSERT INTO") && !sql.contains("SELECT");
        let allowed = added || WHOLE.iter().any(|(start, _)| sql.starts_with(start));
        slow.extend(
            whole_reads(&plan, &tables).into_iter().filter(|_| !allowed).map(|table| format!("{table} in: {sql}")),
        );
    }
    assert!(planned > 250, "only {planned} statements found");
    assert!(slow.is_empty(), "{} reads of a whole table:\n{}", slow.len(), slow.join("\n"));
}
