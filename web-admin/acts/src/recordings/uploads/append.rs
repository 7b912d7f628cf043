//! Receives a chunk of a resumable upload and stores it.

use bytes::Bytes;
use futures::StreamExt;
use model::ids::UploadId;
use platform::fail_points::FailPoint;
use platform::files::PartFile;
use platform::upload_locks::UploadLock;
use store::recordings::uploads::{Upload, UploadOwner};
use tokio::fs::File;
use tokio::io::{AsyncSeekExt, AsyncWriteExt};

use super::{LOOKS, complete, look, pieces, take_over};
use crate::error::Error;
use crate::recordings::checksum::Checksum;
use crate::recordings::quotas::LOOK_BYTES;
use crate::recordings::{Chunks, quotas};
use crate::service::Service;

/// A chunk without a checksum is synced and counted at this interval, in bytes: at most this much
/// is sent again after a crash.
const CHECKPOINT_BYTES: i64 = 8 << 20;

/// A chunk being received.
pub struct UploadPiece {
    /// Offset of its first byte.
    pub offset: u64,
    /// Expected checksum, if any.
    pub checksum: Option<Checksum>,
    /// Length in bytes, if announced.
    pub announced: Option<u64>,
    /// The bytes.
    pub body: Chunks,
}

/// Appends a chunk to an upload, and turns the upload into an attempt if it is complete. When this
/// returns, even with an error, all bytes counted as received are durable.
///
/// # Errors
/// Fails if the upload is being processed, or the chunk does not start at the end of the upload, is
/// too long, is interrupted or does not match its checksum, or if the complete recording is
/// rejected.
pub async fn append(state: &Service, owner: UploadOwner, id: UploadId, piece: UploadPiece) -> Result<Upload, Error> {
    let mut turn = take_over(state, owner, id).await?.ok_or(Error::Locked)?;
    let upload = look(state, owner, id, true).await?;
    check(&upload, &piece)?;
    let state = state.clone();
    // A separate task: when the client disconnects, the server drops the handler, and with it
    // received data.
    let work = tokio::spawn(async move {
        let upload = write(&state, upload, piece, &mut turn).await?;
        if upload.whole() && upload.session_id.is_none() { complete(&state, upload, LOOKS).await } else { Ok(upload) }
    });
    work.await?
}

/// Rejects a chunk before its body is read, if possible.
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

/// The file of an upload during a write.
struct Writing<'a> {
    state: &'a Service,
    turn: &'a mut UploadLock,
    upload: Upload,
    file: File,
    /// If chunks are stored in a bucket, a temporary file with only the bytes that are not there
    /// yet.
    spool: Option<PartFile>,
    /// End of the written bytes, synced or not.
    end: i64,
}

async fn write(state: &Service, upload: Upload, piece: UploadPiece, turn: &mut UploadLock) -> Result<Upload, Error> {
    if upload.whole() {
        return nothing_more(state, upload, piece.body, turn).await;
    }
    let (file, spool) = pieces::open(state, &upload).await?;
    let mut writing = Writing { state, turn, end: upload.received, upload, file, spool };
    let mut checksum = piece.checksum;
    let broken = writing.take(piece.body, &mut checksum).await;
    match (checksum, broken) {
        // The checksum of an incomplete chunk cannot be verified, so the chunk is discarded.
        (Some(_), Err(broken)) => Err(broken),
        (Some(checksum), Ok(())) if !checksum.fits() => Err(Error::ChecksumMismatch),
        (_, Err(too_large @ Error::TooLarge { .. })) => Err(too_large),
        // Some bytes may not have been written: return to the last durable state.
        (_, Err(refused @ Error::NoRoom(_))) => {
            writing.cut().await?;
            Err(refused)
        }
        (_, Err(refused @ (Error::Internal(_) | Error::StoreUnavailable(_) | Error::DatabaseUnavailable(_)))) => {
            Err(refused)
        }
        (_, broken) => {
            writing.settle().await?;
            broken.map(|()| writing.upload)
        }
    }
}

/// Reads the body of a chunk that must be empty.
async fn nothing_more(state: &Service, upload: Upload, body: Chunks, turn: &mut UploadLock) -> Result<Upload, Error> {
    let mut chunks = body;
    match next(state, turn, &mut chunks).await? {
        Some(chunk) if !chunk.is_empty() => Err(Error::TooLarge { limit_bytes: 0 }),
        _ => Ok(upload),
    }
}

impl Writing<'_> {
    async fn take(&mut self, mut chunks: Chunks, checksum: &mut Option<Checksum>) -> Result<(), Error> {
        let mut looked_at = self.end;
        while let Some(chunk) = next(self.state, self.turn, &mut chunks).await? {
            let length = i64::try_from(chunk.len()).map_err(anyhow::Error::from)?;
            if length > self.upload.length - self.end {
                let room = self.upload.length - self.upload.received;
                return Err(Error::TooLarge { limit_bytes: room.unsigned_abs() });
            }
            self.file.write_all(&chunk).await?;
            self.end += length;
            if (self.end - looked_at).unsigned_abs() >= LOOK_BYTES {
                quotas::ensure_reserve(self.state)?;
                looked_at = self.end;
            }
            match checksum {
                Some(checksum) => checksum.update(&chunk),
                None if self.end - self.upload.received >= CHECKPOINT_BYTES => self.settle().await?,
                None => {}
            }
        }
        quotas::ensure_reserve(self.state)
    }

    /// Truncates the file to the bytes that count as received.
    async fn cut(&mut self) -> Result<(), Error> {
        self.file.flush().await?;
        let counted = if self.spool.is_some() { 0 } else { self.upload.received.unsigned_abs() };
        Ok(self.file.set_len(counted).await?)
    }

    /// Syncs the written bytes or sends them to the bucket, and then counts them in the upload's
    /// row.
    async fn settle(&mut self) -> Result<(), Error> {
        self.file.flush().await?;
        FailPoint::PieceWritten.hit();
        let begins = self.upload.received;
        let expected = match &self.spool {
            Some(_) if self.end == begins => return Ok(()),
            Some(_) => self.end - begins,
            None => self.file.sync_all().await.map(|()| self.end)?,
        };
        // A failed background write is reported only once, possibly to an earlier call, so check
        // the size.
        let there = self.file.metadata().await?.len();
        if there != expected.unsigned_abs() {
            let cause = anyhow::anyhow!("the file of upload {} contains {there} of {expected} bytes", self.upload.id);
            return Err(Error::Internal(cause));
        }
        let object = match &self.spool {
            Some(spool) => pieces::send(self.state, self.upload.id, &spool.path).await?,
            None => None,
        };
        self.upload.received = self.end;
        self.upload.expires_at = self.state.clock.now().plus_s(self.state.config.upload_lifetime_s);
        FailPoint::PieceSynced.hit();
        pieces::count(self.state, &self.upload, begins, object.as_deref()).await?;
        FailPoint::PieceCounted.hit();
        if self.spool.is_some() {
            self.file.set_len(0).await?;
            self.file.rewind().await?;
        }
        Ok(())
    }
}

/// Reads the next bytes of a body; returns `None` at its end.
async fn next(state: &Service, turn: &mut UploadLock, chunks: &mut Chunks) -> Result<Option<Bytes>, Error> {
    let chunk = tokio::select! {
        chunk = tokio::time::timeout(state.config.upload_silence, chunks.next()) => chunk.map_err(|_| Error::Timeout)?,
        () = turn.wanted() => return Err(Error::Conflict("another request has taken over this upload".to_owned())),
    };
    chunk.transpose().map_err(|_| Error::BadRequest("the request body is incomplete".to_owned()))
}
