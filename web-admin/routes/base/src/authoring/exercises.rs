//! Published exercises.

use acts::error::Error;
use documents::ExerciseBundle;
use model::ids::{RevisionId, SchoolId};
use store::authoring::exercises;

use crate::AppState;

/// Returns a revision as published; `None` if it does not exist. It was validated on publication,
/// so an invalid one is an internal error.
///
/// # Errors
/// When a published document is invalid.
pub async fn published_bundle(
    state: &AppState,
    school: SchoolId,
    revision: RevisionId,
) -> Result<Option<ExerciseBundle>, Error> {
    let Some(bytes) = exercises::read_exercise_bytes(state.db.reader(), school, revision).await? else {
        return Ok(None);
    };
    let parsed = ExerciseBundle::from_parts(&bytes.exercise, &bytes.scene, &bytes.meshes);
    Ok(Some(parsed.map_err(|refused| anyhow::Error::new(refused).context("published exercise is invalid"))?))
}
