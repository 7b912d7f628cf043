//! The files of a body.

use std::io::Write;
use std::path::{Path, PathBuf};

use crate::exit::{Failure, Outcome};
use crate::new_file::{self, NewFile};

/// A folder whose files get their names together.
pub struct Folder {
    path: PathBuf,
    force: bool,
    files: Vec<NewFile>,
}

impl Folder {
    /// Makes it if need be. With `force`, files in it are replaced.
    pub fn create(path: &Path, force: bool) -> Result<Self, Failure> {
        new_file::create_folder(path)?;
        Ok(Self { path: path.to_owned(), force, files: Vec::new() })
    }

    /// Writes a file that is not there before [`Folder::keep`].
    pub fn write(&mut self, name: &str, bytes: &[u8]) -> Outcome {
        let path = self.path.join(name);
        let mut file = NewFile::create(&path, self.force)?;
        let written = file.file().write_all(bytes);
        written.map_err(|error| Failure::work(format_args!("{}: {error}", path.display())))?;
        self.files.push(file);
        Ok(())
    }

    /// Gives all files their names.
    pub fn keep(self) -> Outcome {
        self.files.into_iter().try_for_each(NewFile::keep)
    }
}

/// A name as part of a file's name.
pub fn plain(name: &str) -> String {
    let plain: String =
        name.chars().map(|c| if c.is_ascii_alphanumeric() { c.to_ascii_lowercase() } else { '-' }).collect();
    plain.trim_matches('-').to_owned()
}
