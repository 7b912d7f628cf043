//! Where the bytes of an upload in pieces lie: in a file of its own, or in a bucket, each piece an object of its own, of which the
//! database says that they count.

use std::io::SeekFrom;
use std::path::{Path, PathBuf};

use model::ids::UploadId;
use store::uploads::{self, Upload};
use tokio::fs::File;
use tokio::io::AsyncSeekExt;
use uuid::Uuid;

use crate::error::Error;
use crate::recording_store::RecordingStore;
use crate::recordings::Received;
use crate::removing::PartFile;
use crate::service::Service;

/// What the file of an unfinished upload ends in. At the start, `recordings::clear_uploads` deletes `part` files.
const EXTENSION: &str = "tus";

/// The file of an upload.
fn place(state: &Service, id: UploadId) -> PathBuf {
    state.config.uploads_dir().join(format!("{id}.{EXTENSION}"))
}

/// Makes room for an upload that begins.
pub(super) async fn begin(state: &Service, id: UploadId) -> std::io::Result<()> {
    if let RecordingStore::Folder(_) = &state.recordings {
        File::create_new(place(state, id)).await?;
        File::open(state.config.uploads_dir()).await?.sync_all().await?;
    }
    Ok(())
}

/// Whether the bytes of an upload are gone without its row.
pub(super) async fn is_lost(state: &Service, id: UploadId) -> std::io::Result<bool> {
    match &state.recordings {
        RecordingStore::Folder(_) => Ok(!tokio::fs::try_exists(place(state, id)).await?),
        RecordingStore::Bucket(_) => Ok(false),
    }
}

/// The file that the next bytes of an upload are written to: its own, or one for what is not in the bucket yet.
pub(super) async fn open(state: &Service, upload: &Upload) -> std::io::Result<(File, Option<PartFile>)> {
    if let RecordingStore::Bucket(_) = &state.recordings {
        let path = state.config.uploads_dir().join(format!("{}.part", Uuid::new_v4()));
        let file = File::create_new(&path).await?;
        return Ok((file, Some(PartFile { path, kept: false })));
    }
    let mut file = File::options().write(true).open(place(state, upload.id)).await?;
    // What a crash left beyond the received bytes is not known to be what was sent.
    file.set_len(upload.received.unsigned_abs()).await?;
    file.seek(SeekFrom::End(0)).await?;
    Ok((file, None))
}

/// Makes an object of a piece; its name.
pub(super) async fn send(state: &Service, id: UploadId, piece: &Path) -> Result<Option<String>, Error> {
    match &state.recordings {
        RecordingStore::Folder(_) => Ok(None),
        RecordingStore::Bucket(bucket) => Ok(Some(bucket.keep_piece(piece, id).await?)),
    }
}

/// Says in the row of an upload how far it has come, and which object it has come by.
pub(super) async fn count(state: &Service, upload: &Upload, begins: i64, object: Option<&str>) -> Result<(), Error> {
    let mut tx = state.db.write().await?;
    match object {
        None => uploads::advance_upload(&mut tx, upload).await?,
        Some(object) if uploads::add_piece(&mut tx, upload, begins, object).await? => {}
        // Another service, for here there is one writer at a time.
        Some(_) => return Err(Error::Conflict("another request has taken this upload over".to_owned())),
    }
    Ok(tx.commit().await?)
}

/// An upload that is whole.
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
            Err(anyhow::anyhow!("{there} bytes of {} are in the pieces of upload {id}", upload.length).into())
        }
    }
}

/// Removes the bytes of an upload, whose row goes or says what it has become.
pub(super) async fn remove(state: &Service, id: UploadId) -> Result<(), Error> {
    match &state.recordings {
        RecordingStore::Folder(_) => Ok(delete(place(state, id)).await?),
        RecordingStore::Bucket(bucket) => Ok(bucket.remove_pieces(id).await?),
    }
}

/// Deletes what no row names: a crash came between the two.
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

/// Uploads that have a file.
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
