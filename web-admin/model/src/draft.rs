//! What a draft comes to.

use documents::{ExerciseBundle, Issue};
use serde::{Deserialize, Serialize};
use tissue::follow::FieldPlan;

/// What a draft comes to.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct DraftVerdict {
    /// What is wrong.
    pub problems: Vec<DraftRemark>,
    /// What an author should change.
    pub advice: Vec<DraftRemark>,
    /// Cross-section, for both widths.
    pub drawing: Option<String>,
    /// Name and value.
    pub facts: Vec<(String, String)>,
    /// Titles of a course's exercises in order.
    pub exercises: Vec<String>,
}

/// Something about a draft, and where.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct DraftRemark {
    /// Where in the text, in words.
    pub place: String,
    /// The field's address in the document, like `rubric[0].full`; empty where it is about none, or about the scene.
    pub field: String,
    /// What.
    pub what: String,
}

impl DraftRemark {
    /// About a draft as a whole.
    #[must_use]
    pub fn on_all(place: &str, what: String) -> Self {
        Self { place: place.to_owned(), field: String::new(), what }
    }
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
