//! A file that gets its name only when it is complete, and names that survive a power failure.

use std::fs::{self, File};
use std::io;
use std::path::{Path, PathBuf};
use std::thread;
use std::time::Duration;

use tempfile::{Builder, NamedTempFile};

use crate::exit::{Failure, Outcome};

/// A file being written under a temporary name in the folder of its final one; it is deleted if it
/// is dropped unfinished.
pub struct NewFile {
    temporary: NamedTempFile,
    target: PathBuf,
    overwrite: bool,
}

impl NewFile {
    /// Creates a temporary file for `target`.
    ///
    /// # Errors
    /// If `target` exists and `overwrite` is not set, or its folder cannot be written to.
    pub fn create(target: &Path, overwrite: bool) -> Result<Self, Failure> {
        if target.is_dir() {
            return Err(Failure::refused(target, "is a folder; allowed: a file name"));
        }
        if target.exists() && !overwrite {
            return Err(exists(target));
        }
        let temporary = builder()
            .tempfile_in(folder_of(target))
            .map_err(|error| Failure::refused(target, format_args!("cannot be created: {error}")))?;
        Ok(Self { temporary, target: target.to_owned(), overwrite })
    }

    /// The file to write to.
    pub fn file(&mut self) -> &mut File {
        self.temporary.as_file_mut()
    }

    /// Syncs the file and renames it to its final name.
    ///
    /// # Errors
    /// If writing fails, or another file has taken the name meanwhile and must not be overwritten.
    pub fn keep(self) -> Outcome {
        let cannot = |error: &io::Error| Failure::work(format_args!("{}: {error}", self.target.display()));
        if self.overwrite {
            return persist(self.temporary, &self.target).map_err(|error| cannot(&error));
        }
        self.temporary.as_file().sync_all().map_err(|error| cannot(&error))?;
        self.temporary.persist_noclobber(&self.target).map(|_| ()).map_err(|refused| match refused.error.kind() {
            io::ErrorKind::AlreadyExists => exists(&self.target),
            _ => cannot(&refused.error),
        })
    }
}

/// Syncs a temporary file and gives it a name in its folder, in place of an earlier file of that name.
///
/// # Errors
/// If it cannot be synced or renamed; then it is deleted, and the earlier file is unchanged.
pub fn persist(temporary: NamedTempFile, target: &Path) -> io::Result<()> {
    temporary.as_file().sync_all()?;
    // Windows refuses to replace a file that another process has open just then, for example a virus scanner.
    let (mut left, mut temporary) = (if cfg!(windows) { RENAMES } else { 1 }, temporary);
    loop {
        left -= 1;
        match temporary.persist(target) {
            Ok(_) => return Ok(()),
            Err(refused) if left > 0 && refused.error.kind() == io::ErrorKind::PermissionDenied => {
                thread::sleep(RENAME_WAIT);
                temporary = refused.file;
            }
            Err(refused) => return Err(refused.error),
        }
    }
}

/// Tries of a rename on Windows, and the time between them: half a second.
const RENAMES: u32 = 25;
const RENAME_WAIT: Duration = Duration::from_millis(20);

/// Syncs a file that another program may have written.
///
/// # Errors
/// If it cannot be opened or synced.
pub fn sync_file(path: &Path) -> io::Result<()> {
    // Windows syncs only what may be written to.
    match File::options().read(true).write(cfg!(windows)).open(path) {
        // A read-only file was complete before.
        Err(error) if cfg!(windows) && error.kind() == io::ErrorKind::PermissionDenied => Ok(()),
        opened => opened?.sync_all(),
    }
}

/// Syncs the names in a folder.
///
/// # Errors
/// If the folder cannot be opened or synced.
#[cfg(not(windows))]
pub fn sync_folder(folder: &Path) -> io::Result<()> {
    File::open(folder)?.sync_all()
}

/// Syncs the names in a folder, if its file system supports it: NTFS does, and writes them to its
/// journal in order.
///
/// # Errors
/// None.
#[cfg(windows)]
pub fn sync_folder(folder: &Path) -> io::Result<()> {
    use std::os::windows::fs::OpenOptionsExt;
    /// Opens a folder as a file.
    const FILE_FLAG_BACKUP_SEMANTICS: u32 = 0x0200_0000;
    let opened = File::options().write(true).custom_flags(FILE_FLAG_BACKUP_SEMANTICS).open(folder);
    // Network and FAT file systems refuse; the files themselves have been synced.
    let _ = opened.and_then(|folder| folder.sync_all());
    Ok(())
}

/// Creates a folder and its parents.
///
/// # Errors
/// If a folder cannot be created.
pub fn create_folder(folder: &Path) -> Outcome {
    fs::create_dir_all(folder).map_err(|error| Failure::refused(folder, format_args!("cannot be created: {error}")))
}

fn exists(target: &Path) -> Failure {
    Failure::refused(target, "exists already; choose another name or pass --force to replace it")
}

fn folder_of(target: &Path) -> &Path {
    match target.parent() {
        Some(folder) if !folder.as_os_str().is_empty() => folder,
        _ => Path::new("."),
    }
}

/// Other programs read recordings too: unlike most temporary files they get the permissions of
/// ordinary new files.
fn builder() -> Builder<'static, 'static> {
    let mut builder = Builder::new();
    builder.prefix(".stylet-").suffix(".part");
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt;
        builder.permissions(fs::Permissions::from_mode(0o666));
    }
    builder
}
