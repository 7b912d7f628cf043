//! Published exercises.

use acts::error::Error;
use documents::ExerciseBundle;
use model::ids::{RevisionId, SchoolId};
use store::exercises;

use crate::AppState;

/// A revision as it was published. Publishing has checked it, so a refusal now is our fault.
///
/// # Errors
/// When a published document is refused.
pub async fn published_bundle(
    state: &AppState,
    school: SchoolId,
    revision: RevisionId,
) -> Result<Option<ExerciseBundle>, Error> {
    let Some(bytes) = exercises::read_exercise_bytes(state.db.reader(), school, revision).await? else {
        return Ok(None);
    };
    let parsed = ExerciseBundle::from_parts(&bytes.exercise, &bytes.scene, &bytes.meshes);
    Ok(Some(parsed.map_err(|refused| anyhow::Error::new(refused).context("a published exercise is refused"))?))
}
