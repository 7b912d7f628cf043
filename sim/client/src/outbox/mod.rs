//! The outbox: recordings, and answers to surveys after them, stay in a folder until the service
//! confirms that they are stored. Failures of this program, the network or the service remove
//! nothing. Otherwise an entry is removed only if the user discards it, or the service answers that
//! it must not be kept.

mod deliver;
mod entry;
mod send;
mod sheet;
mod tus;

use std::fs::{self, File};
use std::io::{self, Read};
use std::path::{Path, PathBuf};

use data_encoding::HEXLOWER;
pub use entry::Entry;
pub use send::{Access, Delivery, Patience, Post};
use sha2::{Digest, Sha256};
pub use sheet::AnswerSheet;
use tempfile::Builder;

use crate::exit::Failure;
use crate::{folders, new_file};

/// File extension of recordings in the outbox.
const EXTENSION: &str = "mcap";
/// Hexadecimal digits of an entry's id: enough to avoid collisions between recordings.
const ID_DIGITS: usize = 16;

/// A folder of pending deliveries.
#[derive(Clone, Debug)]
pub struct Outbox {
    folder: PathBuf,
}

impl Outbox {
    /// Opens the outbox in a folder, by default the user's own, and creates the folder if it does
    /// not exist.
    ///
    /// # Errors
    /// If there is no home directory, or the folder cannot be created.
    pub fn open(folder: Option<&Path>) -> Result<Self, Failure> {
        let folder = match folder {
            Some(folder) => folder.to_owned(),
            None => folders::data()?.join("outbox"),
        };
        new_file::create_folder(&folder)?;
        Ok(Self { folder })
    }

    /// The folder.
    pub fn folder(&self) -> &Path {
        &self.folder
    }

    /// Adds a recording: as a hard link if the file system supports it, otherwise as a copy. The
    /// same bytes are stored once. `server` is the service to send it to; `None` stands for the one
    /// with which this station is paired.
    ///
    /// # Errors
    /// If the file cannot be read or added; the original is unchanged.
    pub fn keep(&self, recording: &Path, server: Option<&str>) -> Result<Entry, Failure> {
        let id = identify(recording).map_err(|error| Failure::refused(recording, error))?;
        let place = self.folder.join(format!("{id}.{EXTENSION}"));
        let name = recording.file_name().map_or_else(|| id.clone(), |name| name.to_string_lossy().into_owned());
        let kept = take_in(recording, &place, &self.folder).and_then(|()| Entry::kept(place, name, server));
        kept.map_err(|error| {
            Failure::work(format_args!(
                "{}: cannot be stored in the outbox {}: {error}; the file is left in place",
                recording.display(),
                self.folder.display()
            ))
        })
    }

    /// Adds a recording that this station has made. If the service answers that it must not be
    /// kept, both files are deleted.
    ///
    /// # Errors
    /// Those of [`Outbox::keep`], or if the note cannot be written.
    pub fn keep_own(&self, recording: &Path, server: &str) -> Result<Entry, Failure> {
        let mut entry = self.keep(recording, Some(server))?;
        let noted = entry.note_source(recording);
        noted.map_err(|error| Failure::work(format_args!("{}: {error}", self.folder.display())))?;
        Ok(entry)
    }

    /// Returns the pending entries, in the order in which they were added.
    ///
    /// # Errors
    /// If the folder cannot be read.
    pub fn entries(&self) -> Result<Vec<Entry>, Failure> {
        let read = || -> io::Result<Vec<Entry>> {
            let mut entries = Vec::new();
            for found in fs::read_dir(&self.folder)? {
                let place = found?.path();
                if place.extension().is_some_and(|found| found == EXTENSION || found == sheet::ANSWERS) {
                    entries.push(Entry::read(place)?);
                }
            }
            entries.sort_by(|a, b| (a.note.kept_at, &a.id).cmp(&(b.note.kept_at, &b.id)));
            Ok(entries)
        };
        read().map_err(|error| Failure::work(format_args!("{}: {error}", self.folder.display())))
    }

    /// Locks the outbox against other processes that send from it, until the returned file is
    /// dropped; waits for the lock.
    ///
    /// # Errors
    /// If the file cannot be opened or locked.
    fn alone(&self) -> Result<File, Failure> {
        let file = self.folder.join(".sending");
        let lock = || -> io::Result<File> {
            let lock = File::options().create(true).truncate(false).write(true).open(&file)?;
            lock.lock()?;
            Ok(lock)
        };
        lock().map_err(|error| Failure::work(format_args!("{}: {error}", file.display())))
    }
}

/// Computes an id from the bytes, so that the same recording is one entry under any file name.
fn identify(recording: &Path) -> io::Result<String> {
    let (mut file, mut hash, mut piece) = (File::open(recording)?, Sha256::new(), vec![0; 1 << 16]);
    loop {
        match file.read(&mut piece)? {
            0 => break,
            read => hash.update(&piece[..read]),
        }
    }
    let mut id = HEXLOWER.encode(&hash.finalize());
    id.truncate(ID_DIGITS);
    Ok(id)
}

/// Links or copies a file into the outbox, and syncs it.
fn take_in(recording: &Path, place: &Path, folder: &Path) -> io::Result<()> {
    if place.exists() {
        return Ok(());
    }
    // A hard link to a symbolic link would dangle once the link's target is deleted.
    let recording = fs::canonicalize(recording)?;
    if fs::hard_link(&recording, place).is_err() {
        let mut copy = Builder::new().prefix(".keeping-").tempfile_in(folder)?;
        io::copy(&mut File::open(&recording)?, copy.as_file_mut())?;
        new_file::persist(copy, place)?;
    } else {
        new_file::sync_file(place)?;
    }
    new_file::sync_folder(folder)
}
