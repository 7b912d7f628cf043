//! Where recordings lie, and what was made of them: in a folder, or in a bucket of a store that speaks S3.
//!
//! In a bucket recordings, pieces of uploads and replays lie beside each other. Whatever must be a file to be read is fetched for
//! as long as somebody reads it; a file that is sent goes by a folder of this machine, too.

#[cfg_attr(not(feature = "replicas"), path = "no_bucket.rs")]
mod bucket;
mod error;
mod stored;

use std::io::ErrorKind;
use std::path::{Path, PathBuf};

pub use bucket::Bucket;
pub use error::StoreError;
use model::ids::{SchoolId, SessionId, UploadId};
use store::texts::ErasedRecording;
pub use stored::{StoredFile, StoredObject};
use uuid::Uuid;

use crate::config::Config;
use crate::recording_files::hash_file;
use crate::removing::{PartFile, remove_folder, remove_if_there};
use crate::replay_files;

/// Folder of the recordings in a bucket.
const RECORDINGS: &str = "recordings";
/// Folder of the pieces of uploads in a bucket.
const UPLOADS: &str = "uploads";
/// Folder of the replays in a bucket.
const REPLAYS: &str = "replays";

/// Where recordings lie, and what was made of them.
#[derive(Clone, Debug)]
pub enum RecordingStore {
    /// In a folder.
    Folder(PathBuf),
    /// In a bucket.
    Bucket(Bucket),
}

/// A recording that can be read as a file, for as long as this is kept.
#[derive(Debug)]
pub struct LocalRecording {
    path: PathBuf,
    _copy: Option<PartFile>,
}

impl LocalRecording {
    /// The file.
    #[must_use]
    pub fn path(&self) -> &Path {
        &self.path
    }
}

impl RecordingStore {
    /// The store that a configuration names; nobody is asked yet whether it is there.
    ///
    /// # Errors
    /// When a setting of a bucket makes no sense.
    pub fn open(config: &Config) -> anyhow::Result<Self> {
        Ok(match &config.bucket {
            None => Self::Folder(config.recordings_dir.clone()),
            Some(address) => Self::Bucket(Bucket::open(address, config.uploads_dir())?),
        })
    }

    /// In words for people: a folder, or an address.
    #[must_use]
    pub fn place(&self) -> String {
        match self {
            Self::Folder(folder) => folder.display().to_string(),
            Self::Bucket(bucket) => bucket.address().to_string(),
        }
    }

    /// The name of a recording that is new. In a bucket it tells the bytes, too: two that are sent under one id never meet there.
    #[must_use]
    pub fn name_recording(&self, school: SchoolId, session: SessionId, sha256: &str) -> String {
        match self {
            Self::Folder(_) => format!("{school}/{session}.mcap"),
            Self::Bucket(_) => format!("{school}/{session}-{sha256}.mcap"),
        }
    }

    /// A recording as a file.
    ///
    /// # Errors
    /// When a bucket does not give it. A folder is not asked: whoever opens the file is told.
    pub async fn fetch(&self, recording: &str) -> Result<LocalRecording, StoreError> {
        match self {
            Self::Folder(folder) => Ok(LocalRecording { path: folder.join(recording), _copy: None }),
            Self::Bucket(bucket) => {
                let copy = bucket.fetch(&format!("{RECORDINGS}/{recording}")).await?;
                Ok(LocalRecording { path: copy.path.clone(), _copy: Some(copy) })
            }
        }
    }

    /// A recording, to be read whole or in ranges.
    ///
    /// # Errors
    /// When a bucket does not answer, or has none. A folder is not asked.
    pub async fn find(&self, recording: &str) -> Result<StoredFile, StoreError> {
        match self {
            Self::Folder(folder) => Ok(StoredFile::Local(folder.join(recording))),
            Self::Bucket(bucket) => {
                let name = format!("{RECORDINGS}/{recording}");
                StoredFile::in_bucket(bucket, name).await?.ok_or(StoreError::Missing)
            }
        }
    }

    /// SHA-256 of a recording, lower-case hexadecimal, and its size in bytes. May block.
    ///
    /// # Errors
    /// When it cannot be read.
    pub async fn hash(&self, recording: &str) -> Result<(String, u64), StoreError> {
        match self {
            Self::Folder(folder) => Ok(hash_file(&folder.join(recording))?),
            Self::Bucket(bucket) => bucket.hash(&format!("{RECORDINGS}/{recording}")).await,
        }
    }

    /// Every recording of every school, in order. May block.
    ///
    /// # Errors
    /// When the folder cannot be read, or the bucket does not answer.
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

    /// Makes a recording of a file under a name, which is there whole when this returns, and was read back. May block.
    ///
    /// # Errors
    /// When the disk refuses, the bucket does not answer or has no room, or other bytes are there than the hash says.
    pub async fn keep_copy(&self, file: &Path, recording: &str, sha256: &str) -> Result<(), StoreError> {
        match self {
            Self::Folder(folder) => Ok(copy_file(file, &folder.join(recording), sha256)?),
            Self::Bucket(bucket) => bucket.keep_recording(file, recording, sha256).await,
        }
    }

    /// Removes recordings and what was made of them.
    ///
    /// # Errors
    /// When the disk refuses, or the bucket does not answer.
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

    /// Whether the store answers; a folder does.
    ///
    /// # Errors
    /// When a bucket does not answer, or is not there.
    pub async fn check(&self) -> Result<(), StoreError> {
        match self {
            Self::Folder(_) => Ok(()),
            Self::Bucket(bucket) => bucket.check().await,
        }
    }

    /// A file of the replay of a recording, by the recording's hash; none where the replay is not made.
    ///
    /// # Errors
    /// When the disk fails, or the bucket does not answer.
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

    /// Keeps a replay that was made in its folder on this machine: in a bucket where recordings are, and no longer here.
    ///
    /// # Errors
    /// When the disk fails, or the bucket does not answer.
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
    /// Makes a recording of a file, which is there whole when this returns, and was read back.
    ///
    /// # Errors
    /// When the store does not answer, or has no room.
    pub async fn keep_recording(&self, file: &Path, recording: &str, sha256: &str) -> Result<(), StoreError> {
        self.send_and_check(file, &format!("{RECORDINGS}/{recording}"), sha256).await
    }

    /// Makes a piece of an upload of a file; its name. No other piece has it, whoever sends at the same time.
    ///
    /// # Errors
    /// When the store does not answer, or has no room.
    pub async fn keep_piece(&self, file: &Path, upload: UploadId) -> Result<String, StoreError> {
        let name = format!("{UPLOADS}/{upload}/{}", Uuid::new_v4());
        self.send(file, &name).await?;
        Ok(name)
    }

    /// The pieces of an upload as one file, with its SHA-256 in lower-case hexadecimal.
    pub(crate) async fn join_pieces(&self, pieces: &[String]) -> Result<(PartFile, String), StoreError> {
        self.join(pieces).await
    }

    /// Removes every piece of an upload.
    ///
    /// # Errors
    /// When the store does not answer.
    pub async fn remove_pieces(&self, upload: UploadId) -> Result<(), StoreError> {
        let folder = format!("{UPLOADS}/{upload}");
        let names = self.list(&folder).await?;
        self.remove(names.iter().map(|name| format!("{folder}/{name}")).collect()).await
    }

    /// Uploads of which there are pieces.
    ///
    /// # Errors
    /// When the store does not answer.
    pub async fn list_uploads(&self) -> Result<Vec<UploadId>, StoreError> {
        let names = self.list(UPLOADS).await?;
        let mut uploads: Vec<_> = names.iter().filter_map(|name| name.split('/').next()?.parse().ok()).collect();
        uploads.sort();
        uploads.dedup();
        Ok(uploads)
    }
}

/// Copies a file, which gets its name when it is on the disk and was read back. Blocks.
fn copy_file(from: &Path, to: &Path, sha256: &str) -> std::io::Result<()> {
    let folder = to.parent().unwrap_or(Path::new("."));
    std::fs::create_dir_all(folder)?;
    let part = PartFile { path: to.with_extension("part"), kept: false };
    std::fs::copy(from, &part.path)?;
    std::fs::File::open(&part.path)?.sync_all()?;
    if hash_file(&part.path)?.0 != sha256 {
        return Err(std::io::Error::other("other bytes are there than were copied"));
    }
    std::fs::rename(&part.path, to)?;
    std::fs::File::open(folder)?.sync_all()
}

/// Removes recordings of a folder, and their replays. Blocks.
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

/// Every recording in the folders of the schools, as rows name them.
fn recordings_in(folder: &Path) -> std::io::Result<Vec<String>> {
    let mut found = Vec::new();
    for school in entries(folder)?.iter().filter(|name| name.parse::<SchoolId>().is_ok()) {
        let recordings = entries(&folder.join(school))?;
        found.extend(recordings.iter().filter(|name| name.ends_with(".mcap")).map(|name| format!("{school}/{name}")));
    }
    Ok(found)
}

/// Names in a folder, in order; none of one that is not there.
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
