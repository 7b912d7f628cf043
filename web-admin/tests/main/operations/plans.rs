//! No query reads a table of many rows from end to end, nor all that a school has in one. SQLite is asked how it would run
//! each statement of the storage. Fails when a query loses its index, when a new one never had any, and when a statement can no longer
//! be planned.

use crate::support::App;
use crate::support::statements::{StoredStatement, TwinPlace, stored_statements};

/// Tables that grow with attempts, people, cohorts or acts. Unfinished uploads do not: they expire.
pub const BIG: [&str; 27] = [
    "deliveries",
    "statements",
    "notices",
    "assignment_extensions",
    "segment_extensions",
    "study_participants",
    "survey_letters",
    "sessions",
    "scores",
    "regrading_lines",
    "grades",
    "metrics",
    "session_curves",
    "comments",
    "reviews",
    "supervisions",
    "ratings",
    "exam_sittings",
    "survey_responses",
    "practice",
    "practice_signs",
    "support_notes",
    "tallies",
    "people",
    "cohorts",
    "cohort_members",
    "audit_log",
];

/// Tables of which a school's part is listed, but that nobody reads from end to end.
pub const LISTED: [&str; 2] = ["assignments", "segment_tasks"];

/// What may read everything: beginnings of statements, each with the reason.
pub const WHOLE: [(&str, &str); 26] = [
    ("SELECT p.id, coalesce(v.user_name, p.email)", "a directory lists a school’s people, page by page"),
    ("SELECT c.id, c.name, g.external_id FROM cohorts", "the groups of a directory, all of them"),
    ("WITH RECURSIVE", "the generator of invented practice"),
    ("UPDATE people SET practised_at", "the generator of invented practice, and one person after an attempt"),
    ("INSERT INTO tallies", "sums a school up anew, after the generator"),
    ("DELETE FROM tallies", "the same"),
    ("INSERT INTO scores (id, school_id, session_id, score", "the generator of invented practice"),
    ("SELECT (SELECT count(*) FROM people WHERE role", "/metrics: short rows, rarely asked"),
    ("SELECT id, recording_path, recording_sha256", "verify and backup read every recording"),
    ("SELECT seq, at, school_id, actor", "verify and serve walk the whole audit log"),
    ("SELECT count(*) > 0 FROM audit_log WHERE hash", "verify --expect-head, which has walked the whole log"),
    ("SELECT g.session_id FROM grades g JOIN scores c", "verify holds every grade against its score"),
    ("SELECT session_id, score FROM scores ORDER BY rowid", "the same"),
    ("SELECT object, CASE action WHEN 'session.scored'", "verify holds every score against the audit log"),
    ("SELECT listed.* FROM", "a search for people looks at all of a school"),
    ("SELECT id, name FROM cohorts", "the cohorts to choose from, all of them"),
    ("SELECT c.id, c.name FROM cohorts c WHERE", "the cohorts that somebody sees, for an administrator all of them"),
    ("SELECT c.name AS cohort, c.id AS cohort_id", "the file of a year has every cohort"),
    ("SELECT count(*) FROM people", "greets an empty service, once at its start"),
    ("SELECT c.session_id, c.body FROM comments", "an administrator looks for a name before erasing whose it is"),
    ("WITH everybody AS", "once a day, and when somebody asks: whom a school keeps no longer"),
    ("DELETE FROM uploads WHERE session_id IS NULL", "in the copy that a backup is made of"),
    (
        "SELECT id, display_name, email, registrar_id FROM people WHERE sort_name",
        "at a start: an index that is empty but after an update",
    ),
    ("SELECT coalesce(sum(iif(p.role = 'guest'", "a school is written for research: its guests and staff, by command"),
    (
        "SELECT u.title AS survey, l.name, l.email, l.sent_at",
        "somebody’s own data, by an address in any case of letters",
    ),
    ("SELECT seq, hash FROM audit_log ORDER BY seq DESC", "reads one row from the end of the primary key"),
];

/// Lines of a plan that read a big table from end to end, or all of it that is a school's, also under another name. What an index of
/// few rows holds may be read whole.
fn scans(sql: &str, plan: &[String], few: &[String]) -> Vec<String> {
    let words: Vec<&str> =
        sql.split(|c: char| !(c.is_ascii_alphanumeric() || c == '_')).filter(|w| !w.is_empty()).collect();
    let is_of = |tables: &[&str], name: &str| {
        tables.contains(&name) || words.windows(2).any(|w| w[1] == name && tables.contains(&w[0]))
    };
    let of_school =
        |line: &str| line.ends_with("(school_id=?)") && !line.split(' ').any(|word| few.iter().any(|f| f == word));
    let slow = |line: &&String| {
        let name = line.split(' ').nth(1).unwrap_or_default();
        let (scanned, big) = (line.starts_with("SCAN "), is_of(&BIG, name));
        (scanned && (big || is_of(&LISTED, name))) || (big && of_school(line))
    };
    plan.iter().filter(slow).cloned().collect()
}

#[tokio::test]
async fn every_query_of_a_big_table_uses_an_index() {
    only_on!(Sqlite, "PostgreSQL's plans are read beside the engines");
    let app = App::new().await;
    let few: Vec<String> =
        sqlx::query_scalar("SELECT name FROM sqlite_master WHERE type = 'index' AND sql LIKE '%WHERE%'")
            .fetch_all(app.state.db.reader())
            .await
            .unwrap();
    let (mut planned, mut slow) = (0, Vec::new());
    for StoredStatement { sql, place } in stored_statements(TwinPlace::First) {
        let lines = plan(&app, &sql).await.unwrap_or_else(|error| panic!("{}: {error}: {sql}", place.display()));
        planned += 1;
        // What a new row has to do with others is looked for only while a foreign key is broken.
        let added = sql.starts_with("INSERT INTO") && !sql.contains("SELECT");
        let allowed = added || WHOLE.iter().any(|(start, _)| sql.starts_with(start));
        slow.extend(scans(&sql, &lines, &few).into_iter().filter(|_| !allowed).map(|line| format!("{line} in: {sql}")));
    }
    assert!(planned > 250, "only {planned} statements found");
    assert!(slow.is_empty(), "{} queries read a whole table:\n{}", slow.len(), slow.join("\n"));
}

/// How SQLite would run a statement.
async fn plan(app: &App, sql: &str) -> sqlx::Result<Vec<String>> {
    let explain = sqlx::query_as(sqlx::AssertSqlSafe(format!("EXPLAIN QUERY PLAN {sql}")));
    let lines: Vec<(i64, i64, i64, String)> = explain.fetch_all(app.state.db.reader()).await?;
    Ok(lines.into_iter().map(|(.., line)| line).collect())
}

#[tokio::test]
async fn the_latest_assignments_are_found_without_sorting_all_of_them() {
    only_on!(Sqlite, "PostgreSQL's plans are read beside the engines");
    let app = App::new().await;
    let statements = stored_statements(TwinPlace::First).into_iter().map(|statement| statement.sql);
    let lists: Vec<String> = statements
        .filter(|sql| sql.contains("FROM assignments a") && sql.contains("ORDER BY a.made_at DESC"))
        .collect();
    assert_eq!(lists.len(), 1);
    let lines = plan(&app, &lists[0]).await.unwrap();
    assert!(!lines.iter().any(|line| line.contains("TEMP B-TREE")), "{}", lines.join("\n"));
}

#[test]
fn the_check_sees_a_scan_under_another_name() {
    let plan = ["SCAN s", "SEARCH c USING INDEX x (school_id=? AND id=?)", "SCAN schools"].map(str::to_owned);
    assert_eq!(scans("SELECT 1 FROM sessions s JOIN schools", &plan, &[]), ["SCAN s"]);
    assert_eq!(scans("SELECT 1 FROM schools s", &plan, &[]), Vec::<String>::new());
    let plan = ["SEARCH s USING INDEX all (school_id=?)", "SEARCH s USING INDEX few (school_id=?)"].map(str::to_owned);
    assert_eq!(scans("SELECT 1 FROM sessions s", &plan, &["few".to_owned()]), [plan[0].clone()]);
}
