//! Who was erased, kept outside the database: a backup that is restored later knows nothing of it, and must not bring anybody back.
//!
//! One line of JSON for each erasure, on the disk before the database is changed, in a file of the data folder to which lines are only
//! added. It holds ids, pseudonyms and times, which tell nobody's name. An erasure that did not come about after all is taken back
//! by another line.

use std::fs::{DirBuilder, File, OpenOptions};
use std::io::{ErrorKind, Read, Seek, SeekFrom, Write};
use std::os::unix::fs::{DirBuilderExt, OpenOptionsExt};
use std::path::{Path, PathBuf};

use model::Moment;
use model::ids::{PersonId, SchoolId};
use serde::{Deserialize, Serialize};

use crate::config::Config;

/// The list's file in the data folder, and in a backup.
pub const ERASURES_FILE: &str = "erasures.jsonl";

/// An erasure.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Erasure {
    /// When.
    pub at: Moment,
    /// Of which school.
    pub school_id: SchoolId,
    /// Whose.
    pub person_id: PersonId,
    /// What recordings say instead of a name.
    pub pseudonym: String,
    /// What goes beside name, address and sign-in.
    #[serde(flatten)]
    pub wish: ErasureScope,
}

/// What goes beside name, address and sign-in.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(default)]
pub struct ErasureScope {
    /// Free texts that they wrote.
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

/// A list that cannot be read.
#[derive(Debug, thiserror::Error)]
#[error("{}{}: {why}", path.display(), line.map(|line| format!(", line {line}")).unwrap_or_default())]
pub struct UnreadableList {
    path: PathBuf,
    line: Option<usize>,
    why: String,
}

/// The list of erasures in a file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ErasureList {
    path: PathBuf,
}

impl ErasureList {
    /// That of a data folder.
    #[must_use]
    pub fn of(config: &Config) -> Self {
        Self::at(&config.data_dir.join(ERASURES_FILE))
    }

    /// That of a file.
    #[must_use]
    pub fn at(path: &Path) -> Self {
        Self { path: path.to_owned() }
    }

    /// Its bytes as they are; none where nobody was erased yet.
    ///
    /// # Errors
    /// When the file is there and cannot be read.
    pub fn bytes(&self) -> std::io::Result<Vec<u8>> {
        match std::fs::read(&self.path) {
            Err(error) if error.kind() == ErrorKind::NotFound => Ok(Vec::new()),
            read => read,
        }
    }

    /// The erasures that were not taken back, in the order of the file. A line that a power cut has left unfinished was never acted upon.
    ///
    /// # Errors
    /// When the file cannot be read, or a line of it is none of ours.
    pub fn read(&self) -> Result<Vec<Erasure>, UnreadableList> {
        match self.bytes() {
            Ok(bytes) => read_lines(&self.path, bytes),
            Err(error) => Err(UnreadableList { path: self.path.clone(), line: None, why: error.to_string() }),
        }
    }

    /// Adds an erasure, which is on the disk when this returns.
    ///
    /// # Errors
    /// When the disk refuses.
    pub fn add(&self, erasure: &Erasure) -> std::io::Result<()> {
        self.append(&ErasureLine::Erased(erasure.clone()))
    }

    /// Notes that an erasure did not come about.
    ///
    /// # Errors
    /// When the disk refuses.
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
        // What a power cut has left of a line.
        let end = kept.iter().rposition(|&byte| byte == b'\n').map_or(0, |last| last + 1);
        file.set_len(end as u64)?;
        file.seek(SeekFrom::Start(end as u64))?;
        file.write_all(text_of(line)?.as_bytes())?;
        file.sync_all()?;
        File::open(folder)?.sync_all()
    }
}

/// The erasures of the lines of a file or an object that were not taken back; `path` is named where it is none of ours. A line without its
/// end is none.
///
/// # Errors
/// When a line is none of ours.
pub fn read_lines(path: &Path, bytes: Vec<u8>) -> Result<Vec<Erasure>, UnreadableList> {
    let refused = |line, why: String| UnreadableList { path: path.to_owned(), line, why };
    let text = String::from_utf8(bytes).map_err(|_| refused(None, "is no text; a list of erasures is".to_owned()))?;
    let whole = text.rfind('\n').map_or("", |end| &text[..end]);
    let mut standing: Vec<Erasure> = Vec::new();
    for (place, line) in whole.lines().enumerate().filter(|(_, line)| !line.trim().is_empty()) {
        let words = |error| format!("not a line of a list of erasures, as web-admin writes them: {error}");
        match serde_json::from_str(line).map_err(|error| refused(Some(place + 1), words(error)))? {
            ErasureLine::Erased(erasure) => standing.push(erasure),
            ErasureLine::TakenBack(erasure) => standing.retain(|other| *other != erasure),
        }
    }
    Ok(standing)
}

/// The lines of a file with these erasures.
///
/// # Errors
/// When one cannot be written as JSON.
pub fn lines_of(erasures: &[Erasure]) -> std::io::Result<String> {
    erasures.iter().map(|erasure| text_of(&ErasureLine::Erased(erasure.clone()))).collect()
}

fn text_of(line: &ErasureLine) -> std::io::Result<String> {
    Ok(serde_json::to_string(line)? + "\n")
}

#[cfg(test)]
mod tests {
    //! An erasure that a power cut takes out of the list comes back with the next backup.

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
    fn a_line_that_was_cut_short_is_none_and_what_is_foreign_is_named_with_its_place() {
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
