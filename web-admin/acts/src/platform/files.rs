//! Removes files; a missing file is not an error.

use std::io::ErrorKind;
use std::path::{Path, PathBuf};

/// Removes a file, if it exists.
pub(crate) fn remove_if_there(file: &Path) -> std::io::Result<()> {
    match std::fs::remove_file(file) {
        Err(error) if error.kind() != ErrorKind::NotFound => Err(error),
        _ => Ok(()),
    }
}

/// Removes a folder with its content, if it exists.
pub(crate) fn remove_folder(folder: &Path) -> std::io::Result<()> {
    match std::fs::remove_dir_all(folder) {
        Err(error) if error.kind() != ErrorKind::NotFound => Err(error),
        _ => Ok(()),
    }
}

/// A file that is deleted on drop unless `kept` is set.
#[derive(Debug)]
pub(crate) struct PartFile {
    /// Path of the file.
    pub(crate) path: PathBuf,
    /// Whether to keep the file.
    pub(crate) kept: bool,
}

impl Drop for PartFile {
    fn drop(&mut self) {
        if !self.kept {
            // Errors cannot be reported from here; the next start removes leftover files.
            let _ = std::fs::remove_file(&self.path);
        }
    }
}
