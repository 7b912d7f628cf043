//! Backups: one tar file with a manifest, the database as it was at one moment, and every recording that it names.
//!
//! Made while the service runs: SQLite copies its file under a read lock, and a recording is on the disk before its row
//! is. What is still arriving in pieces is left out; whoever sends it begins again. The list of erasures goes with it, so that what
//! is restored brings nobody back ([`crate::erasures`]).

mod archive;
mod make;
pub mod passphrase;
mod restore;

use std::collections::BTreeMap;

pub use make::make;
pub use restore::{KeysRestored, RestoreRequest, RestoreSummary, restore};
use serde::{Deserialize, Serialize};

use crate::erasures::ERASURES_FILE;
use crate::key_files::KEYS;

/// Name of the manifest, the first file of an archive.
const MANIFEST: &str = "manifest.json";
/// Name of the database, the second.
const DATABASE: &str = "stylet.db";
/// Folder of the recordings, which follow.
const RECORDINGS: &str = "recordings";
/// Small files that an archive may hold before the recordings, each with its hash in the manifest.
const SMALL: [&str; 3] = [ERASURES_FILE, KEYS[0].sealed, KEYS[1].sealed];
/// Version of this layout. Layout 1 held no small files.
const FORMAT: u32 = 2;
/// Versions that are understood.
const KNOWN: std::ops::RangeInclusive<u32> = 1..=FORMAT;

/// What an archive says of itself. The recordings and their hashes stand in the database.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
struct Manifest {
    /// Version of the layout.
    format: u32,
    /// When it was made, RFC 3339.
    made_at: String,
    /// Version of the program.
    program_version: String,
    /// SHA-256 of the database, lower-case hexadecimal.
    database_sha256: String,
    /// SHA-256 of each small file by its name, lower-case hexadecimal.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    files: BTreeMap<String, String>,
}

/// Why nothing was restored.
#[derive(Debug)]
pub enum RestoreRefused {
    /// The archive, or the place it should go to, in words.
    Input(String),
    /// The work failed.
    Work(anyhow::Error),
}

impl<E: Into<anyhow::Error>> From<E> for RestoreRefused {
    fn from(error: E) -> Self {
        Self::Work(error.into())
    }
}

/// A file or folder that goes again unless it is kept.
#[derive(Debug)]
struct Scratch(std::path::PathBuf);

impl Drop for Scratch {
    fn drop(&mut self) {
        // What is not there any more was kept; nobody waits for the answer.
        let _ = std::fs::remove_file(&self.0);
        let _ = std::fs::remove_dir_all(&self.0);
    }
}
