//! Backups: one tar file with a manifest, the database as it was at one moment, and every recording that it names.
//!
//! Made while the service runs: SQLite copies its file under a read lock, and a recording is on the disk before its row
//! is. What is still arriving in pieces is left out; whoever sends it begins again.

mod archive;
mod make;
mod restore;

use serde::{Deserialize, Serialize};

pub use make::make;
pub use restore::{restore, staging};

/// Name of the manifest, the first file of an archive.
const MANIFEST: &str = "manifest.json";
/// Name of the database, the second.
const DATABASE: &str = "stylet.db";
/// Folder of the recordings, which follow.
const RECORDINGS: &str = "recordings";
/// Version of this layout.
const FORMAT: u32 = 1;

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
}

/// Why nothing was restored.
#[derive(Debug)]
pub enum Refused {
    /// The archive, or the place it should go to, in words.
    Input(String),
    /// The work failed.
    Work(anyhow::Error),
}

impl<E: Into<anyhow::Error>> From<E> for Refused {
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
