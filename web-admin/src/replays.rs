//! What replays need, on disk: made when an attempt is scored, named by the hash of its recording, and made again
//! where it is missing.

use std::fs;
use std::io;
use std::path::{Path, PathBuf};

use anyhow::Context;
use assessment::own_exercise;
use recording::Recording;
use uuid::Uuid;

use crate::AppState;
use crate::domain::Replay;
use crate::domain::series::Pyramid;
use crate::error::Error;
use crate::recordings;
use crate::storage::sessions::Session;

/// What does not move, JSON.
pub const STAGE: &str = "stage.json";
/// What moves, a table of floats.
pub const FRAMES: &str = "frames.f32";
/// What is plotted.
const PYRAMID: &str = "pyramid.f64";

/// Where a session's replay lies. Another version of these files lies elsewhere.
#[must_use]
pub fn folder(state: &AppState, session: &Session) -> PathBuf {
    state.config.replays_dir().join(format!("{}-2", session.recording_sha256))
}

/// Makes the replay of a recording. A failure is no reason not to score it: it is noted, and tried again when somebody
/// wants to watch. Blocks.
pub fn keep(folder: &Path, recording: &Recording) {
    if let Err(error) = make(folder, recording) {
        tracing::warn!(session = %recording.session.session_id, cause = format!("{error:#}"), "no replay was kept");
    }
}

/// A file of a session's replay, which is made where it is missing.
///
/// # Errors
/// When the recording cannot be read or the disk refuses.
pub async fn file(state: &AppState, session: &Session, name: &str) -> Result<PathBuf, Error> {
    let folder = folder(state, session);
    if !tokio::fs::try_exists(&folder).await? {
        let (path, place) = (state.config.recordings_dir.join(&session.recording_path), folder.clone());
        let made = recordings::with(state, path, move |recording| make(&place, &recording)).await?;
        made.map_err(|error| anyhow::Error::from(error).context("a stored recording"))??;
    }
    Ok(folder.join(name))
}

/// The pyramid of a session.
///
/// # Errors
/// As [`file`]; and when the file is none.
pub async fn pyramid(state: &AppState, session: &Session) -> Result<Pyramid, Error> {
    let bytes = tokio::fs::read(file(state, session, PYRAMID).await?).await?;
    Ok(Pyramid::from_bytes(bytes).context("a replay's pyramid is damaged: delete the folder of replays")?)
}

/// Writes all of it under another name first: what is there under its own name is whole.
fn make(folder: &Path, recording: &Recording) -> anyhow::Result<()> {
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
