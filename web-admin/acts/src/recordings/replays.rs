//! Replays in the recording store: written when an attempt is scored, named by the hash of its
//! recording, and rebuilt on demand if missing.

use std::time::Duration;

use anyhow::Context;
use model::recordings::series::Pyramid;
use platform::recording_store::{LocalRecording, StoreError, StoredFile};
use platform::replay_files::{PYRAMID, folder_of};
use store::recordings::sessions::Session;

use crate::error::Error;
use crate::sandbox_jobs::{Brief, JudgingTask, SandboxRequest, SandboxResponse};
use crate::service::Service;
use crate::{recordings, sandbox};

/// Maximum time in the school's queue for building a replay.
const PATIENCE: Duration = Duration::from_secs(10);

/// Returns the job description for a session's recording, for the helper.
#[must_use]
pub fn brief(state: &Service, session: &Session, recording: &LocalRecording, task: JudgingTask) -> Brief {
    Brief {
        recording: recording.path().to_owned(),
        sha256: session.recording_sha256.clone(),
        replay: folder_of(&state.config, &session.recording_sha256),
        task,
    }
}

/// Returns a file of a session's replay, building the replay if it is missing.
///
/// # Errors
/// Fails if the recording cannot be read, or the disk fails.
pub async fn file(state: &Service, session: &Session, name: &str) -> Result<StoredFile, Error> {
    recordings::refuse_erased(session)?;
    let sha256 = &session.recording_sha256;
    if let Some(found) = state.recordings.find_replay(&state.config, sha256, name).await? {
        return Ok(found);
    }
    make(state, session).await?;
    let made = state.recordings.find_replay(&state.config, sha256, name).await?;
    Ok(made.context("a replay that was just made is not there")?)
}

/// Builds the replay of a session.
async fn make(state: &Service, session: &Session) -> Result<(), Error> {
    let _place = state.helpers.enter(session.school_id, PATIENCE).await?;
    let recording = recordings::fetch(state, session).await?;
    let brief = brief(state, session, &recording, JudgingTask::Replay);
    match sandbox::ask(state, SandboxRequest::Recording(brief)).await? {
        SandboxResponse::Replayed => Ok(keep(state, session).await?),
        other => Err(anyhow::anyhow!("no replay was generated for a stored recording: {other:?}").into()),
    }
}

/// Moves a locally built replay to the recording store.
///
/// # Errors
/// Fails if the bucket does not respond.
pub async fn keep(state: &Service, session: &Session) -> Result<(), StoreError> {
    state.recordings.keep_replay(&state.config, &session.recording_sha256).await
}

/// Returns the curve pyramid of a session's replay.
///
/// # Errors
/// As [`file`]; also fails if the file is damaged.
pub async fn pyramid(state: &Service, session: &Session) -> Result<Pyramid, Error> {
    let bytes = file(state, session, PYRAMID).await?.read_all().await?;
    Ok(Pyramid::from_bytes(bytes).context("a replay's pyramid is damaged: delete the folder of replays")?)
}
