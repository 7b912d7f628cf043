//! Backups: one tar file with a manifest, a consistent copy of the database, and every recording
//! that it references.
//!
//! Backups are made while the service runs: SQLite copies its file under a read lock, and a
//! recording is written before its row. Unfinished uploads are left out; clients start them again.
//! The erasure list is included, so that a restore does not bring erased people back
//! ([`crate::privacy::erasures`]).

mod archive;
mod make;
pub mod passphrase;
mod restore;

use std::collections::BTreeMap;

pub use make::make;
pub use restore::{KeysRestored, RestoreRequest, RestoreSummary, restore};
use serde::{Deserialize, Serialize};

use crate::operations::key_files::KEYS;
use crate::privacy::erasures::ERASURES_FILE;

/// Name of the manifest, the first file of an archive.
const MANIFEST: &str = "manifest.json";
/// Name of the database, the second file.
const DATABASE: &str = "stylet.db";
/// Folder of the recordings, which follow.
const RECORDINGS: &str = "recordings";
/// Small files that an archive may contain before the recordings; the manifest holds their hashes.
const SMALL: [&str; 3] = [ERASURES_FILE, KEYS[0].sealed, KEYS[1].sealed];
/// Version of the archive layout. Layout 1 had no small files.
const FORMAT: u32 = 2;
/// Supported layout versions.
const KNOWN: std::ops::RangeInclusive<u32> = 1..=FORMAT;

/// Manifest of an archive. The recordings and their hashes are listed in the database.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
struct Manifest {
    /// Version of the layout.
    format: u32,
    /// Creation time, RFC 3339.
    made_at: String,
    /// Version of the program.
    program_version: String,
    /// SHA-256 of the database, lower-case hexadecimal.
    database_sha256: String,
    /// SHA-256 of each small file by its name, lower-case hexadecimal.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    files: BTreeMap<String, String>,
}

/// Why a restore failed.
#[derive(Debug)]
pub enum RestoreRefused {
    /// The archive or the target is not acceptable; the reason as text.
    Input(String),
    /// An operation failed.
    Work(anyhow::Error),
}

impl<E: Into<anyhow::Error>> From<E> for RestoreRefused {
    fn from(error: E) -> Self {
        Self::Work(error.into())
    }
}

/// A temporary file or folder, removed on drop.
#[derive(Debug)]
struct Scratch(std::path::PathBuf);

impl Drop for Scratch {
    fn drop(&mut self) {
        // A path that no longer exists was moved to its final place. Errors cannot be reported from
        // here.
        let _ = std::fs::remove_file(&self.0);
        let _ = std::fs::remove_dir_all(&self.0);
    }
}
