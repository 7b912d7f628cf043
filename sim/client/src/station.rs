//! This machine as a training station: the school it has joined, and the token it was given.

use std::fs;
use std::io::{ErrorKind, Write};
use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};
use tempfile::Builder;

use crate::exit::{Failure, Outcome};
use crate::folders;

/// The school that this station has joined.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Pairing {
    /// Address of the service, without a slash at its end.
    pub server: String,
    /// The school's name.
    pub school: String,
    /// What the station is called there.
    pub name: String,
    /// The bearer token. Never printed.
    pub token: String,
}

/// Where it is kept.
///
/// # Errors
/// When the environment names no home.
pub fn file() -> Result<PathBuf, Failure> {
    Ok(folders::config()?.join("station.json"))
}

impl Pairing {
    /// The pairing of this machine, if it has one.
    ///
    /// # Errors
    /// When it is there and cannot be read.
    pub fn load() -> Result<Option<Self>, Failure> {
        let file = file()?;
        let refused = |why: String| Failure::refused(&file, format_args!("{why}; pair this station again"));
        match fs::read(&file) {
            Ok(bytes) => serde_json::from_slice(&bytes).map(Some).map_err(|error| refused(error.to_string())),
            Err(error) if error.kind() == ErrorKind::NotFound => Ok(None),
            Err(error) => Err(refused(error.to_string())),
        }
    }

    /// Keeps it in place of an earlier one, readable by this user alone.
    ///
    /// # Errors
    /// When the disk refuses.
    pub fn save(&self) -> Outcome {
        let file = file()?;
        self.write(&file).map_err(|error| Failure::work(format_args!("{}: {error}", file.display())))
    }

    fn write(&self, file: &Path) -> std::io::Result<()> {
        let folder = file.parent().unwrap_or(Path::new("."));
        fs::create_dir_all(folder)?;
        // A temporary file is made with permissions for its owner alone, and keeps them under its new name.
        let mut new = Builder::new().prefix(".station-").tempfile_in(folder)?;
        new.write_all(serde_json::to_string_pretty(self)?.as_bytes())?;
        new.as_file().sync_all()?;
        new.persist(file)?;
        Ok(())
    }
}
