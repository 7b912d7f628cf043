//! The database engines: SQLite, and PostgreSQL with the feature `postgres`. The rest of the store
//! uses [`Connection`], [`Executor`] and [`Pool`]; the address selects the engine at run time. Rows
//! keep their native form until their values are decoded.

use std::path::{Path, PathBuf};

mod address;
mod answers;
mod database;
mod driver;
#[cfg(feature = "postgres")]
mod dump;
#[cfg(feature = "postgres")]
mod postgres;
mod rows;
mod sqlite;
mod values;

pub(crate) use address::without_password;
pub use address::{AddressRefused, DatabaseAddress, EngineKind};
pub(crate) use answers::AnswerRow;
pub use database::{DatabaseLock, DumpedDatabase, is_database_unavailable, is_disk_full};
pub(crate) use database::{
    is_table_there, keep_more_in_memory, migrations, refresh_statistics, resume_triggers, suspend_triggers,
};
pub use driver::{Connection, Engine};
#[cfg(feature = "postgres")]
pub(crate) use postgres::{WRITING, options as postgres_options};
pub(crate) use rows::{TableColumns, add_missing_rows};
pub(crate) use values::{ArgumentKind, TypeInfo, ValueRef, read_natively};

/// A dump could not be restored for verification.
#[derive(Debug, thiserror::Error)]
#[error("{file}: {why}", file = file.display())]
pub struct DumpRefused {
    /// Path of the dump.
    pub file: PathBuf,
    /// Reason, without a password.
    pub why: String,
}

impl DumpRefused {
    /// The error for a database on SQLite, which has no dumps.
    fn on_sqlite(file: &Path) -> Self {
        let why = "a dump is verified on the PostgreSQL server that --database names, and this database is SQLite's; of SQLite there are \
                   no dumps, and a copy of its database is verified by --database";
        Self { file: file.to_owned(), why: why.to_owned() }
    }
}

/// Selects an expression by the engine of a connection, a pool, a database or an address: the first
/// is for SQLite, the second for PostgreSQL.
macro_rules! twin {
    ($to:expr, $first:expr, $second:expr $(,)?) => {
        match $to.kind() {
            $crate::engine::EngineKind::Sqlite => $first,
            #[cfg(feature = "postgres")]
            $crate::engine::EngineKind::Postgres => $second,
        }
    };
}
pub(crate) use twin;

/// Evaluates the same expression with the native value of either engine's variant.
macro_rules! native {
    ($of:ident, $value:expr, $own:ident => $does:expr) => {
        match $value {
            $of::Sqlite($own) => $does,
            #[cfg(feature = "postgres")]
            $of::Postgres($own) => $does,
        }
    };
}
use native;

/// A connection pool.
pub type Pool = sqlx::Pool<Engine>;

/// Runs statements: a connection, a pool or a transaction.
pub trait Executor<'e>: sqlx::Executor<'e, Database = Engine> {
    /// Returns the engine.
    fn kind(&self) -> EngineKind;
}

impl<'e> Executor<'e> for &'e mut Connection {
    fn kind(&self) -> EngineKind {
        Connection::kind(self)
    }
}

impl<'e> Executor<'e> for &Pool {
    fn kind(&self) -> EngineKind {
        self.connect_options().kind()
    }
}
