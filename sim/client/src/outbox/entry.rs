//! One entry of the outbox: a recording or answers, and a note next to the file with its state.

use std::fs;
use std::io::{self, ErrorKind, Write};
use std::path::{Path, PathBuf};
use std::time::Duration;

use serde::{Deserialize, Serialize};
use tempfile::Builder;
use time::OffsetDateTime;

use super::{identify, sheet};
use crate::service::{Outlook, Trouble};
use crate::{clock, new_file};

/// Wait after the first failure; doubled after each further one.
const FIRST_WAIT: Duration = Duration::from_secs(5);
/// Longest wait between two tries.
const LONGEST_WAIT: Duration = Duration::from_secs(15 * 60);

/// The state of a pending entry.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Note {
    /// Original name of the file.
    pub name: String,
    /// Path of the original recording of this station, which may still exist.
    #[serde(default)]
    pub source: Option<PathBuf>,
    /// Time at which it was added.
    #[serde(with = "time::serde::rfc3339")]
    pub kept_at: OffsetDateTime,
    /// Address of the service; `None` for the one with which this station is paired.
    pub server: Option<String>,
    /// Id of the upload that was started there.
    pub upload: Option<String>,
    /// Number of tries.
    pub tries: u32,
    /// The last error.
    pub last_error: Option<String>,
    /// Whether the service has rejected it permanently.
    pub refused: bool,
    /// Time of the next try.
    #[serde(with = "time::serde::rfc3339::option")]
    pub next_try_at: Option<OffsetDateTime>,
}

/// A pending recording, or pending answers to a survey.
#[derive(Clone, Debug)]
pub struct Entry {
    /// Id in the outbox.
    pub id: String,
    /// The recording, or the answers.
    pub file: PathBuf,
    /// Size of the file, in bytes.
    pub bytes: u64,
    /// State of the delivery.
    pub note: Note,
}

impl Entry {
    /// Returns the entry of a file that was just added, or had been added before. Another `server`
    /// than the noted one resets upload, rejection and retry time.
    pub(super) fn kept(file: PathBuf, name: String, server: Option<&str>) -> io::Result<Self> {
        let mut entry = Self::read(file)?;
        let server = server.map(|server| server.trim_end_matches('/').to_owned());
        if server.is_some() && server != entry.note.server {
            entry.note = Note { server, upload: None, refused: false, next_try_at: None, ..entry.note };
        }
        entry.note.name = name;
        entry.save()?;
        Ok(entry)
    }

    /// Reads an entry. If the note is missing or damaged, the file is still pending, with a new
    /// note.
    pub(super) fn read(file: PathBuf) -> io::Result<Self> {
        let id = file.file_stem().map_or_else(String::new, |stem| stem.to_string_lossy().into_owned());
        let bytes = file.metadata()?.len();
        let note = fs::read(note_of(&file)).ok().and_then(|text| serde_json::from_slice(&text).ok());
        let blank = || Note {
            name: file.file_name().map_or_else(String::new, |name| name.to_string_lossy().into_owned()),
            source: None,
            kept_at: clock::now(),
            server: None,
            upload: None,
            tries: 0,
            last_error: None,
            refused: false,
            next_try_at: None,
        };
        Ok(Self { id, bytes, note: note.unwrap_or_else(blank), file })
    }

    /// Whether this contains answers, not a recording.
    pub(super) fn is_answers(&self) -> bool {
        self.file.extension().is_some_and(|extension| extension == sheet::ANSWERS)
    }

    /// Whether it is to be tried at a time.
    pub fn is_due(&self, now: OffsetDateTime) -> bool {
        !self.note.refused && self.note.next_try_at.is_none_or(|at| at <= now)
    }

    /// Notes the upload that was started, so that a later try resumes it.
    pub(super) fn began(&mut self, upload: String) -> io::Result<()> {
        self.note.upload = Some(upload);
        self.save()
    }

    /// Notes the error of a try and schedules the next one.
    pub(super) fn failed(&mut self, trouble: &Trouble) -> io::Result<()> {
        let note = &mut self.note;
        note.tries = note.tries.saturating_add(1);
        note.last_error = Some(trouble.detail.clone());
        note.refused = trouble.outlook == Outlook::Never;
        // The shift is bounded, so that it does not overflow after many tries.
        let wait = FIRST_WAIT.saturating_mul(1 << (note.tries - 1).min(16)).min(LONGEST_WAIT);
        note.next_try_at = (!note.refused).then(|| clock::now() + wait);
        self.save()
    }

    /// Deletes the entry: it was delivered, or its owner discards it.
    ///
    /// # Errors
    /// If a file cannot be deleted.
    pub fn remove(&self) -> io::Result<()> {
        // The recording first: a note without a recording is ignored, a recording without a note is
        // sent.
        for file in [self.file.clone(), note_of(&self.file)] {
            match fs::remove_file(file) {
                Err(error) if error.kind() != ErrorKind::NotFound => return Err(error),
                _ => {}
            }
        }
        Ok(())
    }

    /// Deletes the entry, and the original file if it still contains the same bytes.
    ///
    /// # Errors
    /// If a file cannot be deleted.
    pub(super) fn remove_everywhere(&self) -> io::Result<()> {
        if let Some(source) = &self.note.source {
            match identify(source) {
                Ok(id) if id == self.id => fs::remove_file(source)?,
                // The original was moved or overwritten: a file at its path is another one.
                _ => {}
            }
        }
        self.remove()
    }

    /// Stores the path of the original file.
    pub(super) fn note_source(&mut self, source: &Path) -> io::Result<()> {
        self.note.source = Some(std::path::absolute(source)?);
        self.save()
    }

    fn save(&self) -> io::Result<()> {
        let folder = self.file.parent().unwrap_or(Path::new("."));
        let mut new = Builder::new().prefix(".note-").tempfile_in(folder)?;
        new.write_all(serde_json::to_string_pretty(&self.note)?.as_bytes())?;
        new_file::persist(new, &note_of(&self.file))
    }
}

fn note_of(file: &Path) -> PathBuf {
    file.with_extension("json")
}
