//! Services are replaced one by one, so the program before goes on with a database that the program after it has brought up to date. Fails
//! when a migration takes something away that the one before may still read or write.

use std::path::{Path, PathBuf};

/// The last migration with which all services had to be stopped.
const LAST_WITH_A_STOP: &str = "0470";

/// The statements of a migration that the program before it may not survive: whatever was there must stay, under its name, and what is
/// added must be nobody's duty to fill.
fn breaking_statements(migration: &str) -> Vec<String> {
    let lines = migration.lines().map(|line| line.split("--").next().unwrap_or_default());
    let whole = lines.collect::<Vec<_>>().join(" ");
    let words = |statement: &str| statement.to_uppercase().split_whitespace().collect::<Vec<_>>().join(" ");
    let breaks = |statement: &String| {
        ["DROP TABLE", "DROP VIEW"].iter().any(|start| statement.starts_with(start))
            || statement.starts_with("ALTER TABLE")
                && ([" DROP COLUMN ", " RENAME ", " SET NOT NULL", " TYPE "]
                    .iter()
                    .any(|part| statement.contains(part))
                    || statement.contains(" NOT NULL") && !statement.contains(" DEFAULT "))
    };
    whole.split(';').map(words).filter(breaks).collect()
}

/// PostgreSQL's: a database of SQLite has one service at a time.
fn migrations_after(last: &str) -> Vec<PathBuf> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../migrations/postgres");
    let files = root.read_dir().unwrap().map(|entry| entry.unwrap().path());
    let numbered = |file: &PathBuf| file.extension().is_some_and(|ending| ending == "sql");
    files.filter(numbered).filter(|file| &file.file_name().unwrap().to_str().unwrap()[..4] > last).collect()
}

#[test]
fn the_program_before_survives_each_migration() {
    for file in migrations_after(LAST_WITH_A_STOP) {
        let found = breaking_statements(&std::fs::read_to_string(&file).unwrap());
        assert_eq!(found, Vec::<String>::new(), "{}: in two steps, the second an update later", file.display());
    }
}

#[test]
fn what_takes_away_is_told_from_what_adds() {
    for breaking in [
        "-- Not needed.\nALTER TABLE uploads\n  DROP COLUMN begun;",
        "CREATE TABLE a (b INTEGER); drop table c;",
        "ALTER TABLE a RENAME COLUMN b TO c",
        "ALTER TABLE a ADD COLUMN b TEXT NOT NULL",
        "ALTER TABLE a ALTER COLUMN b TYPE BIGINT",
    ] {
        assert_eq!(breaking_statements(breaking).len(), 1, "{breaking}");
    }
    let adding =
        "-- DROP TABLE a;\nCREATE TABLE a (b TEXT NOT NULL); ALTER TABLE a ADD COLUMN c BIGINT NOT NULL DEFAULT 0;
                  ALTER TABLE a ADD COLUMN d TEXT; DROP TRIGGER e; DROP INDEX f";
    assert_eq!(breaking_statements(adding), Vec::<String>::new());
    let with_a_stop = migrations_after("0469").into_iter().min().unwrap();
    assert!(!breaking_statements(&std::fs::read_to_string(with_a_stop).unwrap()).is_empty(), "0470 dropped columns");
}
