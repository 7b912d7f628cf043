//! One try to deliver one entry. An upload continues at the offset that the service reports, until
//! the service returns its session. Answers are short and are sent whole.

use std::fs::File;
use std::io::{self, Read, Seek, SeekFrom};

use super::tus::{self, UploadStanding};
use super::{Entry, sheet};
use crate::progress::Progress;
use crate::service::{Outlook, Service, Trouble};

/// Bytes per request: the most that a broken connection loses.
const PIECE_BYTES: u64 = 256 * 1024;

/// A try and its progress.
pub struct Try<'a> {
    service: &'a Service,
    entry: &'a mut Entry,
    /// Bytes that the service has confirmed as stored.
    pub reached: u64,
}

impl<'a> Try<'a> {
    pub fn new(service: &'a Service, entry: &'a mut Entry) -> Self {
        Self { service, entry, reached: 0 }
    }

    /// Sends the bytes that the service does not have yet; returns the id of the session.
    pub fn deliver(&mut self) -> Result<String, Trouble> {
        if self.entry.is_answers() {
            return sheet::deliver(self.service, &self.entry.file);
        }
        let progress = Progress::new(self.entry.bytes, "uploading");
        let mut file = File::open(&self.entry.file).map_err(unreadable)?;
        let mut standing = match self.entry.note.upload.clone() {
            Some(id) => tus::ask_upload_standing(self.service, &id)?,
            None => UploadStanding::Gone,
        };
        let mut begun = false;
        loop {
            standing = match standing {
                UploadStanding::Session(session) => return Ok(session),
                UploadStanding::At(offset) => {
                    self.reached = self.reached.max(offset);
                    progress.set(offset);
                    self.piece(&mut file, offset)?
                }
                UploadStanding::Gone if begun => {
                    return Err(Trouble::new(Outlook::Soon, "the service lost the upload while it was in progress"));
                }
                UploadStanding::Gone => {
                    begun = true;
                    let id = tus::begin_upload(self.service, &self.entry.note.name, self.entry.bytes)?;
                    self.entry.began(id).map_err(unreadable)?;
                    UploadStanding::At(0)
                }
            };
        }
    }

    fn piece(&mut self, file: &mut File, offset: u64) -> Result<UploadStanding, Trouble> {
        let id = self.entry.note.upload.clone().unwrap_or_default();
        let piece = read_piece(file, offset).map_err(unreadable)?;
        let standing = tus::send_upload_piece(self.service, &id, offset, &piece)?;
        match standing {
            UploadStanding::At(now) if now >= self.entry.bytes && piece.is_empty() => Err(Trouble::new(
                Outlook::Soon,
                "the service has received the whole recording but has not created an attempt yet",
            )),
            standing => Ok(standing),
        }
    }
}

fn read_piece(file: &mut File, offset: u64) -> io::Result<Vec<u8>> {
    let mut piece = Vec::new();
    file.seek(SeekFrom::Start(offset))?;
    file.take(PIECE_BYTES).read_to_end(&mut piece)?;
    Ok(piece)
}

fn unreadable(error: io::Error) -> Trouble {
    Trouble::new(Outlook::Later, format_args!("the outbox: {error}"))
}
