//! The database engine that this program is built for. Everything else in the storage says [`Connection`], [`Executor`] and [`Pool`]:
//! types of one engine, chosen when the program is built, so that no row passes through a form between both.

use std::path::PathBuf;

mod address;
#[cfg(feature = "postgres")]
mod dump;
#[cfg(feature = "postgres")]
mod postgres;
mod rows;
#[cfg(not(feature = "postgres"))]
mod sqlite;

#[cfg(feature = "postgres")]
use postgres as chosen;
#[cfg(not(feature = "postgres"))]
use sqlite as chosen;

#[cfg(feature = "postgres")]
pub(crate) use address::EngineKind;
pub(crate) use address::without_password;
pub use address::{AddressRefused, DatabaseAddress};
#[cfg(feature = "postgres")]
pub(crate) use chosen::WRITING;
pub use chosen::{DatabaseLock, DumpedDatabase, Engine, is_database_away, is_disk_full};
pub(crate) use chosen::{
    LISTENING_PERIOD, MIGRATIONS, SHARED, is_table_there, keep_more_in_memory, refresh_statistics, resume_triggers,
    suspend_triggers,
};
pub(crate) use rows::{TableColumns, add_missing_rows};

/// Why a dump could not be looked at.
#[derive(Debug, thiserror::Error)]
#[error("{file}: {why}", file = file.display())]
pub struct DumpRefused {
    /// The dump.
    pub file: PathBuf,
    /// Why, without a password.
    pub why: String,
}

/// Of two twins of a statement the engine's own: SQLite's stands first, PostgreSQL's after it.
#[cfg(not(feature = "postgres"))]
macro_rules! twin {
    ($first:expr, $second:expr $(,)?) => {
        $first
    };
}
#[cfg(feature = "postgres")]
macro_rules! twin {
    ($first:expr, $second:expr $(,)?) => {
        $second
    };
}
pub(crate) use twin;

/// A connection that writes or reads.
pub type Connection = <Engine as sqlx::Database>::Connection;

/// Several connections.
pub type Pool = sqlx::Pool<Engine>;

/// A row of an answer.
pub(crate) type AnswerRow = <Engine as sqlx::Database>::Row;

/// Whatever a statement may be given to: a connection, a pool, a transaction.
pub trait Executor<'e>: sqlx::Executor<'e, Database = Engine> {}

impl<'e, E: sqlx::Executor<'e, Database = Engine>> Executor<'e> for E {}
