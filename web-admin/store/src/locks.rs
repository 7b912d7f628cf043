//! Lock files, each held by one process for exclusive access.
//!
//! The operating system releases the lock when the process ends, even after a crash, so that
//! nothing has to be cleaned up.

use std::fs::{File, OpenOptions, TryLockError};
use std::io::{Read, Seek, Write};
use std::path::Path;
use std::time::Duration;

/// Number of attempts to take a lock.
pub(crate) const TRIES: u32 = 40;
/// Pause between two attempts: 2 s in total.
pub(crate) const BETWEEN_TRIES: Duration = Duration::from_millis(50);

/// The data cannot be locked.
#[derive(Debug, thiserror::Error)]
pub enum LockError {
    /// Another process holds the lock.
    #[error("{place}: in use by {holder}; stop it first, or choose another folder")]
    Held {
        /// The lock file or the database.
        place: String,
        /// Name of the process that holds it.
        holder: String,
    },
    /// The lock cannot be created.
    #[error("{place}: cannot be locked: {why}")]
    Unusable {
        /// The lock file or the database.
        place: String,
        /// Cause.
        why: Box<dyn std::error::Error + Send + Sync>,
    },
}

/// A locked file, held until dropped.
#[derive(Debug)]
pub struct FileLock {
    _file: File,
}

impl FileLock {
    /// Locks a file, which is created if it is missing, and writes the name of the holder into it.
    /// Waits up to 2 s for another holder.
    ///
    /// # Errors
    /// If another process holds the lock, or the file cannot be created.
    pub fn take(path: &Path, holder: &str) -> Result<Self, LockError> {
        let place = || path.display().to_string();
        let unusable = |why: std::io::Error| LockError::Unusable { place: place(), why: why.into() };
        if let Some(folder) = path.parent() {
            std::fs::create_dir_all(folder).map_err(unusable)?;
        }
        let mut options = OpenOptions::new();
        let mut file = options.read(true).write(true).create(true).truncate(false).open(path).map_err(unusable)?;
        match try_patiently(&file) {
            Ok(()) => {}
            Err(TryLockError::WouldBlock) => {
                let mut holder = String::new();
                // The holder may not have written its name yet.
                let _ = file.read_to_string(&mut holder);
                let holder = if holder.is_empty() { "another process".to_owned() } else { holder };
                return Err(LockError::Held { place: place(), holder });
            }
            Err(TryLockError::Error(why)) => return Err(unusable(why)),
        }
        let mut write = || {
            file.set_len(0)?;
            file.rewind()?;
            file.write_all(holder.as_bytes())
        };
        write().map_err(unusable)?;
        Ok(Self { _file: file })
    }

    /// Locks the file next to a database file that has the same name with `.lock` appended.
    pub(crate) fn take_beside(database: &Path, holder: &str) -> Result<Self, LockError> {
        let mut name = database.as_os_str().to_owned();
        name.push(".lock");
        Self::take(Path::new(&name), holder)
    }
}

/// Tries to take the lock for up to 2 s. If a service is killed while it starts a helper process,
/// the forked child inherits the lock and holds it until it executes the helper's program.
fn try_patiently(file: &File) -> Result<(), TryLockError> {
    for _ in 1..TRIES {
        match file.try_lock() {
            Err(TryLockError::WouldBlock) => std::thread::sleep(BETWEEN_TRIES),
            done => return done,
        }
    }
    file.try_lock()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lock_waits_briefly_for_a_dying_holder() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("data/lock");
        let first = FileLock::take(&file, "the first").unwrap();
        let dying = std::thread::spawn(move || {
            std::thread::sleep(BETWEEN_TRIES * 4);
            drop(first);
        });
        FileLock::take(&file, "the second").unwrap();
        dying.join().unwrap();
    }
}
