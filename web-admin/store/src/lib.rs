//! Everything that is SQL. Functions that read take any executor; functions that write take a connection, which only
//! [`Database::write`] hands out, so that there is one writer at a time.
//!
//! What a viewer may see of trainees is in one place, the view `taught_trainees`.
//!
//! A limit that is bound is written `LIMIT $1 + 0`: SQLite looks at the value of a bare parameter when it plans a statement, and therefore
//! plans it anew at each execution.
//!
//! Whatever asks the database fails when the database does; a function says only what else it refuses.

use model::Moment;
use serde::{Deserialize, Deserializer};
use sqlx::Transaction;
pub use sqlx::migrate::MigrateError;

pub use engine::{
    AddressRefused, Connection, DatabaseAddress, DatabaseLock, DumpRefused, DumpedDatabase, Engine, EngineKind,
    Executor, Pool, is_database_away, is_disk_full,
};
pub use json::Json;

pub mod account_links;
pub mod assignments;
pub mod audit;
pub mod audit_search;
pub mod backups;
pub mod brakes;
pub mod ceremonies;
pub mod cohorts;
pub mod comments;
pub mod curricula;
pub mod deadlines;
pub mod directory;
pub mod drafts;
mod engine;
pub mod exercises;
pub mod experts;
pub mod exports;
pub mod generated;
pub mod grades;
pub mod instruments;
pub mod jobs;
mod json;
pub mod links;
pub mod locks;
pub mod logos;
pub mod mails;
pub mod motions;
pub mod moving;
pub mod notices;
pub mod origins;
pub mod passkeys;
pub mod people;
pub mod pictures;
pub mod practice;
pub mod proofs;
pub mod ratings;
pub mod regradings;
pub mod replicas;
pub mod reports;
pub mod research;
pub mod retention;
pub mod reviews;
pub mod rosters;
pub mod schools;
pub mod scores;
pub mod second_factors;
pub mod segments;
pub mod service;
pub mod sessions;
pub mod sign_in_codes;
pub mod stations;
pub mod studies;
pub mod supervisions;
pub mod surveys;
pub mod tallies;
pub mod texts;
pub mod tokens;
pub mod tries;
pub mod uploads;
pub mod web_sessions;

/// What a query may come to.
pub type Result<T> = std::result::Result<T, sqlx::Error>;

/// Why a query came to nothing.
pub type Error = sqlx::Error;

/// A number within JSON that SQLite has written, or none. As a text of 17 digits it is the very number that was stored: as a
/// number of JSON it would have 15.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ExactNumber(pub Option<f64>);

impl<'de> Deserialize<'de> for ExactNumber {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> std::result::Result<Self, D::Error> {
        let text: Option<&str> = Option::deserialize(deserializer)?;
        text.map(str::parse).transpose().map(Self).map_err(serde::de::Error::custom)
    }
}

/// A transaction that holds the write lock from its first moment.
pub type Write = Transaction<'static, Engine>;

/// The database: one connection that writes, several that read.
#[derive(Clone, Debug)]
pub struct Database {
    writer: Pool,
    reader: Pool,
    kind: EngineKind,
}

impl Database {
    /// Opens a database where there is one.
    ///
    /// # Errors
    /// When what is there cannot be opened.
    pub async fn open_if_there(address: &DatabaseAddress) -> Result<Option<Self>> {
        if Self::is_there(address).await? { Self::open_existing(address).await.map(Some) } else { Ok(None) }
    }

    /// Brings the schema up to date.
    ///
    /// # Errors
    /// When a migration fails, or the database is newer than this program.
    pub async fn migrate(&self) -> std::result::Result<(), MigrateError> {
        engine::migrations(self.kind).run(&self.writer).await?;
        Ok(directory::fill_search_texts(&self.writer).await?)
    }

    /// The newest migration that the database has had; 0 where it had none.
    async fn newest_migration(&self) -> Result<i64> {
        sqlx::query_scalar("SELECT coalesce(max(version), 0) FROM _sqlx_migrations").fetch_one(&self.reader).await
    }

    /// How many migrations this program knows and the database has not had: 0 when it is up to date.
    ///
    /// # Errors
    /// When the file cannot be read, or was never migrated.
    pub async fn count_missing_migrations(&self) -> Result<usize> {
        let newest = self.newest_migration().await?;
        Ok(engine::migrations(self.kind).iter().filter(|migration| migration.version > newest).count())
    }

    /// Connections that read, and refuse to write: that goes through [`Database::write`].
    #[must_use]
    pub fn reader(&self) -> &Pool {
        &self.reader
    }

    /// Reads and writes a row, as everything that is acknowledged must.
    ///
    /// # Errors
    /// When the database does not answer, or takes nothing.
    pub async fn beat(&self, now: Moment) -> Result<()> {
        sqlx::query("SELECT 1").execute(&self.reader).await?;
        let mut tx = self.write().await?;
        sqlx::query("UPDATE heartbeat SET beaten_at = $1").bind(now).execute(&mut *tx).await?;
        tx.commit().await
    }

    /// Closes every connection, so that a write-ahead log is folded into its file.
    pub async fn close(&self) {
        self.reader.close().await;
        self.writer.close().await;
    }
}
