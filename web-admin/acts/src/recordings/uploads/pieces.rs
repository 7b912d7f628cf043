//! Storage of the bytes of a resumable upload: a file per upload, or objects in a bucket, one per
//! chunk, of which the database records those that count.

use std::io::SeekFrom;
use std::path::{Path, PathBuf};

use model::ids::UploadId;
use platform::files::PartFile;
use platform::recording_store::RecordingStore;
use store::recordings::uploads;
use store::recordings::uploads::Upload;
use tokio::fs::File;
use tokio::io::AsyncSeekExt;
use uuid::Uuid;

use crate::error::Error;
use crate::recordings::Received;
use crate::service::Service;

/// File extension of an unfinished upload. Files with the extension `part` are deleted at start-up
/// by `recordings::clear_uploads`.
const EXTENSION: &str = "tus";

/// Returns the path of an upload's file.
fn place(state: &Service, id: UploadId) -> PathBuf {
    state.config.uploads_dir().join(format!("{id}.{EXTENSION}"))
}

/// Creates the file of a new upload.
pub(super) async fn begin(state: &Service, id: UploadId) -> std::io::Result<()> {
    if let RecordingStore::Folder(_) = &state.recordings {
        File::create_new(place(state, id)).await?;
        File::open(state.config.uploads_dir()).await?.sync_all().await?;
    }
    Ok(())
}

/// Returns whether the file of an upload is missing although its row exists.
pub(super) async fn is_lost(state: &Service, id: UploadId) -> std::io::Result<bool> {
    match &state.recordings {
        RecordingStore::Folder(_) => Ok(!tokio::fs::try_exists(place(state, id)).await?),
        RecordingStore::Bucket(_) => Ok(false),
    }
}

/// Opens the file for the next bytes of an upload: its own file, or a temporary one that is sent to
/// the bucket.
pub(super) async fn open(state: &Service, upload: &Upload) -> std::io::Result<(File, Option<PartFile>)> {
    if let RecordingStore::Bucket(_) = &state.recordings {
        let path = state.config.uploads_dir().join(format!("{}.part", Uuid::new_v4()));
        let file = File::create_new(&path).await?;
        return Ok((file, Some(PartFile { path, kept: false })));
    }
    let mut file = File::options().write(true).open(place(state, upload.id)).await?;
    // Bytes beyond the counted ones may be corrupt after a crash, so discard them.
    file.set_len(upload.received.unsigned_abs()).await?;
    file.seek(SeekFrom::End(0)).await?;
    Ok((file, None))
}

/// Sends a chunk to the bucket, if there is one, and returns its object name.
pub(super) async fn send(state: &Service, id: UploadId, piece: &Path) -> Result<Option<String>, Error> {
    match &state.recordings {
        RecordingStore::Folder(_) => Ok(None),
        RecordingStore::Bucket(bucket) => Ok(Some(bucket.keep_piece(piece, id).await?)),
    }
}

/// Updates the number of received bytes in the row of an upload, and records the object of the
/// chunk.
pub(super) async fn count(state: &Service, upload: &Upload, begins: i64, object: Option<&str>) -> Result<(), Error> {
    let mut tx = state.db.write().await?;
    match object {
        None => uploads::advance_upload(&mut tx, upload).await?,
        Some(object) if uploads::add_piece(&mut tx, upload, begins, object).await? => {}
        // Another replica has written at this offset; within this process there is only one writer.
        Some(_) => return Err(Error::Conflict("another request has taken over this upload".to_owned())),
    }
    Ok(tx.commit().await?)
}

/// Opens a complete upload.
pub(super) async fn collect(state: &Service, upload: &Upload) -> Result<Received, Error> {
    match &state.recordings {
        RecordingStore::Folder(_) => {
            let (path, id) = (place(state, upload.id), upload.id);
            Ok(tokio::task::spawn_blocking(move || Received::of_upload(path, id)).await??)
        }
        RecordingStore::Bucket(bucket) => {
            let pieces = uploads::list_pieces(state.db.reader(), upload).await?;
            let received = Received::of_pieces(bucket, upload.id, &pieces).await?;
            if received.size == upload.length.unsigned_abs() {
                return Ok(received);
            }
            let (there, id) = (received.size, upload.id);
            Err(anyhow::anyhow!("{there} of {} bytes are in the chunks of upload {id}", upload.length).into())
        }
    }
}

/// Deletes the bytes of an upload.
pub(super) async fn remove(state: &Service, id: UploadId) -> Result<(), Error> {
    match &state.recordings {
        RecordingStore::Folder(_) => Ok(delete(place(state, id)).await?),
        RecordingStore::Bucket(bucket) => Ok(bucket.remove_pieces(id).await?),
    }
}

/// Deletes the bytes of uploads without a row, left by a crash.
pub(super) async fn clear_unknown(state: &Service) -> Result<(), Error> {
    let there = match &state.recordings {
        RecordingStore::Folder(_) => list_files(state).await?,
        RecordingStore::Bucket(bucket) => bucket.list_uploads().await?,
    };
    for id in there {
        let Some(_turn) = state.turns.take(id) else { continue };
        if uploads::find_upload_by_id(state.db.reader(), id).await?.is_none() {
            remove(state, id).await?;
        }
    }
    Ok(())
}

/// Lists the uploads that have a file.
async fn list_files(state: &Service) -> std::io::Result<Vec<UploadId>> {
    let mut entries = tokio::fs::read_dir(state.config.uploads_dir()).await?;
    let mut found = Vec::new();
    while let Some(entry) = entries.next_entry().await? {
        let path = entry.path();
        let ours = path.extension().is_some_and(|extension| extension == EXTENSION);
        let id = path.file_stem().and_then(|stem| stem.to_string_lossy().parse::<UploadId>().ok());
        found.extend(id.filter(|_| ours));
    }
    Ok(found)
}

async fn delete(path: PathBuf) -> std::io::Result<()> {
    match tokio::fs::remove_file(path).await {
        Err(error) if error.kind() != std::io::ErrorKind::NotFound => Err(error),
        _ => Ok(()),
    }
}
