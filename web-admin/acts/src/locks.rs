//! Who has the data: a file that one process holds locked for as long as it needs everything to itself.
//!
//! The system lets go of the lock when the process ends, however it ends, so nothing is left to clean up.

use std::fs::{File, OpenOptions, TryLockError};
use std::io::{Read, Seek, Write};
use std::path::{Path, PathBuf};
use std::time::Duration;

use model::Moment;
use store::Database;

use crate::config::Config;

/// How often a lock that somebody holds is tried, ...
const TRIES: u32 = 40;
/// ... and how long between two tries: 2 s in all.
const BETWEEN_TRIES: Duration = Duration::from_millis(50);

/// Database and recordings, held by this process until it is dropped.
#[derive(Debug)]
pub struct DataLock {
    _files: Vec<File>,
}

/// Why the data are not to be had.
#[derive(Debug, thiserror::Error)]
pub enum LockError {
    /// Somebody else has them.
    #[error("{}: {holder} has these data; stop it first, or name another folder", path.display())]
    Held {
        /// The file that is locked.
        path: PathBuf,
        /// Who holds it, in words.
        holder: String,
    },
    /// The file cannot be locked.
    #[error("{}: cannot be locked: {why}", path.display())]
    Unusable {
        /// The file.
        path: PathBuf,
        /// Why.
        why: std::io::Error,
    },
}

impl DataLock {
    /// Takes database and recordings, wherever each lies; `purpose` tells others what for.
    ///
    /// # Errors
    /// When another process has one of them, or a file cannot be made.
    pub fn take(config: &Config, purpose: &str, now: Moment) -> anyhow::Result<Self> {
        let database = Database::file_of(&config.database_url)?;
        let places = [beside(&database), config.recordings_dir.with_extension("lock")];
        let holder = format!("{purpose} (process {}, since {now})", std::process::id());
        let files = places.iter().map(|path| lock(path, &holder)).collect::<Result<_, _>>()?;
        Ok(Self { _files: files })
    }
}

fn beside(database: &Path) -> PathBuf {
    let mut name = database.as_os_str().to_owned();
    name.push(".lock");
    PathBuf::from(name)
}

/// Locks a file, making it where it is missing, and writes into it who holds it.
fn lock(path: &Path, holder: &str) -> Result<File, LockError> {
    let unusable = |why| LockError::Unusable { path: path.to_owned(), why };
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
            return Err(LockError::Held { path: path.to_owned(), holder });
        }
        Err(TryLockError::Error(why)) => return Err(unusable(why)),
    }
    let mut write = || {
        file.set_len(0)?;
        file.rewind()?;
        file.write_all(holder.as_bytes())
    };
    write().map_err(unusable)?;
    Ok(file)
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
    //! Two services on one folder score everything twice and destroy each other's uploads.

    use super::*;

    #[test]
    fn who_comes_second_is_told_who_was_first_and_gets_it_when_they_have_gone() {
        let folder = tempfile::tempdir().unwrap();
        let config = Config::in_folder(&folder.path().join("data"));
        let now = Moment::from_micros(0);
        let first = DataLock::take(&config, "web-admin serve", now).unwrap();
        let refused = DataLock::take(&config, "web-admin restore", now).unwrap_err().to_string();
        let us = std::process::id().to_string();
        assert!(refused.contains("web-admin serve") && refused.contains(&us), "{refused}");
        drop(first);
        DataLock::take(&config, "web-admin restore", now).unwrap();
    }

    #[test]
    fn a_lock_that_a_dying_process_holds_a_little_longer_is_waited_for() {
        let folder = tempfile::tempdir().unwrap();
        let config = Config::in_folder(folder.path());
        let first = DataLock::take(&config, "web-admin serve", Moment::from_micros(0)).unwrap();
        let dying = std::thread::spawn(move || {
            std::thread::sleep(BETWEEN_TRIES * 4);
            drop(first);
        });
        DataLock::take(&config, "web-admin serve", Moment::from_micros(0)).unwrap();
        dying.join().unwrap();
    }

    #[test]
    fn the_same_recordings_beside_another_database_are_not_to_be_had() {
        let folder = tempfile::tempdir().unwrap();
        let config = Config::in_folder(folder.path());
        let other = Config { database_url: format!("sqlite://{}/other.db", folder.path().display()), ..config.clone() };
        let _first = DataLock::take(&config, "web-admin serve", Moment::from_micros(0)).unwrap();
        assert!(DataLock::take(&other, "web-admin serve", Moment::from_micros(0)).is_err());
    }
}
