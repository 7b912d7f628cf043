//! All SQL of the service. Functions that read accept any executor; functions that write need a
//! connection from [`Database::write`], so that there is one writer at a time.
//!
//! The view `taught_trainees` alone decides which trainees a person may see.
//!
//! A bound limit is written `LIMIT $1 + 0`: SQLite plans a statement with a bare parameter by its
//! value, and therefore plans it anew at each execution.
//!
//! Every function fails if the database fails; its documentation only names other causes of errors.

pub use engine::{
    AddressRefused, Connection, DatabaseAddress, DatabaseLock, DumpRefused, DumpedDatabase, Engine, EngineKind,
    Executor, Pool, is_database_unavailable, is_disk_full,
};
pub use json::Json;
use model::Moment;
use serde::{Deserialize, Deserializer};
use sqlx::Transaction;
pub use sqlx::migrate::MigrateError;

pub mod audit;
pub mod auth;
pub mod authoring;
mod engine;
mod json;
pub mod letters;
pub mod locks;
pub mod operations;
pub mod people;
pub mod privacy;
pub mod recordings;
pub mod replicas;
pub mod scoring;
pub mod stations;
pub mod studies;
pub mod surveys;
pub mod training;

/// Result of a query.
pub type Result<T> = std::result::Result<T, sqlx::Error>;

/// Error of a query.
pub type Error = sqlx::Error;

/// A number in JSON written by SQLite, or null. It is written as text with 17 digits, which
/// preserves the stored value; SQLite writes JSON numbers with only 15 digits.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ExactNumber(pub Option<f64>);

impl<'de> Deserialize<'de> for ExactNumber {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> std::result::Result<Self, D::Error> {
        let text: Option<&str> = Option::deserialize(deserializer)?;
        text.map(str::parse).transpose().map(Self).map_err(serde::de::Error::custom)
    }
}

/// A transaction that holds the write lock from its start.
pub type Write = Transaction<'static, Engine>;

/// The database: one connection for writing, several for reading.
#[derive(Clone, Debug)]
pub struct Database {
    writer: Pool,
    reader: Pool,
    kind: EngineKind,
}

impl Database {
    /// Opens a database if it exists.
    ///
    /// # Errors
    /// If it exists but cannot be opened.
    pub async fn open_if_there(address: &DatabaseAddress) -> Result<Option<Self>> {
        if Self::is_there(address).await? { Self::open_existing(address).await.map(Some) } else { Ok(None) }
    }

    /// Applies the missing migrations and fills the search columns of older accounts.
    ///
    /// # Errors
    /// If a migration fails, or the database is newer than this program.
    pub async fn migrate(&self) -> std::result::Result<(), MigrateError> {
        engine::migrations(self.kind).run(&self.writer).await?;
        Ok(people::directory::fill_search_texts(&self.writer).await?)
    }

    /// Returns the version of the newest applied migration; 0 without migrations.
    async fn newest_migration(&self) -> Result<i64> {
        sqlx::query_scalar("SELECT coalesce(max(version), 0) FROM _sqlx_migrations").fetch_one(&self.reader).await
    }

    /// Returns the number of migrations that have not been applied; 0 if the schema is current.
    ///
    /// # Errors
    /// If the database cannot be read, or was never migrated.
    pub async fn count_missing_migrations(&self) -> Result<usize> {
        let newest = self.newest_migration().await?;
        Ok(engine::migrations(self.kind).iter().filter(|migration| migration.version > newest).count())
    }

    /// Returns the read-only connections. Writes use [`Database::write`].
    #[must_use]
    pub fn reader(&self) -> &Pool {
        &self.reader
    }

    /// Checks that the database can be read and written.
    ///
    /// # Errors
    /// If the database does not respond or cannot be written.
    pub async fn beat(&self, now: Moment) -> Result<()> {
        sqlx::query("SELECT 1").execute(&self.reader).await?;
        let mut tx = self.write().await?;
        sqlx::query("UPDATE heartbeat SET beaten_at = $1").bind(now).execute(&mut *tx).await?;
        tx.commit().await
    }

    /// Closes all connections; SQLite then checkpoints its write-ahead log into the file.
    pub async fn close(&self) {
        self.reader.close().await;
        self.writer.close().await;
    }
}
