//! Removes files, where a missing file is not an error, and hashes them.

use std::fs::File;
use std::io::{ErrorKind, Read};
use std::path::{Path, PathBuf};

use data_encoding::HEXLOWER;
use sha2::{Digest, Sha256};

/// Removes a file, if it exists.
pub fn remove_if_there(file: &Path) -> std::io::Result<()> {
    match std::fs::remove_file(file) {
        Err(error) if error.kind() != ErrorKind::NotFound => Err(error),
        _ => Ok(()),
    }
}

/// Removes a folder with its content, if it exists.
pub fn remove_folder(folder: &Path) -> std::io::Result<()> {
    match std::fs::remove_dir_all(folder) {
        Err(error) if error.kind() != ErrorKind::NotFound => Err(error),
        _ => Ok(()),
    }
}

/// A file that is deleted on drop unless `kept` is set.
#[derive(Debug)]
pub struct PartFile {
    /// Path of the file.
    pub path: PathBuf,
    /// Whether to keep the file.
    pub kept: bool,
}

impl Drop for PartFile {
    fn drop(&mut self) {
        if !self.kept {
            // Errors cannot be reported from here; the next start removes leftover files.
            let _ = std::fs::remove_file(&self.path);
        }
    }
}

/// Returns the SHA-256 of a file, lower-case hexadecimal, and its size in bytes. Blocks.
///
/// # Errors
/// Fails if it cannot be read.
pub fn hash_file(path: &Path) -> std::io::Result<(String, u64)> {
    let (mut file, mut hash, mut size) = (File::open(path)?, Sha256::new(), 0);
    let mut piece = vec![0; 1 << 16];
    loop {
        match file.read(&mut piece)? {
            0 => return Ok((HEXLOWER.encode(&hash.finalize()), size)),
            read => {
                hash.update(&piece[..read]);
                size += read as u64;
            }
        }
    }
}
