//! The schema's promises. Fails when a table is not strict, when a migration is not repeatable, or when a reader could
//! write.

use sqlx::sqlite::SqliteConnectOptions;
use sqlx::{Connection, SqliteConnection};

use crate::support::App;

#[tokio::test]
async fn every_table_is_strict_and_the_journal_is_a_write_ahead_log() {
    only_on!(Sqlite, "about SQLite's file");
    let app = App::new().await;
    let reader = app.state.db.reader();
    let loose: Vec<String> = sqlx::query_scalar(
        "SELECT name FROM pragma_table_list WHERE schema = 'main' AND type = 'table' AND strict = 0 AND name NOT LIKE 'sqlite_%'
         AND name <> '_sqlx_migrations'",
    )
    .fetch_all(reader)
    .await
    .unwrap();
    assert_eq!(loose, Vec::<String>::new());
    let journal: String = sqlx::query_scalar("PRAGMA journal_mode").fetch_one(reader).await.unwrap();
    let keys: i64 = sqlx::query_scalar("PRAGMA foreign_keys").fetch_one(reader).await.unwrap();
    assert_eq!((journal.as_str(), keys), ("wal", 1));
}

#[tokio::test]
async fn migrating_again_changes_nothing_and_nothing_is_wrong() {
    let app = App::new().await;
    app.state.db.migrate().await.unwrap();
    assert_eq!(app.state.db.integrity().await.unwrap(), Vec::<String>::new());
}

#[tokio::test]
async fn a_row_that_points_nowhere_is_found() {
    only_on!(Sqlite, "about SQLite's file");
    let app = App::new().await;
    let careless = SqliteConnectOptions::new().filename(app.folder.path().join("stylet.db")).foreign_keys(false);
    let mut connection = SqliteConnection::connect_with(&careless).await.unwrap();
    let cohort = "INSERT INTO cohorts (id, school_id, name, created_at) VALUES (zeroblob(16), zeroblob(16), 'A', 0)";
    sqlx::raw_sql(cohort).execute(&mut connection).await.unwrap();
    let findings = app.state.db.integrity().await.unwrap();
    assert!(findings.len() == 1 && findings[0].contains("no such row in schools"), "{findings:?}");
}

#[tokio::test]
async fn a_reader_cannot_write() {
    let app = App::new().await;
    let refused = sqlx::raw_sql("DELETE FROM schools").execute(app.state.db.reader()).await.unwrap_err();
    assert!(["readonly", "read-only"].iter().any(|word| refused.to_string().contains(word)), "{refused}");
}

#[tokio::test]
async fn many_writers_at_once_all_get_their_turn() {
    let app = App::new().await;
    let one = async |n: u32| app.school(&format!("School {n}")).await;
    let made = futures::future::join_all((0..50).map(one)).await;
    assert_eq!(made.len(), 50);
    assert_eq!(store::operations::schools::list_schools(app.state.db.reader()).await.unwrap().len(), 50);
}
