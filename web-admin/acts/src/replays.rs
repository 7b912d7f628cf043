//! What replays need, on disk: made when an attempt is scored, named by the hash of its recording, and made again
//! where it is missing.

use std::fs;
use std::io;
use std::path::{Path, PathBuf};
use std::time::Duration;

use anyhow::Context;
use assessment::own_exercise;
use recording::Recording;
use uuid::Uuid;

use crate::config::Config;
use crate::error::Error;
use crate::judging::{self, Answer, Brief, Question, Task};
use crate::recordings;
use crate::service::Service;
use model::Replay;
use model::series::Pyramid;
use store::sessions::Session;

/// What does not move, JSON.
pub const STAGE: &str = "stage.json";
/// What moves, a table of floats.
pub const FRAMES: &str = "frames.f32";
/// What is plotted.
const PYRAMID: &str = "pyramid.f64";

/// Longest wait until it is one's turn to have a replay made.
const PATIENCE: Duration = Duration::from_secs(10);

/// Where a session's replay lies. Another version of these files lies elsewhere.
#[must_use]
pub fn folder(state: &Service, session: &Session) -> PathBuf {
    folder_of(&state.config, &session.recording_sha256)
}

/// Where the replay of a recording lies, by its hash.
#[must_use]
pub fn folder_of(config: &Config, recording_sha256: &str) -> PathBuf {
    config.replays_dir().join(format!("{recording_sha256}-3"))
}

/// What whoever judges a session's recording must know.
#[must_use]
pub fn brief(state: &Service, session: &Session, task: Task) -> Brief {
    let recording = state.config.recordings_dir.join(&session.recording_path);
    Brief { recording, sha256: session.recording_sha256.clone(), replay: folder(state, session), task }
}

/// A file of a session's replay, which is made where it is missing.
///
/// # Errors
/// When the recording cannot be read or the disk refuses.
pub async fn file(state: &Service, session: &Session, name: &str) -> Result<PathBuf, Error> {
    recordings::file_of(state, session)?;
    let folder = folder(state, session);
    if !tokio::fs::try_exists(&folder).await? {
        let place = state.helpers.enter(session.school_id, PATIENCE).await;
        let _place = place.ok_or(Error::Busy { retry_after_s: PATIENCE.as_secs() })?;
        match judging::ask(state, Question::Recording(brief(state, session, Task::Replay))).await? {
            Answer::Replayed => {}
            other => return Err(anyhow::anyhow!("no replay was made of a stored recording: {other:?}").into()),
        }
    }
    Ok(folder.join(name))
}

/// The pyramid of a session.
///
/// # Errors
/// As [`file`]; and when the file is none.
pub async fn pyramid(state: &Service, session: &Session) -> Result<Pyramid, Error> {
    let bytes = tokio::fs::read(file(state, session, PYRAMID).await?).await?;
    Ok(Pyramid::from_bytes(bytes).context("a replay's pyramid is damaged: delete the folder of replays")?)
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
