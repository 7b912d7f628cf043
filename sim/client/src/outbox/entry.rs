//! One attempt in the outbox: the recording, and a note beside it of what has become of it so far.

use std::fs;
use std::io::{self, ErrorKind, Write};
use std::path::{Path, PathBuf};
use std::time::Duration;

use serde::{Deserialize, Serialize};
use tempfile::Builder;
use time::OffsetDateTime;

use super::{identify, sheet};
use crate::clock;
use crate::service::{Outlook, Trouble};

/// Wait after the first failure; it doubles with each.
const FIRST_WAIT: Duration = Duration::from_secs(5);
/// Longest wait between two tries.
const LONGEST_WAIT: Duration = Duration::from_secs(15 * 60);

/// What is known of an attempt that waits.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Note {
    /// What the file was called.
    pub name: String,
    /// Where this station has recorded it, and it may lie still.
    #[serde(default)]
    pub source: Option<PathBuf>,
    /// Since when it waits.
    #[serde(with = "time::serde::rfc3339")]
    pub kept_at: OffsetDateTime,
    /// Where it is to go; where absent, to whichever service this station is paired with.
    pub server: Option<String>,
    /// The upload that has been begun there.
    pub upload: Option<String>,
    /// How often it was tried.
    pub tries: u32,
    /// The last reason why it was not delivered.
    pub last_error: Option<String>,
    /// The service will never take it.
    pub refused: bool,
    /// When it is tried again.
    #[serde(with = "time::serde::rfc3339::option")]
    pub next_try_at: Option<OffsetDateTime>,
}

/// An attempt that waits, or answers to a survey after one.
#[derive(Clone, Debug)]
pub struct Entry {
    /// Id within the outbox.
    pub id: String,
    /// The recording, or the answers.
    pub file: PathBuf,
    /// Its size, in bytes.
    pub bytes: u64,
    /// What is known of it.
    pub note: Note,
}

impl Entry {
    /// The entry of a recording that has just been brought in, or had been before.
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

    /// Reads an entry. Where the note is missing or spoilt, the recording still waits: it begins anew.
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

    /// Whether these are answers, not a recording.
    pub(super) fn is_answers(&self) -> bool {
        self.file.extension().is_some_and(|extension| extension == sheet::ANSWERS)
    }

    /// Whether it is to be tried now.
    pub fn is_due(&self, now: OffsetDateTime) -> bool {
        !self.note.refused && self.note.next_try_at.is_none_or(|at| at <= now)
    }

    /// Notes the upload that has been begun, so that it is gone on with after whatever happens.
    pub(super) fn began(&mut self, upload: String) -> io::Result<()> {
        self.note.upload = Some(upload);
        self.save()
    }

    /// Notes why it was not delivered, and when it is tried again.
    pub(super) fn failed(&mut self, trouble: &Trouble) -> io::Result<()> {
        let note = &mut self.note;
        note.tries = note.tries.saturating_add(1);
        note.last_error = Some(trouble.detail.clone());
        note.refused = trouble.outlook == Outlook::Never;
        let wait = FIRST_WAIT.saturating_mul(1 << (note.tries - 1).min(16)).min(LONGEST_WAIT);
        note.next_try_at = (!note.refused).then(|| clock::now() + wait);
        self.save()
    }

    /// Takes the attempt out of the outbox: it is on the service's disk, or its owner wishes it.
    ///
    /// # Errors
    /// When the disk refuses.
    pub fn remove(&self) -> io::Result<()> {
        // The recording first: a note without one is nothing, a recording without a note waits.
        for file in [self.file.clone(), note_of(&self.file)] {
            match fs::remove_file(file) {
                Err(error) if error.kind() != ErrorKind::NotFound => return Err(error),
                _ => {}
            }
        }
        Ok(())
    }

    /// Takes the attempt out of the outbox, and removes the file that it was kept from, where that still holds the same bytes.
    ///
    /// # Errors
    /// When the disk refuses.
    pub(super) fn remove_everywhere(&self) -> io::Result<()> {
        if let Some(source) = &self.note.source {
            match identify(source) {
                Ok(id) if id == self.id => fs::remove_file(source)?,
                // It was moved or written over: that is nothing of ours.
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
        new.as_file().sync_all()?;
        new.persist(note_of(&self.file))?;
        Ok(())
    }
}

fn note_of(file: &Path) -> PathBuf {
    file.with_extension("json")
}
