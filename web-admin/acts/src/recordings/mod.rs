//! Receives recordings chunk by chunk, moves them into the store once they are durable, and reads a
//! limited number at a time.

pub mod checksum;
pub mod duplicate_backfill;
pub mod intake;
pub mod links;
pub mod quotas;
pub mod replays;
pub mod uploads;

use std::fs::File;
use std::io::ErrorKind;
use std::path::{Path, PathBuf};
use std::time::Duration;

use bytes::Bytes;
use data_encoding::HEXLOWER;
use futures::StreamExt;
use futures::stream::BoxStream;
use model::ids::{CommentId, UploadId};
use model::training::comment::CommentKind;
use platform::files::{PartFile, hash_file};
use platform::recording_store::{Bucket, LocalRecording, StoredFile};
use recording::annotate::Annotation;
use sha2::{Digest, Sha256};
use store::recordings::sessions::Session;
use store::training::comments;
use tokio::io::AsyncWriteExt;
use uuid::Uuid;

use crate::error::Error;
use crate::recordings::checksum::Checksum;
use crate::recordings::quotas::{LOOK_BYTES, ensure_room};
use crate::sandbox;
use crate::sandbox_jobs::{AnnotationQuestion, SandboxRequest, SandboxResponse};
use crate::service::Service;

/// Maximum time in the queue for copying a recording with annotations.
const PATIENCE: Duration = Duration::from_secs(20);

/// A received file that is durable but not stored as a recording yet.
#[derive(Debug)]
pub struct Received {
    part: PartFile,
    /// SHA-256, lower-case hexadecimal.
    pub sha256: String,
    /// Size, in bytes.
    pub size: u64,
    /// The resumable upload that it belongs to, if any.
    pub upload: Option<UploadId>,
}

impl Received {
    /// Opens the file of a resumable upload. It is not deleted on drop. Blocks.
    ///
    /// # Errors
    /// Fails if it cannot be read.
    pub fn of_upload(path: PathBuf, upload: UploadId) -> std::io::Result<Self> {
        let (sha256, size) = hash_file(&path)?;
        // The receipt of these bytes has been acknowledged, so a failure must not delete them.
        Ok(Self { part: PartFile { path, kept: true }, sha256, size, upload: Some(upload) })
    }

    /// Assembles the chunks of an upload in a bucket into a local file.
    ///
    /// # Errors
    /// Fails if the store does not respond, or the local disk fails.
    pub async fn of_pieces(bucket: &Bucket, upload: UploadId, pieces: &[String]) -> Result<Self, Error> {
        let (part, sha256) = bucket.join_pieces(pieces).await?;
        let size = tokio::fs::metadata(&part.path).await?.len();
        Ok(Self { part, sha256, size, upload: Some(upload) })
    }

    /// Takes ownership of an existing file on the file system of the recordings. It is moved into
    /// the store, or deleted on drop. Blocks.
    ///
    /// # Errors
    /// Fails if it cannot be read.
    pub fn adopt(path: PathBuf) -> std::io::Result<Self> {
        let (sha256, size) = hash_file(&path)?;
        File::open(&path)?.sync_all()?;
        Ok(Self { part: PartFile { path, kept: false }, sha256, size, upload: None })
    }

    /// Path of the file.
    #[must_use]
    pub fn path(&self) -> &Path {
        &self.part.path
    }

    /// Links the file into its final place and syncs it. The old name remains until this is
    /// dropped, so that a crash before the row is committed loses nothing. A leftover file without
    /// a row is replaced. Blocks.
    ///
    /// # Errors
    /// Fails if the disk fails; the file may or may not be in place then, but no row refers to it.
    pub fn place(&self, place: &Path) -> std::io::Result<()> {
        let folder = place.parent().unwrap_or(Path::new("."));
        std::fs::create_dir_all(folder)?;
        match std::fs::remove_file(place) {
            Err(error) if error.kind() != ErrorKind::NotFound => return Err(error),
            _ => {}
        }
        if std::fs::hard_link(&self.part.path, place).is_err() {
            // The file system does not support hard links.
            std::fs::copy(&self.part.path, place)?;
            File::open(place)?.sync_all()?;
        }
        File::open(folder)?.sync_all()?;
        // The folder itself may be new, so sync its parent, too.
        folder.parent().map_or(Ok(()), |above| File::open(above)?.sync_all())
    }
}

/// A stream of bytes.
pub type Chunks = BoxStream<'static, anyhow::Result<Bytes>>;

/// A request body being received.
pub struct Arriving {
    /// Announced size, in bytes; 0 if unknown.
    pub announced_bytes: u64,
    /// The bytes.
    pub chunks: Chunks,
}

/// Receives a body into a file, hashing it on the way, and syncs it.
///
/// # Errors
/// Fails if it is too large, stalls, does not match its checksum, or the disk fails. No file
/// remains then.
pub async fn receive(state: &Service, body: Arriving, checksum: Option<Checksum>) -> Result<Received, Error> {
    ensure_room(state, body.announced_bytes).await?;
    let (config, mut checksum) = (&state.config, checksum);
    let path = config.uploads_dir().join(format!("{}.part", Uuid::new_v4()));
    let mut file = tokio::fs::File::create_new(&path).await?;
    let part = PartFile { path, kept: false };
    let (mut hash, mut size, mut looked_at) = (Sha256::new(), 0_u64, 0_u64);
    let mut chunks = body.chunks;
    while let Some(chunk) =
        tokio::time::timeout(config.upload_silence, chunks.next()).await.map_err(|_| Error::Timeout)?
    {
        let chunk = chunk.map_err(|_| Error::BadRequest("the request body is incomplete".to_owned()))?;
        size += chunk.len() as u64;
        if size > config.max_upload_bytes {
            return Err(Error::TooLarge { limit_bytes: config.max_upload_bytes });
        }
        hash.update(&chunk);
        if let Some(checksum) = &mut checksum {
            checksum.update(&chunk);
        }
        file.write_all(&chunk).await?;
        if size - looked_at >= LOOK_BYTES {
            ensure_room(state, body.announced_bytes.saturating_sub(size)).await?;
            looked_at = size;
        }
    }
    ensure_room(state, 0).await?;
    if checksum.is_some_and(|checksum| !checksum.fits()) {
        return Err(Error::Unprocessable(
            "the request body does not match Content-Digest: it was discarded".to_owned(),
        ));
    }
    file.flush().await?;
    file.sync_all().await?;
    Ok(Received { part, sha256: HEXLOWER.encode(&hash.finalize()), size, upload: None })
}

/// Rejects an attempt whose recording was erased with its trainee.
///
/// # Errors
/// Returns [`Error::Gone`] if it was erased.
pub fn refuse_erased(session: &Session) -> Result<(), Error> {
    match session.recording_erased_at {
        Some(_) => Err(Error::Gone(tr!("this recording was erased"))),
        None => Ok(()),
    }
}

/// Returns an attempt's recording for reading as a whole or by ranges.
///
/// # Errors
/// Fails if it was erased with its trainee, or is unavailable.
pub async fn find(state: &Service, session: &Session) -> Result<StoredFile, Error> {
    refuse_erased(session)?;
    Ok(state.recordings.find(&session.recording_path).await?)
}

/// Returns an attempt's recording as a local file.
///
/// # Errors
/// Fails if it was erased with its trainee, or is unavailable.
pub async fn fetch(state: &Service, session: &Session) -> Result<LocalRecording, Error> {
    refuse_erased(session)?;
    Ok(state.recordings.fetch(&session.recording_path).await?)
}

/// A temporary file, deleted on drop. Open file handles stay valid.
#[derive(Debug)]
pub struct Copied(PartFile);

impl Copied {
    /// Path of the file.
    #[must_use]
    pub fn path(&self) -> &Path {
        &self.0.path
    }
}

/// Copies a recording with the comments on the attempt as timed annotations, attributed to roles
/// instead of names. The copy is a file, so that a slow client does not occupy memory.
///
/// # Errors
/// Fails if the recording cannot be read, or the disk fails.
pub async fn with_comments(state: &Service, session: &Session) -> Result<Copied, Error> {
    let said = comments::list_session_comments(state.db.reader(), session.key()).await?;
    let remarks = remarks(&said);
    ensure_room(state, session.recording_size.unsigned_abs()).await?;
    let part = PartFile { path: state.config.uploads_dir().join(format!("{}.part", Uuid::new_v4())), kept: false };
    let _place = state.helpers.enter(session.school_id, PATIENCE).await?;
    let recording = fetch(state, session).await?;
    let (recorded, copy) = (recording.path().to_owned(), part.path.clone());
    let question = SandboxRequest::Annotate(AnnotationQuestion { recording: recorded, copy, remarks });
    match sandbox::ask(state, question).await? {
        SandboxResponse::Annotated => Ok(Copied(part)),
        other => {
            Err(anyhow::anyhow!("unexpected answer to a request to copy a recording with comments: {other:?}").into())
        }
    }
}

/// Converts comments to annotations; an answer has the time of its comment.
fn remarks(said: &[comments::CommentRecord]) -> Vec<Annotation> {
    let asked = |id: Option<CommentId>| said.iter().find(|comment| Some(comment.id) == id);
    let remark = |comment: &comments::CommentRecord| {
        let kind = comment.kind.map_or("answer", CommentKind::name);
        let t_s = comment.from_s.or_else(|| asked(comment.answers)?.from_s)?;
        let until = comment.to_s.map_or_else(String::new, |to_s| format!(" (to {to_s} s)"));
        Some(Annotation { t_s, text: format!("{kind} by {}{until}: {}", comment.author_role, comment.body) })
    };
    said.iter().filter_map(remark).collect()
}

/// Deletes incomplete files left by an interrupted service, none of which had been acknowledged.
/// Returns their number.
///
/// # Errors
/// Fails if the folder cannot be read or a file cannot be deleted.
pub fn clear_uploads(folder: &Path) -> std::io::Result<usize> {
    let mut cleared = 0;
    for entry in std::fs::read_dir(folder)? {
        let path = entry?.path();
        if path.extension().is_some_and(|extension| extension == "part") {
            std::fs::remove_file(path)?;
            cleared += 1;
        }
    }
    Ok(cleared)
}
