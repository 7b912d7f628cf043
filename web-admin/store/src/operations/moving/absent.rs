//! Placeholders for a program without the feature `postgres`, which cannot move a database.

use super::{CarriedTable, MoveError};
use crate::engine::without_password;
use crate::locks::LockError;
use crate::recordings::sessions::RecordingFile;
use crate::{Connection, Result};

/// Source and target of a move. Without the feature `postgres` it has no values.
#[derive(Debug)]
pub enum DatabaseMove {}

/// A lock on one of the databases. Without the feature `postgres` it has no values.
#[derive(Debug)]
pub enum MoveLock {}

/// Copied rows before the commit. Without the feature `postgres` it has no values.
#[derive(Debug)]
pub enum CarriedRows {}

impl DatabaseMove {
    /// Refuses the move.
    ///
    /// # Errors
    /// Always. The error explains how to build a program that can move a database.
    pub fn parse(from: &str, to: &str) -> std::result::Result<Self, MoveError> {
        Err(MoveError::Refused {
            place: format!("{} to {}", without_password(from), without_password(to)),
            why: "this program is built for SQLite only; for moves, build with `cargo build --release -p web-admin --features replicas`"
                .to_owned(),
        })
    }

    /// Unreachable: there are no values of this type.
    #[must_use]
    pub fn source(&self) -> String {
        match *self {}
    }

    /// Unreachable: there are no values of this type.
    #[must_use]
    pub fn target(&self) -> String {
        match *self {}
    }

    /// Unreachable: there are no values of this type.
    ///
    /// # Errors
    /// Never.
    pub async fn hold_source(&self, _holder: &str) -> std::result::Result<MoveLock, LockError> {
        match *self {}
    }

    /// Unreachable: there are no values of this type.
    ///
    /// # Errors
    /// Never.
    pub async fn hold_target(&self, _holder: &str) -> std::result::Result<MoveLock, LockError> {
        match *self {}
    }

    /// Unreachable: there are no values of this type.
    ///
    /// # Errors
    /// Never.
    pub async fn prepare(&self) -> std::result::Result<(), MoveError> {
        match *self {}
    }

    /// Unreachable: there are no values of this type.
    ///
    /// # Errors
    /// Never.
    pub async fn list_recordings(&self) -> std::result::Result<Vec<RecordingFile>, MoveError> {
        match *self {}
    }

    /// Unreachable: there are no values of this type.
    ///
    /// # Errors
    /// Never.
    pub async fn carry(&self) -> std::result::Result<CarriedRows, MoveError> {
        match *self {}
    }
}

impl CarriedRows {
    /// Unreachable: there are no values of this type.
    #[must_use]
    pub fn tables(&self) -> &[CarriedTable] {
        match *self {}
    }

    /// Unreachable: there are no values of this type.
    #[must_use]
    pub fn findings(&self) -> &[String] {
        match *self {}
    }

    /// Unreachable: there are no values of this type.
    #[must_use]
    pub fn forgotten_uploads(&self) -> u64 {
        match *self {}
    }

    /// Unreachable: there are no values of this type.
    pub fn target(&mut self) -> &mut Connection {
        match *self {}
    }

    /// Unreachable: there are no values of this type.
    ///
    /// # Errors
    /// Never.
    pub async fn keep(self) -> Result<()> {
        match self {}
    }
}
