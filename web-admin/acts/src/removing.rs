//! Files that are to be gone, whether they were there or not.

use std::io::ErrorKind;
use std::path::{Path, PathBuf};

/// Removes a file; one that is not there is gone already.
pub(crate) fn remove_if_there(file: &Path) -> std::io::Result<()> {
    match std::fs::remove_file(file) {
        Err(error) if error.kind() != ErrorKind::NotFound => Err(error),
        _ => Ok(()),
    }
}

/// Removes a folder with all that is in it; one that is not there is gone already.
pub(crate) fn remove_folder(folder: &Path) -> std::io::Result<()> {
    match std::fs::remove_dir_all(folder) {
        Err(error) if error.kind() != ErrorKind::NotFound => Err(error),
        _ => Ok(()),
    }
}

/// A file that is deleted when this is dropped, unless it is kept.
#[derive(Debug)]
pub(crate) struct PartFile {
    /// The file.
    pub(crate) path: PathBuf,
    /// It stays.
    pub(crate) kept: bool,
}

impl Drop for PartFile {
    fn drop(&mut self) {
        if !self.kept {
            // Nobody waits for the answer; what is left over goes at the next start.
            let _ = std::fs::remove_file(&self.path);
        }
    }
}
