//! Storage of recordings and the files derived from them: a folder, or an S3-compatible bucket.
//!
//! A bucket holds recordings, upload chunks and replays under different prefixes. Objects that must
//! be read as files are downloaded to temporary files, and uploads pass through a local folder.

#[cfg_attr(not(feature = "replicas"), path = "no_bucket.rs")]
mod bucket;
mod error;
mod stored;

use std::io::ErrorKind;
use std::path::{Path, PathBuf};

pub use bucket::Bucket;
pub use error::StoreError;
use model::ids::{SchoolId, SessionId, UploadId};
use store::privacy::texts::ErasedRecording;
pub use stored::{StoredFile, StoredObject};
use uuid::Uuid;

use crate::config::Config;
use crate::files::{PartFile, hash_file, remove_folder, remove_if_there};
use crate::replay_files;

/// Prefix of the recordings in a bucket.
const RECORDINGS: &str = "recordings";
/// Prefix of the upload chunks in a bucket.
const UPLOADS: &str = "uploads";
/// Prefix of the replays in a bucket.
const REPLAYS: &str = "replays";

/// Storage of recordings and of files derived from them.
#[derive(Clone, Debug)]
pub enum RecordingStore {
    /// In a folder.
    Folder(PathBuf),
    /// In a bucket.
    Bucket(Bucket),
}

/// A recording available as a local file; a temporary copy is deleted on drop.
#[derive(Debug)]
pub struct LocalRecording {
    path: PathBuf,
    _copy: Option<PartFile>,
}

impl LocalRecording {
    /// Path of the file.
    #[must_use]
    pub fn path(&self) -> &Path {
        &self.path
    }
}

impl RecordingStore {
    /// Opens the configured store without contacting it.
    ///
    /// # Errors
    /// Fails if a setting of the bucket is invalid.
    pub fn open(config: &Config) -> anyhow::Result<Self> {
        Ok(match &config.bucket {
            None => Self::Folder(config.recordings_dir.clone()),
            Some(address) => Self::Bucket(Bucket::open(address, config.uploads_dir())?),
        })
    }

    /// Returns the location, for messages: a folder or an address.
    #[must_use]
    pub fn place(&self) -> String {
        match self {
            Self::Folder(folder) => folder.display().to_string(),
            Self::Bucket(bucket) => bucket.address().to_string(),
        }
    }

    /// Returns the name of a new recording. In a bucket it contains the hash, so that different
    /// recordings uploaded under one session id get different objects.
    #[must_use]
    pub fn name_recording(&self, school: SchoolId, session: SessionId, sha256: &str) -> String {
        match self {
            Self::Folder(_) => format!("{school}/{session}.mcap"),
            Self::Bucket(_) => format!("{school}/{session}-{sha256}.mcap"),
        }
    }

    /// Returns a recording as a local file.
    ///
    /// # Errors
    /// Fails if it cannot be downloaded from the bucket. In a folder, a missing file is only
    /// noticed when it is opened.
    pub async fn fetch(&self, recording: &str) -> Result<LocalRecording, StoreError> {
        match self {
            Self::Folder(folder) => Ok(LocalRecording { path: folder.join(recording), _copy: None }),
            Self::Bucket(bucket) => {
                let copy = bucket.fetch(&format!("{RECORDINGS}/{recording}")).await?;
                Ok(LocalRecording { path: copy.path.clone(), _copy: Some(copy) })
            }
        }
    }

    /// Returns a recording for reading as a whole or by ranges.
    ///
    /// # Errors
    /// Fails if the bucket does not respond or lacks the recording. In a folder, a missing file is
    /// only noticed when it is opened.
    pub async fn find(&self, recording: &str) -> Result<StoredFile, StoreError> {
        match self {
            Self::Folder(folder) => Ok(StoredFile::Local(folder.join(recording))),
            Self::Bucket(bucket) => {
                let name = format!("{RECORDINGS}/{recording}");
                StoredFile::in_bucket(bucket, name).await?.ok_or(StoreError::Missing)
            }
        }
    }

    /// Returns the SHA-256 of a recording, lower-case hexadecimal, and its size in bytes. May
    /// block.
    ///
    /// # Errors
    /// Fails if it cannot be read.
    pub async fn hash(&self, recording: &str) -> Result<(String, u64), StoreError> {
        match self {
            Self::Folder(folder) => Ok(hash_file(&folder.join(recording))?),
            Self::Bucket(bucket) => bucket.hash(&format!("{RECORDINGS}/{recording}")).await,
        }
    }

    /// Lists the recordings of all schools, sorted. May block.
    ///
    /// # Errors
    /// Fails if the folder cannot be read, or the bucket does not respond.
    pub async fn list(&self) -> Result<Vec<String>, StoreError> {
        match self {
            Self::Folder(folder) => Ok(recordings_in(folder)?),
            Self::Bucket(bucket) => {
                let mut found = bucket.list(RECORDINGS).await?;
                found.retain(|name| name.ends_with(".mcap"));
                found.sort();
                Ok(found)
            }
        }
    }

    /// Copies a file into the store and verifies the copy. When this returns, the recording is
    /// durable. May block.
    ///
    /// # Errors
    /// Fails if the disk or the bucket fails or is full, or if the hash of the copy differs.
    pub async fn keep_copy(&self, file: &Path, recording: &str, sha256: &str) -> Result<(), StoreError> {
        match self {
            Self::Folder(folder) => Ok(copy_file(file, &folder.join(recording), sha256)?),
            Self::Bucket(bucket) => bucket.keep_recording(file, recording, sha256).await,
        }
    }

    /// Deletes recordings and the files derived from them.
    ///
    /// # Errors
    /// Fails if the disk fails, or the bucket does not respond.
    pub async fn remove(&self, config: &Config, gone: Vec<ErasedRecording>) -> Result<(), StoreError> {
        match self {
            Self::Folder(folder) => {
                let (folder, replays) = (folder.clone(), config.replays_dir());
                let removed = tokio::task::spawn_blocking(move || remove_files(&folder, &replays, &gone));
                Ok(removed.await.map_err(std::io::Error::other)??)
            }
            Self::Bucket(bucket) => {
                let names = gone.iter().flat_map(|ErasedRecording { recording_path, recording_sha256 }| {
                    let replay = replay_files::ALL.map(|file| name_replay(recording_sha256, file));
                    std::iter::once(format!("{RECORDINGS}/{recording_path}")).chain(replay)
                });
                bucket.remove(names.collect()).await
            }
        }
    }

    /// Checks that a bucket responds; does nothing for a folder.
    ///
    /// # Errors
    /// Fails if the bucket does not respond or does not exist.
    pub async fn check(&self) -> Result<(), StoreError> {
        match self {
            Self::Folder(_) => Ok(()),
            Self::Bucket(bucket) => bucket.check().await,
        }
    }

    /// Returns a file of the replay of a recording, by the recording's hash; `None` if the replay
    /// has not been made.
    ///
    /// # Errors
    /// Fails if the disk fails, or the bucket does not respond.
    pub async fn find_replay(
        &self,
        config: &Config,
        sha256: &str,
        file: &str,
    ) -> Result<Option<StoredFile>, StoreError> {
        match self {
            Self::Folder(_) => {
                let folder = replay_files::folder_of(config, sha256);
                Ok(tokio::fs::try_exists(&folder).await?.then(|| StoredFile::Local(folder.join(file))))
            }
            Self::Bucket(bucket) => StoredFile::in_bucket(bucket, name_replay(sha256, file)).await,
        }
    }

    /// Moves a replay from its local folder to the bucket, if recordings are stored in one.
    ///
    /// # Errors
    /// Fails if the disk fails, or the bucket does not respond.
    pub async fn keep_replay(&self, config: &Config, sha256: &str) -> Result<(), StoreError> {
        let Self::Bucket(bucket) = self else { return Ok(()) };
        let folder = replay_files::folder_of(config, sha256);
        for file in replay_files::ALL {
            bucket.send(&folder.join(file), &name_replay(sha256, file)).await?;
        }
        Ok(remove_folder(&folder)?)
    }
}

impl Bucket {
    /// Uploads a recording and verifies it by reading it back.
    ///
    /// # Errors
    /// Fails if the store does not respond or is full.
    pub async fn keep_recording(&self, file: &Path, recording: &str, sha256: &str) -> Result<(), StoreError> {
        self.send_and_check(file, &format!("{RECORDINGS}/{recording}"), sha256).await
    }

    /// Uploads a chunk of a resumable upload and returns its object name, which is unique even
    /// among concurrent requests.
    ///
    /// # Errors
    /// Fails if the store does not respond or is full.
    pub async fn keep_piece(&self, file: &Path, upload: UploadId) -> Result<String, StoreError> {
        let name = format!("{UPLOADS}/{upload}/{}", Uuid::new_v4());
        self.send(file, &name).await?;
        Ok(name)
    }

    /// Concatenates the chunks of an upload into a file. Returns it with its SHA-256, lower-case
    /// hexadecimal.
    pub async fn join_pieces(&self, pieces: &[String]) -> Result<(PartFile, String), StoreError> {
        self.join(pieces).await
    }

    /// Deletes all chunks of an upload.
    ///
    /// # Errors
    /// Fails if the store does not respond.
    pub async fn remove_pieces(&self, upload: UploadId) -> Result<(), StoreError> {
        let folder = format!("{UPLOADS}/{upload}");
        let names = self.list(&folder).await?;
        self.remove(names.iter().map(|name| format!("{folder}/{name}")).collect()).await
    }

    /// Lists the uploads that have chunks.
    ///
    /// # Errors
    /// Fails if the store does not respond.
    pub async fn list_uploads(&self) -> Result<Vec<UploadId>, StoreError> {
        let names = self.list(UPLOADS).await?;
        let mut uploads: Vec<_> = names.iter().filter_map(|name| name.split('/').next()?.parse().ok()).collect();
        uploads.sort();
        uploads.dedup();
        Ok(uploads)
    }
}

/// Copies a file, and renames the copy to its final name once it has been synced and verified.
/// Blocks.
fn copy_file(from: &Path, to: &Path, sha256: &str) -> std::io::Result<()> {
    let folder = to.parent().unwrap_or(Path::new("."));
    std::fs::create_dir_all(folder)?;
    let part = PartFile { path: to.with_extension("part"), kept: false };
    std::fs::copy(from, &part.path)?;
    std::fs::File::open(&part.path)?.sync_all()?;
    if hash_file(&part.path)?.0 != sha256 {
        return Err(std::io::Error::other("the bytes do not match the copied bytes"));
    }
    std::fs::rename(&part.path, to)?;
    std::fs::File::open(folder)?.sync_all()
}

/// Deletes recordings and their replays in a folder. Blocks.
fn remove_files(folder: &Path, replays: &Path, gone: &[ErasedRecording]) -> std::io::Result<()> {
    for ErasedRecording { recording_path, recording_sha256 } in gone {
        remove_if_there(&folder.join(recording_path))?;
        remove_folder(&replays.join(replay_files::name_of(recording_sha256)))?;
    }
    Ok(())
}

fn name_replay(sha256: &str, file: &str) -> String {
    format!("{REPLAYS}/{}/{file}", replay_files::name_of(sha256))
}

/// Lists the recordings in the schools' folders, by the paths that rows use.
fn recordings_in(folder: &Path) -> std::io::Result<Vec<String>> {
    let mut found = Vec::new();
    for school in entries(folder)?.iter().filter(|name| name.parse::<SchoolId>().is_ok()) {
        let recordings = entries(&folder.join(school))?;
        found.extend(recordings.iter().filter(|name| name.ends_with(".mcap")).map(|name| format!("{school}/{name}")));
    }
    Ok(found)
}

/// Lists the names in a folder, sorted; empty if it does not exist.
fn entries(folder: &Path) -> std::io::Result<Vec<String>> {
    let entries = match std::fs::read_dir(folder) {
        Err(error) if error.kind() == ErrorKind::NotFound => return Ok(Vec::new()),
        entries => entries?,
    };
    let mut names = entries
        .map(|entry| Ok(entry?.file_name().to_string_lossy().into_owned()))
        .collect::<std::io::Result<Vec<_>>>()?;
    names.sort();
    Ok(names)
}
