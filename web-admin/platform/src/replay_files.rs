//! The names of replay files, which are named by the hash of the recording.

use std::path::PathBuf;

use crate::config::Config;

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
