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

/// How many people a new revision of a course concerns.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct CourseChange {
    /// Have mastered the course as it is taught, and keep that.
    pub mastered: usize,
    /// Have begun it, and go on with the new revision.
    pub under_way: usize,
}

impl CourseChange {
    /// It concerns nobody.
    #[must_use]
    pub const fn is_empty(self) -> bool {
        self.mastered == 0 && self.under_way == 0
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
