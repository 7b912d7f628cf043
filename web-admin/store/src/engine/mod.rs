//! The database engine that this program is built for. Everything else in the storage says [`Connection`], [`Executor`] and [`Pool`]:
//! types of one engine, chosen when the program is built, so that no row passes through a form between both.

mod sqlite;

pub(crate) use sqlite::{BEGIN, LISTENING_PERIOD, MIGRATIONS, SHARED, is_table_there};
pub use sqlite::{Engine, is_disk_full};

/// A connection that writes or reads.
pub type Connection = <Engine as sqlx::Database>::Connection;

/// Several connections.
pub type Pool = sqlx::Pool<Engine>;

/// A row of an answer.
pub(crate) type AnswerRow = <Engine as sqlx::Database>::Row;

/// Whatever a statement may be given to: a connection, a pool, a transaction.
pub trait Executor<'e>: sqlx::Executor<'e, Database = Engine> {}

impl<'e, E: sqlx::Executor<'e, Database = Engine>> Executor<'e> for E {}
