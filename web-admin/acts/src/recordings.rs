//! Recordings on disk: taken in piece by piece, kept only when they are whole on the disk, read a few at a time.

use std::fs::File;
use std::io::ErrorKind;
use std::path::{Path, PathBuf};
use std::time::Duration;

use bytes::Bytes;
use data_encoding::HEXLOWER;
use futures::StreamExt;
use futures::stream::BoxStream;
use model::comment::CommentKind;
use model::ids::{CommentId, UploadId};
use recording::annotate::Annotation;
use recording::{ReadError, Recording};
use sha2::{Digest, Sha256};
use store::comments;
use store::sessions::Session;
use tokio::io::AsyncWriteExt;
use uuid::Uuid;

use crate::asking;
use crate::checksum::Checksum;
use crate::error::Error;
use crate::judging::{AnnotationQuestion, JudgeAnswer, JudgeQuestion};
use crate::recording_files::{hash_file, read};
use crate::recording_store::{Bucket, LocalRecording, StoredFile};
use crate::removing::PartFile;
use crate::room::{LOOK_BYTES, ensure_room};
use crate::service::Service;

/// Longest wait until a helper makes a copy with remarks.
const PATIENCE: Duration = Duration::from_secs(20);

/// An upload that has arrived and is on the disk, but is not kept yet.
#[derive(Debug)]
pub struct Received {
    part: PartFile,
    /// SHA-256 of the bytes, lower-case hexadecimal.
    pub sha256: String,
    /// In bytes.
    pub size: u64,
    /// The upload in pieces that it came by.
    pub upload: Option<UploadId>,
}

impl Received {
    /// The file of an upload in pieces, which stays where it is unless it is kept. Blocks.
    ///
    /// # Errors
    /// When it cannot be read.
    pub fn of_upload(path: PathBuf, upload: UploadId) -> std::io::Result<Self> {
        let (sha256, size) = hash_file(&path)?;
        // Its owner was told that the bytes are here: they are not dropped because the database happens to fail.
        Ok(Self { part: PartFile { path, kept: true }, sha256, size, upload: Some(upload) })
    }

    /// What the pieces of an upload in a bucket come to.
    ///
    /// # Errors
    /// When the store does not answer, or this machine's disk refuses.
    pub async fn of_pieces(bucket: &Bucket, upload: UploadId, pieces: &[String]) -> Result<Self, Error> {
        let (part, sha256) = bucket.join_pieces(pieces).await?;
        let size = tokio::fs::metadata(&part.path).await?.len();
        Ok(Self { part, sha256, size, upload: Some(upload) })
    }

    /// Takes over a file that is there already, on the file system of the recordings; it is moved when it is kept.
    /// Blocks.
    ///
    /// # Errors
    /// When it cannot be read.
    pub fn adopt(path: PathBuf) -> std::io::Result<Self> {
        let (sha256, size) = hash_file(&path)?;
        File::open(&path)?.sync_all()?;
        Ok(Self { part: PartFile { path, kept: false }, sha256, size, upload: None })
    }

    /// The file.
    #[must_use]
    pub fn path(&self) -> &Path {
        &self.part.path
    }

    /// Puts the file into its place too, and makes that last. Under its old name it stays until this is dropped: whoever dies
    /// before a row names the place has lost nothing. What a predecessor has left there that no row names is replaced. Blocks.
    ///
    /// # Errors
    /// When the disk refuses; the place may then hold the file or not, and nothing names it yet.
    pub fn place(&self, place: &Path) -> std::io::Result<()> {
        let folder = place.parent().unwrap_or(Path::new("."));
        std::fs::create_dir_all(folder)?;
        match std::fs::remove_file(place) {
            Err(error) if error.kind() != ErrorKind::NotFound => return Err(error),
            _ => {}
        }
        if std::fs::hard_link(&self.part.path, place).is_err() {
            // A file system without links.
            std::fs::copy(&self.part.path, place)?;
            File::open(place)?.sync_all()?;
        }
        File::open(folder)?.sync_all()?;
        // The folder itself may be new.
        folder.parent().map_or(Ok(()), |above| File::open(above)?.sync_all())
    }
}

/// Bytes as they come, some at a time.
pub type Chunks = BoxStream<'static, anyhow::Result<Bytes>>;

/// A body as it arrives.
pub struct Arriving {
    /// How many there will be at least, where that was said; else 0.
    pub announced_bytes: u64,
    /// The bytes, some at a time.
    pub chunks: Chunks,
}

/// Takes in a body, hashing it on the way, until it is on the disk.
///
/// # Errors
/// When it is too large, stops arriving, is not what its checksum says, or the disk refuses. Nothing is left behind.
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
        let chunk = chunk.map_err(|_| Error::BadRequest("the body broke off".to_owned()))?;
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
        return Err(Error::Unprocessable("the body is not what Content-Digest says: it was not kept".to_owned()));
    }
    file.flush().await?;
    file.sync_all().await?;
    Ok(Received { part, sha256: HEXLOWER.encode(&hash.finalize()), size, upload: None })
}

/// Reads a recording where blocking is allowed, when there is room for one in memory, and makes something of it.
///
/// # Errors
/// When the work could not be run; the inner error, when the file is no recording.
pub async fn with<T: Send + 'static>(
    state: &Service,
    recording: LocalRecording,
    make: impl FnOnce(Recording) -> T + Send + 'static,
) -> Result<Result<T, ReadError>, Error> {
    state.parse(move || read(recording.path()).map(make)).await
}

/// Refuses what would need a recording that was erased with whoever made it.
///
/// # Errors
/// When it was.
pub fn refuse_erased(session: &Session) -> Result<(), Error> {
    match session.recording_erased_at {
        Some(_) => Err(Error::Gone(tr!("this recording was erased"))),
        None => Ok(()),
    }
}

/// An attempt's recording, to be read whole or in ranges.
///
/// # Errors
/// When it was erased with whoever made it, or cannot be reached.
pub async fn find(state: &Service, session: &Session) -> Result<StoredFile, Error> {
    refuse_erased(session)?;
    Ok(state.recordings.find(&session.recording_path).await?)
}

/// An attempt's recording as a file, for as long as what is given is kept.
///
/// # Errors
/// When it was erased with whoever made it, or cannot be reached.
pub async fn fetch(state: &Service, session: &Session) -> Result<LocalRecording, Error> {
    refuse_erased(session)?;
    Ok(state.recordings.fetch(&session.recording_path).await?)
}

/// A file that goes when it is dropped. Who has opened it reads on.
#[derive(Debug)]
pub struct Copied(PartFile);

impl Copied {
    /// The file.
    #[must_use]
    pub fn path(&self) -> &Path {
        &self.0.path
    }
}

/// A copy of a recording in which what was said about the attempt are events at their moments. It names roles, no people. A file,
/// so that whoever reads it slowly holds no memory.
///
/// # Errors
/// When the recording cannot be read, or the disk refuses.
pub async fn with_comments(state: &Service, session: &Session) -> Result<Copied, Error> {
    let said = comments::list_session_comments(state.db.reader(), session.key()).await?;
    let remarks = remarks(&said);
    ensure_room(state, session.recording_size.unsigned_abs()).await?;
    let part = PartFile { path: state.config.uploads_dir().join(format!("{}.part", Uuid::new_v4())), kept: false };
    let place = state.helpers.enter(session.school_id, PATIENCE).await;
    let _place = place.ok_or(Error::Busy { retry_after_s: PATIENCE.as_secs() })?;
    let recording = fetch(state, session).await?;
    let (recorded, copy) = (recording.path().to_owned(), part.path.clone());
    let question = JudgeQuestion::Annotate(AnnotationQuestion { recording: recorded, copy, remarks });
    match asking::ask(state, question).await? {
        JudgeAnswer::Annotated => Ok(Copied(part)),
        other => Err(anyhow::anyhow!("a recording was to be copied with remarks, and the answer was {other:?}").into()),
    }
}

/// Comments as remarks; an answer stands where its comment does.
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

/// Deletes what uploads left behind when the service was stopped in their midst. Nobody was told they had arrived.
///
/// # Errors
/// When the folder cannot be read or a file not be deleted.
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
