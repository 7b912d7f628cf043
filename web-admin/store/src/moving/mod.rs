//! A school's rows on their way from one engine to the other: table by table, as they are, in one transaction, and compared afterwards.
//!
//! A program that speaks to both moves both ways. One that speaks to SQLite alone says how to build the other.

#[cfg(not(feature = "postgres"))]
mod absent;
#[cfg(feature = "postgres")]
mod both;
#[cfg(feature = "postgres")]
mod columns;
#[cfg(feature = "postgres")]
mod postgres_end;
#[cfg(feature = "postgres")]
mod sqlite_end;
#[cfg(feature = "postgres")]
mod tuples;

#[cfg(not(feature = "postgres"))]
pub use absent::{CarriedRows, DatabaseMove, MoveLock};
#[cfg(feature = "postgres")]
pub use both::{CarriedRows, DatabaseMove, MoveLock};

use crate::Error;

/// A table that was carried.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct CarriedTable {
    /// Its name.
    pub name: String,
    /// Its rows.
    pub rows: u64,
    /// SHA-256 of all its rows in the order of its key, lower-case hexadecimal: the same of both engines.
    pub sha256: String,
}

/// Why rows were not carried.
#[derive(Debug, thiserror::Error)]
pub enum MoveError {
    /// What was named, or what it holds, is not what can be moved or moved into.
    #[error("{place}: {why}")]
    Refused {
        /// The database, without its password, or a place in it.
        place: String,
        /// Why, and what is allowed.
        why: String,
    },
    /// A database has not done what was asked.
    #[error("{place}: {why}")]
    Failed {
        /// The database, without its password.
        place: String,
        /// Why.
        why: Error,
    },
}
