//! What stands for moving in a program that is built for SQLite alone: nothing of it can be there.

use super::{CarriedTable, MoveError};
use crate::engine::without_password;
use crate::locks::LockError;
use crate::sessions::RecordingFile;
use crate::{Connection, Result};

/// The databases of a move, from which rows are carried and into which.
#[derive(Debug)]
pub enum DatabaseMove {}

/// One of both databases, held by this process until it is dropped.
#[derive(Debug)]
pub enum MoveLock {}

/// Rows that are carried and compared, and not kept yet.
#[derive(Debug)]
pub enum CarriedRows {}

impl DatabaseMove {
    /// Refuses.
    ///
    /// # Errors
    /// Always; they say which program moves.
    pub fn parse(from: &str, to: &str) -> std::result::Result<Self, MoveError> {
        Err(MoveError::Refused {
            place: format!("{} to {}", without_password(from), without_password(to)),
            why: "this program is built for SQLite alone; one that moves is built by \
                  `cargo build --release -p web-admin --features replicas`"
                .to_owned(),
        })
    }

    /// None is there.
    #[must_use]
    pub fn source(&self) -> String {
        match *self {}
    }

    /// None is there.
    #[must_use]
    pub fn target(&self) -> String {
        match *self {}
    }

    /// None is there.
    ///
    /// # Errors
    /// Never.
    pub async fn hold_source(&self, _holder: &str) -> std::result::Result<MoveLock, LockError> {
        match *self {}
    }

    /// None is there.
    ///
    /// # Errors
    /// Never.
    pub async fn hold_target(&self, _holder: &str) -> std::result::Result<MoveLock, LockError> {
        match *self {}
    }

    /// None is there.
    ///
    /// # Errors
    /// Never.
    pub async fn prepare(&self) -> std::result::Result<(), MoveError> {
        match *self {}
    }

    /// None is there.
    ///
    /// # Errors
    /// Never.
    pub async fn list_recordings(&self) -> std::result::Result<Vec<RecordingFile>, MoveError> {
        match *self {}
    }

    /// None is there.
    ///
    /// # Errors
    /// Never.
    pub async fn carry(&self) -> std::result::Result<CarriedRows, MoveError> {
        match *self {}
    }
}

impl CarriedRows {
    /// None is there.
    #[must_use]
    pub fn tables(&self) -> &[CarriedTable] {
        match *self {}
    }

    /// None is there.
    #[must_use]
    pub fn findings(&self) -> &[String] {
        match *self {}
    }

    /// None is there.
    #[must_use]
    pub fn forgotten_uploads(&self) -> u64 {
        match *self {}
    }

    /// None is there.
    pub fn target(&mut self) -> &mut Connection {
        match *self {}
    }

    /// None is there.
    ///
    /// # Errors
    /// Never.
    pub async fn keep(self) -> Result<()> {
        match self {}
    }
}
