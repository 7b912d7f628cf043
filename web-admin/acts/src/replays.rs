//! What replays need, on disk: made when an attempt is scored, named by the hash of its recording, and made again
//! where it is missing.

use std::path::PathBuf;
use std::time::Duration;

use anyhow::Context;
use model::series::Pyramid;
use store::sessions::Session;

use crate::error::Error;
use crate::judging::{Brief, JudgeAnswer, JudgeQuestion, JudgingTask};
use crate::replay_files::{PYRAMID, folder_of};
use crate::service::Service;
use crate::{asking, recordings};

/// Longest wait until it is one's turn to have a replay made.
const PATIENCE: Duration = Duration::from_secs(10);

/// Where a session's replay lies. Another version of these files lies elsewhere.
#[must_use]
pub fn folder(state: &Service, session: &Session) -> PathBuf {
    folder_of(&state.config, &session.recording_sha256)
}

/// What whoever judges a session's recording must know.
#[must_use]
pub fn brief(state: &Service, session: &Session, task: JudgingTask) -> Brief {
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
        match asking::ask(state, JudgeQuestion::Recording(brief(state, session, JudgingTask::Replay))).await? {
            JudgeAnswer::Replayed => {}
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
