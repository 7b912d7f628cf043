//! List of erased people, kept outside the database: restoring an older backup must not bring them
//! back.
//!
//! An append-only file in the data folder with one JSON line per erasure, synced before the
//! database is changed. It holds ids, pseudonyms and times, but no names. An erasure that failed is
//! taken back by another line.

use std::fs::{DirBuilder, File, OpenOptions};
use std::io::{ErrorKind, Read, Seek, SeekFrom, Write};
use std::os::unix::fs::{DirBuilderExt, OpenOptionsExt};
use std::path::{Path, PathBuf};

use model::Moment;
use model::ids::{PersonId, SchoolId};
use platform::config::Config;
use serde::{Deserialize, Serialize};

/// File name of the list in the data folder and in a backup.
pub const ERASURES_FILE: &str = "erasures.jsonl";

/// An erasure.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Erasure {
    /// Time of the erasure.
    pub at: Moment,
    /// School of the person.
    pub school_id: SchoolId,
    /// The erased person.
    pub person_id: PersonId,
    /// Pseudonym that replaces their name in recordings.
    pub pseudonym: String,
    /// Data removed in addition to name, address and credentials.
    #[serde(flatten)]
    pub wish: ErasureScope,
}

/// Data removed in addition to name, address and credentials.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(default)]
pub struct ErasureScope {
    /// Free texts that the person wrote.
    pub written: bool,
    /// Free texts that others wrote about their attempts.
    pub about: bool,
    /// Their recordings.
    pub recordings: bool,
}

/// A line of the file.
#[derive(Serialize, Deserialize)]
#[serde(tag = "act", rename_all = "snake_case")]
enum ErasureLine {
    Erased(Erasure),
    TakenBack(Erasure),
}

/// An erasure list that cannot be read.
#[derive(Debug, thiserror::Error)]
#[error("{}{}: {why}", path.display(), line.map(|line| format!(", line {line}")).unwrap_or_default())]
pub struct UnreadableList {
    path: PathBuf,
    line: Option<usize>,
    why: String,
}

/// An erasure list in a file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ErasureList {
    path: PathBuf,
}

impl ErasureList {
    /// Returns the list of a data folder.
    #[must_use]
    pub fn of(config: &Config) -> Self {
        Self::at(&config.data_dir.join(ERASURES_FILE))
    }

    /// Returns the list at `path`.
    #[must_use]
    pub fn at(path: &Path) -> Self {
        Self { path: path.to_owned() }
    }

    /// Returns the raw bytes of the file; empty if it does not exist yet.
    ///
    /// # Errors
    /// Fails if the file exists but cannot be read.
    pub fn bytes(&self) -> std::io::Result<Vec<u8>> {
        match std::fs::read(&self.path) {
            Err(error) if error.kind() == ErrorKind::NotFound => Ok(Vec::new()),
            read => read,
        }
    }

    /// Returns the erasures that were not taken back, in file order. A line without its end, left
    /// by a power cut, is ignored: its erasure was never carried out.
    ///
    /// # Errors
    /// Fails if the file cannot be read, or one of its lines has an unknown format.
    pub fn read(&self) -> Result<Vec<Erasure>, UnreadableList> {
        match self.bytes() {
            Ok(bytes) => read_lines(&self.path, bytes),
            Err(error) => Err(UnreadableList { path: self.path.clone(), line: None, why: error.to_string() }),
        }
    }

    /// Adds an erasure and syncs the file.
    ///
    /// # Errors
    /// Fails if the file cannot be written.
    pub fn add(&self, erasure: &Erasure) -> std::io::Result<()> {
        self.append(&ErasureLine::Erased(erasure.clone()))
    }

    /// Takes an erasure back that was not carried out.
    ///
    /// # Errors
    /// Fails if the file cannot be written.
    pub fn take_back(&self, erasure: &Erasure) -> std::io::Result<()> {
        self.append(&ErasureLine::TakenBack(erasure.clone()))
    }

    fn append(&self, line: &ErasureLine) -> std::io::Result<()> {
        let folder = self.path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
        DirBuilder::new().recursive(true).mode(0o700).create(folder)?;
        let mut options = OpenOptions::new();
        let mut file = options.read(true).write(true).create(true).truncate(false).mode(0o600).open(&self.path)?;
        file.lock()?;
        let mut kept = Vec::new();
        file.read_to_end(&mut kept)?;
        // Cut off an incomplete line left by a power cut.
        let end = kept.iter().rposition(|&byte| byte == b'\n').map_or(0, |last| last + 1);
        file.set_len(end as u64)?;
        file.seek(SeekFrom::Start(end as u64))?;
        file.write_all(text_of(line)?.as_bytes())?;
        file.sync_all()?;
        File::open(folder)?.sync_all()
    }
}

/// Parses the lines of a file or an object and returns the erasures that were not taken back.
/// `path` is used in error messages only. An incomplete last line is ignored.
///
/// # Errors
/// Fails if a line has an unknown format.
pub fn read_lines(path: &Path, bytes: Vec<u8>) -> Result<Vec<Erasure>, UnreadableList> {
    let refused = |line, why: String| UnreadableList { path: path.to_owned(), line, why };
    let text = String::from_utf8(bytes)
        .map_err(|_| refused(None, "not UTF-8 text, as a list of erasures must be".to_owned()))?;
    let whole = text.rfind('\n').map_or("", |end| &text[..end]);
    let mut standing: Vec<Erasure> = Vec::new();
    for (place, line) in whole.lines().enumerate().filter(|(_, line)| !line.trim().is_empty()) {
        let words = |error| format!("not a line of a list of erasures written by web-admin: {error}");
        match serde_json::from_str(line).map_err(|error| refused(Some(place + 1), words(error)))? {
            ErasureLine::Erased(erasure) => standing.push(erasure),
            ErasureLine::TakenBack(erasure) => standing.retain(|other| *other != erasure),
        }
    }
    Ok(standing)
}

/// Returns the lines of a file with these erasures.
///
/// # Errors
/// Fails if one cannot be written as JSON.
pub fn lines_of(erasures: &[Erasure]) -> std::io::Result<String> {
    erasures.iter().map(|erasure| text_of(&ErasureLine::Erased(erasure.clone()))).collect()
}

fn text_of(line: &ErasureLine) -> std::io::Result<String> {
    Ok(serde_json::to_string(line)? + "\n")
}

#[cfg(test)]
mod tests {
    //! An erasure lost from the list by a power cut would be undone by restoring a backup.

    use super::*;

    fn erasure(person: u128) -> Erasure {
        Erasure {
            at: Moment::from_micros(1_795_269_600_123_456),
            school_id: SchoolId::from_u128(1),
            person_id: PersonId::from_u128(person),
            pseudonym: format!("p-{person}"),
            wish: ErasureScope { about: true, ..ErasureScope::default() },
        }
    }

    #[test]
    fn what_was_added_is_read_and_what_was_taken_back_is_not() {
        let folder = tempfile::tempdir().unwrap();
        let list = ErasureList::at(&folder.path().join("new/erasures.jsonl"));
        assert_eq!(list.read().unwrap(), []);
        for person in [2, 3] {
            list.add(&erasure(person)).unwrap();
        }
        list.take_back(&erasure(2)).unwrap();
        assert_eq!(list.read().unwrap(), [erasure(3)]);
        let mode = std::os::unix::fs::PermissionsExt::mode(&std::fs::metadata(&list.path).unwrap().permissions());
        assert_eq!(mode & 0o777, 0o600);
    }

    #[test]
    fn truncated_line_is_ignored_and_a_foreign_one_is_located() {
        let folder = tempfile::tempdir().unwrap();
        let list = ErasureList::at(&folder.path().join("erasures.jsonl"));
        list.add(&erasure(2)).unwrap();
        let whole = list.bytes().unwrap();
        list.add(&erasure(3)).unwrap();
        let both = list.bytes().unwrap();
        for cut in whole.len()..both.len() {
            std::fs::write(&list.path, &both[..cut]).unwrap();
            assert_eq!(list.read().unwrap(), [erasure(2)], "cut after {cut} bytes");
            list.add(&erasure(4)).unwrap();
            assert_eq!(list.read().unwrap(), [erasure(2), erasure(4)], "cut after {cut} bytes");
        }
        std::fs::write(&list.path, [&whole[..], b"Ana Ek, 3 March\n"].concat()).unwrap();
        let refused = list.read().unwrap_err().to_string();
        assert!(refused.contains("erasures.jsonl, line 2: not a line"), "{refused}");
    }
}
