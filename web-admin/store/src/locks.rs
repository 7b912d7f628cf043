//! A file that one process holds locked for as long as it needs everything to itself.
//!
//! The system lets go of the lock when the process ends, however it ends, so nothing is left to clean up.

use std::fs::{File, OpenOptions, TryLockError};
use std::io::{Read, Seek, Write};
use std::path::Path;
use std::time::Duration;

/// How often a lock that somebody holds is tried, ...
pub(crate) const TRIES: u32 = 40;
/// ... and how long between two tries: 2 s in all.
pub(crate) const BETWEEN_TRIES: Duration = Duration::from_millis(50);

/// Why the data are not to be had.
#[derive(Debug, thiserror::Error)]
pub enum LockError {
    /// Somebody else has them.
    #[error("{place}: {holder} has these data; stop it first, or name another folder")]
    Held {
        /// The file that is locked, or the database.
        place: String,
        /// Who holds it, in words.
        holder: String,
    },
    /// Nothing can be locked there.
    #[error("{place}: cannot be locked: {why}")]
    Unusable {
        /// The file, or the database.
        place: String,
        /// Why.
        why: Box<dyn std::error::Error + Send + Sync>,
    },
}

/// A file that this process holds locked until it is dropped.
#[derive(Debug)]
pub struct FileLock {
    _file: File,
}

impl FileLock {
    /// Locks a file, making it where it is missing, and writes into it who holds it. Waits 2 s for somebody else.
    ///
    /// # Errors
    /// When another process has it, or the file cannot be made.
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
                // Whoever holds it may be writing its name just now.
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

    /// Locks the file that stands for a database's file: beside it, with `.lock` behind its name.
    pub(crate) fn take_beside(database: &Path, holder: &str) -> Result<Self, LockError> {
        let mut name = database.as_os_str().to_owned();
        name.push(".lock");
        Self::take(Path::new(&name), holder)
    }
}

/// Tries for a while. A service that is killed just as it starts a helper leaves a child that holds the lock until it becomes the
/// helper's program, and is not there to be seen afterwards.
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
    fn a_lock_that_a_dying_process_holds_a_little_longer_is_waited_for() {
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
