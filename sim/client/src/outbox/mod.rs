//! The outbox: attempts, and answers to surveys after them, are kept in a folder until the service has said that they are on
//! its disk. Nothing is taken out of it otherwise, whatever happens to this program, the network or the service.

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
use crate::folders;

/// What recordings in the outbox end in.
const EXTENSION: &str = "mcap";
/// Hexadecimal digits of an entry's id: enough that two recordings never share one.
const ID_DIGITS: usize = 16;

/// A folder of attempts that wait.
#[derive(Clone, Debug)]
pub struct Outbox {
    folder: PathBuf,
}

impl Outbox {
    /// Opens the outbox in a folder, by default this user's, and makes the folder where it is missing.
    ///
    /// # Errors
    /// When there is no home to look in, or the folder cannot be made.
    pub fn open(folder: Option<&Path>) -> Result<Self, Failure> {
        let folder = match folder {
            Some(folder) => folder.to_owned(),
            None => folders::data()?.join("outbox"),
        };
        crate::new_file::create_folder(&folder)?;
        Ok(Self { folder })
    }

    /// The folder.
    pub fn folder(&self) -> &Path {
        &self.folder
    }

    /// Keeps a recording: by a second name for the same bytes where the file system can, else by a copy. The same bytes
    /// are kept once. `server` is where they are to go; where absent, to whichever service this station is paired with.
    ///
    /// # Errors
    /// When the file cannot be read, or the disk refuses: then the file is where it was, and nothing else.
    pub fn keep(&self, recording: &Path, server: Option<&str>) -> Result<Entry, Failure> {
        let id = identify(recording).map_err(|error| Failure::refused(recording, error))?;
        let place = self.folder.join(format!("{id}.{EXTENSION}"));
        let name = recording.file_name().map_or_else(|| id.clone(), |name| name.to_string_lossy().into_owned());
        let kept = take_in(recording, &place, &self.folder).and_then(|()| Entry::kept(place, name, server));
        kept.map_err(|error| {
            Failure::work(format_args!(
                "{}: cannot be kept in the outbox {}: {error}; it stays where it is",
                recording.display(),
                self.folder.display()
            ))
        })
    }

    /// Keeps a recording that this station has made. If the service answers that it must not be kept, both files are deleted.
    ///
    /// # Errors
    /// As those of [`Outbox::keep`].
    pub fn keep_own(&self, recording: &Path, server: &str) -> Result<Entry, Failure> {
        let mut entry = self.keep(recording, Some(server))?;
        let noted = entry.note_source(recording);
        noted.map_err(|error| Failure::work(format_args!("{}: {error}", self.folder.display())))?;
        Ok(entry)
    }

    /// What waits, in the order in which it was kept.
    ///
    /// # Errors
    /// When the folder cannot be read.
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

    /// Waits until no other program sends from this outbox, and keeps others from it until the answer is dropped.
    ///
    /// # Errors
    /// When the disk refuses.
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

/// An id made of the bytes, so that the same recording is the same entry whatever it is called.
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

/// Brings the bytes into the outbox and puts them on the disk.
fn take_in(recording: &Path, place: &Path, folder: &Path) -> io::Result<()> {
    if place.exists() {
        return Ok(());
    }
    // A link to a link would lead nowhere once the first is gone.
    let recording = fs::canonicalize(recording)?;
    if fs::hard_link(&recording, place).is_err() {
        let mut copy = Builder::new().prefix(".keeping-").tempfile_in(folder)?;
        io::copy(&mut File::open(&recording)?, copy.as_file_mut())?;
        copy.as_file().sync_all()?;
        copy.persist(place)?;
    } else {
        File::open(place)?.sync_all()?;
    }
    sync_folder(folder)
}

/// Makes the names in a folder last, where the system has a way to.
fn sync_folder(folder: &Path) -> io::Result<()> {
    if cfg!(unix) { File::open(folder)?.sync_all() } else { Ok(()) }
}
