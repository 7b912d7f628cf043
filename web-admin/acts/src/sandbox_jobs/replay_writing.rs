//! Writes the files of a replay. A replay appears atomically.

use std::path::Path;
use std::{fs, io};

use assessment::own_exercise;
use model::Replay;
use platform::replay_files::{FRAMES, PYRAMID, STAGE};
use recording::Recording;
use uuid::Uuid;

/// Writes the replay of a recording: first under a temporary name, then renamed, so that a folder
/// with the final name is always complete. Blocks.
///
/// # Errors
/// Fails if the recording does not contain its exercise, or the disk fails.
pub(crate) fn write_replay(folder: &Path, recording: &Recording) -> anyhow::Result<()> {
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
