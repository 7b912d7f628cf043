//! Files that are to be gone, whether they were there or not.

use std::io::ErrorKind;
use std::path::Path;

/// Removes a file; one that is not there is gone already.
pub(crate) fn remove_if_there(file: &Path) -> std::io::Result<()> {
    match std::fs::remove_file(file) {
        Err(error) if error.kind() != ErrorKind::NotFound => Err(error),
        _ => Ok(()),
    }
}
