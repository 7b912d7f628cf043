//! Replay files on disk, named by the hash of the recording. A replay appears atomically.

use std::path::{Path, PathBuf};
use std::{fs, io};

use assessment::own_exercise;
use model::Replay;
use recording::Recording;
use uuid::Uuid;

use crate::platform::config::Config;

/// The static scene, JSON.
pub const STAGE: &str = "stage.json";

/// The moving parts per frame, a table of 32-bit floats.
pub const FRAMES: &str = "frames.f32";

/// The plotted curves at several resolutions, 64-bit floats.
pub const PYRAMID: &str = "pyramid.f64";

/// All files of a replay.
pub const ALL: [&str; 3] = [STAGE, FRAMES, PYRAMID];

/// Returns the folder name of a replay, by the hash of its recording. The suffix is the version of
/// the file format.
#[must_use]
pub fn name_of(recording_sha256: &str) -> String {
    format!("{recording_sha256}-6")
}

/// Returns the local folder of a replay, by the hash of its recording.
#[must_use]
pub fn folder_of(config: &Config, recording_sha256: &str) -> PathBuf {
    config.replays_dir().join(name_of(recording_sha256))
}

/// Writes the replay of a recording: first under a temporary name, then renamed, so that a folder
/// with the final name is always complete. Blocks.
///
/// # Errors
/// Fails if the recording does not contain its exercise, or the disk fails.
pub fn make(folder: &Path, recording: &Recording) -> anyhow::Result<()> {
    let bundle = own_exercise(recording)?;
    let replay = Replay::of(recording, &bundle);
    let part = folder.with_extension(format!("{}.part", Uuid::new_v4()));
    fs::create_dir_all(&part)?;
    let written = write(&part, &replay).and_then(|()| match fs::rename(&part, folder) {
        // Another process has written the same replay in the meantime.
        Err(_) if folder.is_dir() => fs::remove_dir_all(&part),
        renamed => renamed,
    });
    if written.is_err() {
        // Report the first error only; the leftover folder is small and marked as incomplete by its
        // name.
        let _ = fs::remove_dir_all(&part);
    }
    Ok(written?)
}

fn write(folder: &Path, replay: &Replay) -> io::Result<()> {
    fs::write(folder.join(STAGE), serde_json::to_vec(&replay.stage)?)?;
    fs::write(folder.join(FRAMES), replay.frames.bytes())?;
    fs::write(folder.join(PYRAMID), replay.pyramid.bytes())
}
