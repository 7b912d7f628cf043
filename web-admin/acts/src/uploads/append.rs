//! A piece of an upload, from the network to the disk.

use std::io::SeekFrom;

use bytes::Bytes;
use futures::StreamExt;
use model::ids::UploadId;
use store::uploads;
use store::uploads::{Upload, UploadOwner};
use tokio::fs::File;
use tokio::io::{AsyncSeekExt, AsyncWriteExt};

use super::{complete, look, place, take_over};
use crate::checksum::Checksum;
use crate::error::Error;
use crate::killpoints::KillPoint;
use crate::recordings::Chunks;
use crate::service::Service;
use crate::turns::Turn;

/// A piece without a checksum is acknowledged to ourselves this often, in bytes: so much is sent again after a crash.
const CHECKPOINT_BYTES: i64 = 8 << 20;

/// A piece as it arrives.
pub struct UploadPiece {
    /// Where it begins, in bytes.
    pub offset: u64,
    /// What it must hash to.
    pub checksum: Option<Checksum>,
    /// Its length in bytes, where it was announced.
    pub announced: Option<u64>,
    /// The bytes.
    pub body: Chunks,
}

/// Adds a piece to an upload, and makes an attempt of it when it was the last. When this returns, also with an error,
/// the bytes that the upload counts as received are on the disk.
///
/// # Errors
/// When it is being taken in, the piece does not begin where the upload ends, is too long, breaks off or is not what
/// its checksum says; when the whole is refused as a recording.
pub async fn append(state: &Service, owner: UploadOwner, id: UploadId, piece: UploadPiece) -> Result<Upload, Error> {
    let mut turn = take_over(state, owner, id).await?.ok_or(Error::Locked)?;
    let upload = look(state, owner, id, true).await?;
    check(&upload, &piece)?;
    let state = state.clone();
    // A task of its own: the server drops a handler whose client has gone, and with it what has arrived.
    let work = tokio::spawn(async move {
        let upload = write(&state, upload, piece, &mut turn).await?;
        if upload.whole() && upload.session_id.is_none() { complete(&state, upload).await } else { Ok(upload) }
    });
    work.await?
}

/// Refuses what can be refused before a byte is read.
fn check(upload: &Upload, piece: &UploadPiece) -> Result<(), Error> {
    let (received, room) = (upload.received.unsigned_abs(), (upload.length - upload.received).unsigned_abs());
    if piece.offset != received {
        return Err(Error::Conflict(format!("Upload-Offset: {}; this upload has {received} bytes", piece.offset)));
    }
    match piece.announced {
        Some(length) if length > room => Err(Error::TooLarge { limit_bytes: room }),
        _ => Ok(()),
    }
}

/// The file of an upload with what is being written to it.
struct Writing<'a> {
    state: &'a Service,
    turn: &'a mut Turn,
    upload: Upload,
    file: File,
    /// Bytes written, on the disk or not.
    end: i64,
}

async fn write(state: &Service, upload: Upload, piece: UploadPiece, turn: &mut Turn) -> Result<Upload, Error> {
    if upload.whole() {
        return nothing_more(state, upload, piece.body, turn).await;
    }
    let mut file = File::options().write(true).open(place(state, upload.id)).await?;
    // What a crash left beyond the received bytes is not known to be what was sent.
    file.set_len(upload.received.unsigned_abs()).await?;
    file.seek(SeekFrom::End(0)).await?;
    let mut writing = Writing { state, turn, end: upload.received, upload, file };
    let mut checksum = piece.checksum;
    let broken = writing.take(piece.body, &mut checksum).await;
    match (checksum, broken) {
        // Half a piece cannot be checked: it has not arrived.
        (Some(_), Err(broken)) => Err(broken),
        (Some(checksum), Ok(())) if !checksum.fits() => Err(Error::ChecksumMismatch),
        (_, Err(too_large @ Error::TooLarge { .. })) => Err(too_large),
        // What the disk has refused, and what was written after it, is not there: back to what was received.
        (_, Err(disk @ (Error::Internal(_) | Error::NoRoom(_)))) => Err(disk),
        (_, broken) => {
            writing.settle().await?;
            broken.map(|()| writing.upload)
        }
    }
}

/// Reads the body of a piece that must be empty.
async fn nothing_more(state: &Service, upload: Upload, body: Chunks, turn: &mut Turn) -> Result<Upload, Error> {
    let mut chunks = body;
    match next(state, turn, &mut chunks).await? {
        Some(chunk) if !chunk.is_empty() => Err(Error::TooLarge { limit_bytes: 0 }),
        _ => Ok(upload),
    }
}

impl Writing<'_> {
    async fn take(&mut self, mut chunks: Chunks, checksum: &mut Option<Checksum>) -> Result<(), Error> {
        while let Some(chunk) = next(self.state, self.turn, &mut chunks).await? {
            let length = i64::try_from(chunk.len()).map_err(anyhow::Error::from)?;
            if length > self.upload.length - self.end {
                let room = self.upload.length - self.upload.received;
                return Err(Error::TooLarge { limit_bytes: room.unsigned_abs() });
            }
            self.file.write_all(&chunk).await?;
            self.end += length;
            match checksum {
                Some(checksum) => checksum.update(&chunk),
                None if self.end - self.upload.received >= CHECKPOINT_BYTES => self.settle().await?,
                None => {}
            }
        }
        Ok(())
    }

    /// Puts what was written on the disk, and then says so in the upload's row.
    async fn settle(&mut self) -> Result<(), Error> {
        self.file.flush().await?;
        KillPoint::PieceWritten.pass();
        self.file.sync_all().await?;
        // A write that failed behind our back is told once, and not by who asks next.
        let there = self.file.metadata().await?.len();
        if there != self.end.unsigned_abs() {
            let cause = anyhow::anyhow!("{there} bytes of {} are in the file of upload {}", self.end, self.upload.id);
            return Err(Error::Internal(cause));
        }
        self.upload.received = self.end;
        self.upload.expires_at = self.state.clock.now().plus_s(self.state.config.upload_lifetime_s);
        KillPoint::PieceSynced.pass();
        let mut tx = self.state.db.write().await?;
        uploads::advance_upload(&mut tx, &self.upload).await?;
        tx.commit().await?;
        KillPoint::PieceCounted.pass();
        Ok(())
    }
}

/// The next bytes of a body; nothing at its end.
async fn next(state: &Service, turn: &mut Turn, chunks: &mut Chunks) -> Result<Option<Bytes>, Error> {
    let chunk = tokio::select! {
        chunk = tokio::time::timeout(state.config.upload_silence, chunks.next()) => chunk.map_err(|_| Error::Timeout)?,
        () = turn.wanted() => return Err(Error::Conflict("another request has taken this upload over".to_owned())),
    };
    chunk.transpose().map_err(|_| Error::BadRequest("the body broke off".to_owned()))
}
