//! No query reads a table of many rows from end to end. The statements are taken from the storage's own source, every
//! string literal in a call of sqlx, and SQLite is asked how it would run each. Fails when a query loses its index, when
//! a new one never had any, and when a statement can no longer be planned. Statements that are put together by a macro
//! other than `listed!`, or chosen beforehand, are not seen.

use std::path::{Path, PathBuf};

use super::support::App;

/// Tables that grow with attempts, people or acts. Unfinished uploads do not: they expire.
const BIG: [&str; 8] =
    ["sessions", "scores", "metrics", "session_curves", "practice", "people", "cohort_members", "audit_log"];

/// What may read everything: beginnings of statements, each with the reason.
const WHOLE: [(&str, &str); 9] = [
    ("WITH RECURSIVE", "the generator of invented practice"),
    ("INSERT INTO tallies", "sums a school up anew, after the generator"),
    ("SELECT (SELECT count(*) FROM people WHERE role", "/metrics and the service's page: short rows, rarely asked"),
    ("SELECT id, recording_path, recording_sha256", "verify and backup read every recording"),
    ("SELECT seq, at, school_id, actor", "verify and serve walk the whole audit log"),
    ("SELECT count(*) FROM sessions WHERE state", "/metrics, for a scraper, not for a page"),
    ("SELECT count(*) FROM people", "greets an empty service, once at its start"),
    ("DELETE FROM uploads WHERE session_id IS NULL", "in the copy that a backup is made of"),
    ("SELECT seq, hash FROM audit_log ORDER BY seq DESC", "reads one row from the end of the primary key"),
];

fn sources(folder: &Path) -> Vec<PathBuf> {
    let mut found = Vec::new();
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            found.extend(sources(&path));
        } else if path.extension().is_some_and(|e| e == "rs") {
            found.push(path);
        }
    }
    found
}

/// The string literal that begins here, if one does, and what follows it.
fn literal(source: &str) -> Option<(String, &str)> {
    let source = source.trim_start();
    if let Some(raw) = source.strip_prefix("r#\"") {
        return raw.split_once("\"#").map(|(sql, rest)| (sql.to_owned(), rest));
    }
    let body = source.strip_prefix('"')?;
    let end = body.match_indices('"').map(|(at, _)| at).find(|&at| !body[..at].ends_with('\\'))?;
    Some((body[..end].replace("\\\"", "\""), &body[end + 1..]))
}

/// The statement in a call's arguments: a literal, or one that a macro of this file puts between two others.
fn statement(arguments: &str, frame: Option<&(String, String)>) -> Option<String> {
    let arguments = arguments.trim_start();
    if let Some(inner) = arguments.strip_prefix("listed!(") {
        let (before, after) = frame?;
        return literal(inner).map(|(middle, _)| format!("{before}{middle}{after}"));
    }
    literal(arguments).map(|(sql, _)| sql)
}

/// What a file's macro `listed!` puts before and after its argument.
fn frame(source: &str) -> Option<(String, String)> {
    let (_, body) = source.split_once("concat!(")?;
    let (before, rest) = literal(body)?;
    let (_, rest) = rest.split_once("$rest,")?;
    literal(rest).map(|(after, _)| (before, after))
}

/// Every statement of a file that stands in the call itself.
fn statements(source: &str) -> Vec<String> {
    let frame = frame(source);
    let mut found = Vec::new();
    for after in source.split("sqlx::query").skip(1) {
        // `query(`, `query_as(`, `query_scalar(`, or one with its types.
        let Some((name, arguments)) = after.split_once('(') else { continue };
        if name.chars().all(|c| c.is_ascii_alphanumeric() || "_:<>, ".contains(c)) {
            found.extend(statement(arguments, frame.as_ref()));
        }
    }
    found
}

/// Lines of a plan that read a big table from end to end, also under another name.
fn scans(sql: &str, plan: &[String]) -> Vec<String> {
    let words: Vec<&str> =
        sql.split(|c: char| !(c.is_ascii_alphanumeric() || c == '_')).filter(|w| !w.is_empty()).collect();
    let is_big = |name: &str| BIG.contains(&name) || words.windows(2).any(|w| w[1] == name && BIG.contains(&w[0]));
    let scanned =
        |line: &&String| line.strip_prefix("SCAN ").and_then(|rest| rest.split_whitespace().next()).is_some_and(is_big);
    plan.iter().filter(scanned).cloned().collect()
}

#[tokio::test]
async fn every_query_of_a_big_table_uses_an_index() {
    let app = App::new().await;
    let (mut planned, mut slow) = (0, Vec::new());
    for path in sources(&Path::new(env!("CARGO_MANIFEST_DIR")).join("src/storage")) {
        let source = std::fs::read_to_string(&path).unwrap();
        for sql in statements(&source).iter().filter(|sql| !sql.starts_with("PRAGMA") && !sql.starts_with("VACUUM")) {
            let plan: Vec<(i64, i64, i64, String)> =
                sqlx::query_as(sqlx::AssertSqlSafe(format!("EXPLAIN QUERY PLAN {sql}")))
                    .fetch_all(app.state.db.reader())
                    .await
                    .unwrap_or_else(|error| panic!("{}: {error}: {sql}", path.display()));
            let lines: Vec<String> = plan.into_iter().map(|(.., line)| line).collect();
            planned += 1;
            let allowed = WHOLE.iter().any(|(start, _)| sql.starts_with(start));
            slow.extend(scans(sql, &lines).into_iter().filter(|_| !allowed).map(|line| format!("{line} in: {sql}")));
        }
    }
    assert!(planned > 90, "only {planned} statements found");
    assert!(slow.is_empty(), "{} queries read a whole table:\n{}", slow.len(), slow.join("\n"));
}

#[test]
fn the_check_sees_a_scan_under_another_name() {
    let plan = ["SCAN s", "SEARCH c USING INDEX x (school_id=?)", "SCAN schools"].map(str::to_owned);
    assert_eq!(scans("SELECT 1 FROM sessions s JOIN schools", &plan), ["SCAN s"]);
    assert_eq!(scans("SELECT 1 FROM schools s", &plan), Vec::<String>::new());
}
