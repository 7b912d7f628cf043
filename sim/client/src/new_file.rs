//! A file that gets its name only when it is complete.

use std::fs::{self, File};
use std::io;
use std::path::{Path, PathBuf};

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
        self.temporary.as_file().sync_all().map_err(|error| cannot(&error))?;
        let kept = match self.overwrite {
            true => self.temporary.persist(&self.target),
            false => self.temporary.persist_noclobber(&self.target),
        };
        kept.map(|_| ()).map_err(|refused| match refused.error.kind() {
            io::ErrorKind::AlreadyExists => exists(&self.target),
            _ => Failure::work(format_args!("{}: {}", self.target.display(), refused.error)),
        })
    }
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
