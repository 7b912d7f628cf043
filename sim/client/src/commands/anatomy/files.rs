//! The files of a body.

use std::io::Write;
use std::path::{Path, PathBuf};

use crate::exit::{Failure, Outcome};
use crate::new_file::{self, NewFile};

/// A folder whose files are renamed into place together.
pub struct Folder {
    path: PathBuf,
    force: bool,
    files: Vec<NewFile>,
}

impl Folder {
    /// Creates the folder if it does not exist. With `force`, files in it are replaced.
    pub fn create(path: &Path, force: bool) -> Result<Self, Failure> {
        new_file::create_folder(path)?;
        Ok(Self { path: path.to_owned(), force, files: Vec::new() })
    }

    /// Writes a temporary file, which [`Folder::keep`] renames.
    pub fn write(&mut self, name: &str, bytes: &[u8]) -> Outcome {
        let path = self.path.join(name);
        let mut file = NewFile::create(&path, self.force)?;
        let written = file.file().write_all(bytes);
        written.map_err(|error| Failure::work(format_args!("{}: {error}", path.display())))?;
        self.files.push(file);
        Ok(())
    }

    /// Renames all files into place.
    pub fn keep(self) -> Outcome {
        self.files.into_iter().try_for_each(NewFile::keep)
    }
}

/// Converts a name for use in a file name.
pub fn plain(name: &str) -> String {
    let plain: String =
        name.chars().map(|c| if c.is_ascii_alphanumeric() { c.to_ascii_lowercase() } else { '-' }).collect();
    plain.trim_matches('-').to_owned()
}
