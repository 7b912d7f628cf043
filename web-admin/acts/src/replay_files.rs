//! What replays need, on disk: named by the hash of the recording, whole or not there.

use std::path::{Path, PathBuf};
use std::{fs, io};

use assessment::own_exercise;
use model::Replay;
use recording::Recording;
use uuid::Uuid;

use crate::config::Config;

/// What does not move, JSON.
pub const STAGE: &str = "stage.json";

/// What moves, a table of floats.
pub const FRAMES: &str = "frames.f32";

/// What is plotted.
pub const PYRAMID: &str = "pyramid.f64";

/// Every file of a replay.
pub const ALL: [&str; 3] = [STAGE, FRAMES, PYRAMID];

/// What the replay of a recording is called, by its hash. Another version of these files is called otherwise.
#[must_use]
pub fn name_of(recording_sha256: &str) -> String {
    format!("{recording_sha256}-6")
}

/// Where the replay of a recording lies on this machine, by its hash.
#[must_use]
pub fn folder_of(config: &Config, recording_sha256: &str) -> PathBuf {
    config.replays_dir().join(name_of(recording_sha256))
}

/// Makes the replay of a recording: all of it under another name first, so that what is there under its own name is whole. Blocks.
///
/// # Errors
/// When the recording carries no exercise, or the disk refuses.
pub fn make(folder: &Path, recording: &Recording) -> anyhow::Result<()> {
    let bundle = own_exercise(recording)?;
    let replay = Replay::of(recording, &bundle);
    let part = folder.with_extension(format!("{}.part", Uuid::new_v4()));
    fs::create_dir_all(&part)?;
    let written = write(&part, &replay).and_then(|()| match fs::rename(&part, folder) {
        // Somebody else has made the same meanwhile.
        Err(_) if folder.is_dir() => fs::remove_dir_all(&part),
        renamed => renamed,
    });
    if written.is_err() {
        // The first failure is told; what is left over is small and named as unfinished.
        let _ = fs::remove_dir_all(&part);
    }
    Ok(written?)
}

fn write(folder: &Path, replay: &Replay) -> io::Result<()> {
    fs::write(folder.join(STAGE), serde_json::to_vec(&replay.stage)?)?;
    fs::write(folder.join(FRAMES), replay.frames.bytes())?;
    fs::write(folder.join(PYRAMID), replay.pyramid.bytes())
}
