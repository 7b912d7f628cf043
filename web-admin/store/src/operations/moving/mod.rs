//! Moves all rows from one engine to the other: table by table, unchanged, in one transaction, with
//! a comparison afterwards.
//!
//! With the feature `postgres` it moves in both directions. Without it, the error explains how to
//! build a program that can.

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

/// A copied table.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct CarriedTable {
    /// Name of the table.
    pub name: String,
    /// Number of rows.
    pub rows: u64,
    /// SHA-256 over all rows in the order of the key, in lower-case hexadecimal. It does not depend
    /// on the engine.
    pub sha256: String,
}

/// Error of a move.
#[derive(Debug, thiserror::Error)]
pub enum MoveError {
    /// The source or the target is not suitable.
    #[error("{place}: {why}")]
    Refused {
        /// The database, without its password, or a place in it.
        place: String,
        /// Reason, and accepted values.
        why: String,
    },
    /// A database operation failed.
    #[error("{place}: {why}")]
    Failed {
        /// The database, without its password.
        place: String,
        /// Cause.
        why: Error,
    },
}
