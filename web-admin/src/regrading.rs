//! Grading an attempt again, by the rubric that its exercise has now: an act of its own, shown before it is done.
//!
//! What was asked of the trainee stays as it was: only lines, limits and pass mark are those of today.

use anyhow::Context;
use assessment::{Assessment, assess, own_exercise};
use scene::ExerciseBundle;
use serde_json::json;

use crate::AppState;
use crate::error::Error;
use crate::recordings;
use crate::storage::audit::{Actor, Entry};
use crate::storage::sessions::Session;
use crate::storage::{exercises, practice, scores};

/// What an attempt would score by the rubric that its exercise has now. None where the school no longer teaches it.
///
/// # Errors
/// When the recording cannot be read or judged.
pub async fn preview(state: &AppState, session: &Session) -> Result<Option<Assessment>, Error> {
    let reader = state.db.reader();
    let Some(taught) = exercises::current(reader, session.school_id, &session.exercise_id).await? else {
        return Ok(None);
    };
    let bytes =
        exercises::bytes(reader, session.school_id, taught.id).await?.context("a revision without documents")?;
    let rubric = ExerciseBundle::from_parts(&bytes.exercise, &bytes.scene, &bytes.meshes);
    let rubric = rubric.map_err(|refused| anyhow::Error::new(refused).context("a published exercise is refused"))?;
    let path = state.config.recordings_dir.join(&session.recording_path);
    let judged = recordings::with(state, path, move |recording| {
        let mut tried = own_exercise(&recording)?;
        tried.exercise.rubric = rubric.exercise.rubric;
        tried.exercise.hard_fails = rubric.exercise.hard_fails;
        tried.exercise.pass_mark = rubric.exercise.pass_mark;
        assess(&recording, &tried)
    });
    let judged = judged.await?.map_err(|error| anyhow::Error::from(error).context("a stored recording"))?;
    Ok(Some(judged.map_err(|refused| Error::Unprocessable(refused.to_string()))?))
}

/// Adds a score; earlier ones stay.
///
/// # Errors
/// When the database fails.
pub async fn apply(state: &AppState, actor: Actor, session: &Session, again: &Assessment) -> Result<(), Error> {
    let now = state.clock.now();
    let mut tx = state.db.write().await?;
    let before = scores::newest(&mut *tx, session.key()).await?;
    scores::add(&mut tx, session.key(), again, now).await?;
    practice::refresh(&mut tx, session.key()).await?;
    Entry::new(session.school_id, actor, "session.regraded", session.id)
        .with(json!({
            "from": before.map(|score| score.score),
            "to": again.score,
            "rubric_sha256": again.rubric.sha256,
        }))
        .append(&mut tx, now)
        .await?;
    Ok(tx.commit().await?)
}
