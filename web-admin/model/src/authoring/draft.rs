//! Results of checking a draft.

use documents::{ExerciseBundle, Issue};
use serde::{Deserialize, Serialize};
use tissue::follow::FieldPlan;

/// Results of checking a draft.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct DraftVerdict {
    /// Problems that prevent publication.
    pub problems: Vec<DraftRemark>,
    /// Suggested changes.
    pub advice: Vec<DraftRemark>,
    /// Drawing of the cross-section, for both widths.
    pub drawing: Option<String>,
    /// Properties: name and value.
    pub facts: Vec<(String, String)>,
    /// Titles of a course's exercises, in order.
    pub exercises: Vec<String>,
}

/// A remark on a draft, and its location.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct DraftRemark {
    /// Location in the text, as words.
    pub place: String,
    /// Address of the field, for example `rubric[0].full`; empty if it concerns no field, or the
    /// scene.
    pub field: String,
    /// Text of the remark.
    pub what: String,
}

impl DraftRemark {
    /// Makes a remark on the draft as a whole.
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
    /// Exercise.
    pub bundle: ExerciseBundle,
    /// Plan of the tissue model, if the exercise names one.
    pub plan: Option<FieldPlan>,
    /// Suggested changes: the findings of `stylet check` on the rubric.
    pub advice: Vec<Issue>,
}
