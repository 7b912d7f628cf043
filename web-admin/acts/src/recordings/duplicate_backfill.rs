//! Backfills motion hashes for attempts recorded before duplicate detection existed, while no other
//! job is waiting. Afterwards a repeated upload of such a recording is detected, and of two old
//! attempts with the same motion the first one counts.

use anyhow::Context;
use data_encoding::HEXLOWER;
use model::SessionKey;
use serde_json::json;
use store::Connection;
use store::audit::{Actor, AuditEntry};
use store::recordings::sessions::{Session, SessionState};
use store::recordings::{duplicate_backfill, sessions};
use store::training::practice;

use crate::sandbox;
use crate::sandbox_jobs::{RecordingFacts, SandboxRequest, SandboxResponse};
use crate::service::Service;

/// Hashes the motion of one attempt. Returns false if none is left.
///
/// # Errors
/// Fails if the database fails, or the helper cannot be started.
pub async fn step(state: &Service) -> anyhow::Result<bool> {
    let Some(session) = duplicate_backfill::list_unhashed_motions(state.db.reader()).await? else { return Ok(false) };
    let motion = read(state, &session).await?;
    let mut tx = state.db.write().await?;
    if let Some(motion) = motion {
        compare(state, &mut tx, &session, &motion).await?;
    }
    duplicate_backfill::mark_motions_done(&mut tx, session.key()).await?;
    tx.commit().await?;
    Ok(true)
}

/// Returns the motion hash of an attempt; `None` without samples or if the recording cannot be
/// read, in which case the attempt is not compared.
async fn read(state: &Service, session: &Session) -> anyhow::Result<Option<String>> {
    let recording = state.recordings.fetch(&session.recording_path).await?;
    match sandbox::ask(state, SandboxRequest::Arrival(recording.path().to_owned())).await? {
        SandboxResponse::Metadata(reported) => {
            Ok(RecordingFacts::try_from(*reported)?.hashes.map(|hashes| HEXLOWER.encode(&hashes.motion)))
        }
        other => {
            tracing::warn!(session = %session.id, answer = format!("{other:?}"), "no earlier movement to compare with");
            Ok(None)
        }
    }
}

/// Sets an attempt's hash. If another counted attempt has the same hash, the later one becomes a
/// duplicate.
async fn compare(state: &Service, tx: &mut Connection, session: &Session, motion: &str) -> anyhow::Result<()> {
    let own = session.key();
    let same = match session.uncounted {
        Some(_) => None,
        None => sessions::find_session_of_motion(&mut *tx, own.school_id, motion).await?,
    };
    if let Some(same) = same {
        let other = sessions::find_session(&mut *tx, own.school_id, same).await?.context("an attempt that is gone")?;
        let is_first = duplicate_backfill::find_earlier_motion(&mut *tx, own, other.key()).await?;
        let (first, later) = if is_first { (session, &other) } else { (&other, session) };
        mark_duplicate(state, tx, first.key(), later).await?;
    }
    Ok(duplicate_backfill::set_motion(tx, own, motion).await?)
}

/// Marks a counted attempt as a duplicate of another, and subtracts it from its trainee's totals.
pub(crate) async fn mark_duplicate(
    state: &Service,
    tx: &mut Connection,
    original: SessionKey,
    duplicate: &Session,
) -> anyhow::Result<()> {
    duplicate_backfill::mark_repeated(tx, duplicate.key(), original).await?;
    if duplicate.state == SessionState::Scored {
        practice::refresh_practice(tx, duplicate.key()).await?;
    }
    AuditEntry::new(duplicate.school_id, Actor::Worker, "session.repeats", duplicate.id)
        .with(json!({ "repeats": original.id }))
        .append(tx, state.clock.now())
        .await?;
    tracing::warn!(session = %duplicate.id, original = %original.id, "duplicate attempt found; it no longer counts");
    Ok(())
}
