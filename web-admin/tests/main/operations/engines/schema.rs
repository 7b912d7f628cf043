//! Tables, columns, keys, indices, triggers and checks of both schemas, as each engine's own catalogue lists them.

use std::collections::BTreeSet;

use super::BothEngines;

/// Table, column, kind, whether it must be there, and what it is by itself. What SQLite keeps as 0 or 1 is a truth value.
const SQLITE_COLUMNS: &str = "
    SELECT t.name || '.' || c.name || ' '
        || CASE WHEN t.type = 'view' THEN ''
                WHEN instr(t.sql, 'CHECK (' || c.name || ' IN (0, 1))') > 0 THEN 'TRUTH' ELSE c.type END
        || CASE WHEN t.type = 'table' AND (c.\"notnull\" OR c.pk) THEN ' NOT NULL' ELSE '' END
        || CASE WHEN c.dflt_value IS NULL THEN '' ELSE ' ' || c.dflt_value END
    FROM sqlite_schema t JOIN pragma_table_xinfo(t.name) c
    WHERE t.type IN ('table', 'view') AND t.name <> '_sqlx_migrations'";
const POSTGRES_COLUMNS: &str = "
    SELECT c.relname || '.' || a.attname || ' '
        || CASE WHEN c.relkind = 'v' THEN '' ELSE CASE format_type(a.atttypid, NULL) WHEN 'uuid' THEN 'BLOB'
             WHEN 'bytea' THEN 'BLOB' WHEN 'bigint' THEN 'INTEGER' WHEN 'boolean' THEN 'TRUTH' WHEN 'text' THEN 'TEXT'
             WHEN 'double precision' THEN 'REAL' ELSE 'unknown' END END
        || CASE WHEN a.attnotnull THEN ' NOT NULL' ELSE '' END
        || CASE WHEN d.oid IS NULL OR a.attgenerated <> '' THEN ''
             ELSE ' ' || replace(replace(replace(pg_get_expr(d.adbin, d.adrelid), '::text', ''), 'true', '1'), 'false', '0') END
    FROM pg_class c JOIN pg_attribute a ON a.attrelid = c.oid AND a.attnum > 0 AND NOT a.attisdropped
    LEFT JOIN pg_attrdef d ON d.adrelid = c.oid AND d.adnum = a.attnum
    WHERE c.relnamespace = 'public'::regnamespace AND c.relkind IN ('r', 'v') AND c.relname NOT LIKE 'pragma_%'
        AND c.relname <> '_sqlx_migrations' AND a.attidentity = ''";

/// What each column of another table points to, and what becomes of the row where that goes.
const SQLITE_REFERENCES: &str = "
    SELECT t.name || ': ' || group_concat(f.\"from\", ', ' ORDER BY f.seq) || ' -> ' || f.\"table\" || ': '
        || group_concat(f.\"to\", ', ' ORDER BY f.seq) || ' ' || f.on_delete
    FROM sqlite_schema t JOIN pragma_foreign_key_list(t.name) f WHERE t.type = 'table' GROUP BY t.name, f.id";
const POSTGRES_REFERENCES: &str = "
    SELECT k.conrelid::regclass || ': '
        || (SELECT string_agg(a.attname, ', ' ORDER BY n.place) FROM unnest(k.conkey) WITH ORDINALITY n (number, place)
            JOIN pg_attribute a ON a.attrelid = k.conrelid AND a.attnum = n.number) || ' -> ' || k.confrelid::regclass || ': '
        || (SELECT string_agg(a.attname, ', ' ORDER BY n.place) FROM unnest(k.confkey) WITH ORDINALITY n (number, place)
            JOIN pg_attribute a ON a.attrelid = k.confrelid AND a.attnum = n.number) || ' '
        || CASE k.confdeltype WHEN 'a' THEN 'NO ACTION' WHEN 'c' THEN 'CASCADE' WHEN 'n' THEN 'SET NULL' ELSE 'other' END
    FROM pg_constraint k WHERE k.contype = 'f'";

/// Keys and indices: what they are for, their columns in order, and whether they hold some rows alone. What SQLite indexes as an id or
/// none, PostgreSQL indexes as an id of which two absent ones are the same. A primary key of one INTEGER has no index in SQLite.
const SQLITE_INDICES: &str = "
    SELECT t.name || ' (' || (SELECT group_concat(coalesce(c.name, 'session_id'), ', ' ORDER BY c.seqno)
            FROM pragma_index_info(i.name) c) || ')'
        || CASE WHEN i.origin = 'c' THEN ' ' || i.name ELSE '' END
        || CASE WHEN i.\"unique\" THEN ' unique' ELSE '' END || CASE WHEN i.partial THEN ' partial' ELSE '' END
    FROM sqlite_schema t JOIN pragma_index_list(t.name) i WHERE t.type = 'table' AND t.name <> '_sqlx_migrations'";
const POSTGRES_INDICES: &str = "
    SELECT i.indrelid::regclass || ' (' || (SELECT string_agg(a.attname, ', ' ORDER BY n.place)
            FROM unnest(i.indkey::int2[]) WITH ORDINALITY n (number, place)
            JOIN pg_attribute a ON a.attrelid = i.indrelid AND a.attnum = n.number) || ')'
        || CASE WHEN k.oid IS NULL THEN ' ' || c.relname ELSE '' END
        || CASE WHEN i.indisunique THEN ' unique' ELSE '' END || CASE WHEN i.indpred IS NOT NULL THEN ' partial' ELSE '' END
    FROM pg_index i JOIN pg_class c ON c.oid = i.indexrelid LEFT JOIN pg_constraint k ON k.conindid = i.indexrelid
        AND k.contype IN ('p', 'u')
    WHERE c.relnamespace = 'public'::regnamespace AND i.indrelid <> '_sqlx_migrations'::regclass
        AND NOT (i.indisprimary AND i.indnatts = 1 AND EXISTS (SELECT 1 FROM pg_attribute a
            WHERE a.attrelid = i.indrelid AND a.attnum = i.indkey[0] AND a.atttypid = 'bigint'::regtype))";

/// Triggers, when each runs and of what.
const SQLITE_TRIGGERS: &str = "SELECT tbl_name || ' ' || name FROM sqlite_schema WHERE type = 'trigger'";
const POSTGRES_TRIGGERS: &str = "SELECT tgrelid::regclass || ' ' || tgname FROM pg_trigger
    WHERE NOT tgisinternal AND tgname NOT LIKE '%_all_at_once'";

/// How many rules a table's values keep, besides those that its kinds of columns keep in PostgreSQL.
const SQLITE_CHECKS: &str = "
    WITH bare AS (SELECT name, replace(replace(sql, ' IN (0, 1))', '@'), ' = 16)', '@') AS sql FROM sqlite_schema
        WHERE type = 'table' AND name <> '_sqlx_migrations')
    SELECT name || ' ' || ((length(sql) - length(replace(sql, 'CHECK (', ''))) / 7 - (length(sql) - length(replace(sql, '@', ''))))
    FROM bare";
const POSTGRES_CHECKS: &str = "
    SELECT c.relname || ' ' || (SELECT count(*) FROM pg_constraint k WHERE k.conrelid = c.oid AND k.contype = 'c')
    FROM pg_class c WHERE c.relnamespace = 'public'::regnamespace AND c.relkind = 'r' AND c.relname <> '_sqlx_migrations'";

/// Lines that tell of each schema, by a query for each engine.
async fn compare(both: &mut BothEngines, sqlite: &'static str, postgres: &'static str) {
    let sqlite: Vec<String> = sqlx::query_scalar(sqlite).fetch_all(&mut both.sqlite).await.unwrap();
    let postgres: Vec<String> = sqlx::query_scalar(postgres).fetch_all(&mut both.postgres).await.unwrap();
    let (sqlite, postgres): (BTreeSet<_>, BTreeSet<_>) = (sqlite.into_iter().collect(), postgres.into_iter().collect());
    let only_sqlite: Vec<_> = sqlite.difference(&postgres).collect();
    let only_postgres: Vec<_> = postgres.difference(&sqlite).collect();
    assert!(
        !sqlite.is_empty() && only_sqlite.is_empty() && only_postgres.is_empty(),
        "{only_sqlite:#?} {only_postgres:#?}"
    );
}

#[tokio::test]
async fn both_engines_have_the_same_schema() {
    let Some(mut both) = BothEngines::start().await else { return };
    compare(&mut both, SQLITE_COLUMNS, POSTGRES_COLUMNS).await;
    compare(&mut both, SQLITE_REFERENCES, POSTGRES_REFERENCES).await;
    compare(&mut both, SQLITE_INDICES, POSTGRES_INDICES).await;
    compare(&mut both, SQLITE_TRIGGERS, POSTGRES_TRIGGERS).await;
    compare(&mut both, SQLITE_CHECKS, POSTGRES_CHECKS).await;
}
