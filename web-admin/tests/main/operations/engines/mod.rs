//! Two engines, one storage. Fails when the schemas of SQLite and PostgreSQL differ in a table, a column, a key, an index or a trigger,
//! when one lets pass what the other refuses, when they say so in other words, or when a statement is none to PostgreSQL.

mod plans;
mod promises;
mod schema;
mod statements;
mod updates;

use std::path::Path;

use sqlx::migrate::Migrator;
use sqlx::postgres::PgConnection;
use sqlx::{AssertSqlSafe, Connection, SqliteConnection};

use crate::support::postgres::PostgresServer;

/// Both, each with its schema and nothing in it.
struct BothEngines {
    sqlite: SqliteConnection,
    postgres: PgConnection,
    /// Stops when it goes.
    _server: PostgresServer,
}

impl BothEngines {
    /// None where PostgreSQL is not installed.
    async fn start() -> Option<Self> {
        let server = PostgresServer::start().await?;
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../migrations");
        let mut sqlite = SqliteConnection::connect("sqlite::memory:").await.unwrap();
        Migrator::new(folder.as_path()).await.unwrap().run(&mut sqlite).await.unwrap();
        let mut postgres = server.connect().await;
        Migrator::new(folder.join("postgres")).await.unwrap().run(&mut postgres).await.unwrap();
        Some(Self { sqlite, postgres, _server: server })
    }

    /// What each says to a statement: nothing, or why not. `#1` is an id, `#hash` are 32 bytes.
    async fn ask(&mut self, statement: &str) -> (Option<String>, Option<String>) {
        let told = |error: sqlx::Error| error.as_database_error().unwrap().message().to_owned();
        let ids =
            (1..=9).fold(statement.to_owned(), |sql, n| sql.replace(&format!("#{n}"), &format!("unhex('{n:032}')")));
        let sql = |hash| AssertSqlSafe(ids.replace("#hash", hash));
        let sqlite = sqlx::raw_sql(sql("zeroblob(32)")).execute(&mut self.sqlite).await.err().map(told);
        let hash = "decode(repeat('00', 32), 'hex')";
        let postgres = sqlx::raw_sql(sql(hash)).execute(&mut self.postgres).await.err().map(told);
        (sqlite, postgres)
    }

    /// Both do it.
    async fn agree_to(&mut self, statement: &str) {
        assert_eq!(self.ask(statement).await, (None, None), "{statement}");
    }

    /// Both refuse it in these words.
    async fn refuse(&mut self, statement: &str, words: &str) {
        let words = Some(words.to_owned());
        assert_eq!(self.ask(statement).await, (words.clone(), words), "{statement}");
    }

    /// The one number that both answer.
    async fn number(&mut self, query: &str) -> i64 {
        let sql = || AssertSqlSafe(query.to_owned());
        let sqlite: i64 = sqlx::query_scalar(sql()).fetch_one(&mut self.sqlite).await.unwrap();
        let postgres: i64 = sqlx::query_scalar(sql()).fetch_one(&mut self.postgres).await.unwrap();
        assert_eq!(sqlite, postgres, "{query}");
        sqlite
    }
}
