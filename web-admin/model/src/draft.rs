//! What a draft comes to.

use documents::{ExerciseBundle, Issue};
use serde::{Deserialize, Serialize};
use tissue::follow::FieldPlan;

/// What a draft comes to.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct DraftVerdict {
    /// What is wrong: where, and what.
    pub problems: Vec<(String, String)>,
    /// What an author should change: where, and what.
    pub advice: Vec<(String, String)>,
    /// Cross-section, for both widths.
    pub drawing: Option<String>,
    /// Name and value.
    pub facts: Vec<(String, String)>,
    /// Titles of a course's exercises in order.
    pub exercises: Vec<String>,
}

/// An exercise that could be published.
#[derive(Debug)]
pub struct Publishable {
    /// The exercise.
    pub bundle: ExerciseBundle,
    /// The plan of its tissue, where it names a model.
    pub plan: Option<FieldPlan>,
    /// What its author should change: what `stylet check` finds in its rubric.
    pub advice: Vec<Issue>,
}
