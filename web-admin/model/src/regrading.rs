//! What becomes of attempts when an exercise is graded again.

use serde::{Deserialize, Serialize};

use crate::Moment;
use crate::ids::SessionId;

/// How far a re-grading is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "sqlx", derive(sqlx::Type))]
#[cfg_attr(feature = "sqlx", sqlx(type_name = "text", rename_all = "lowercase"))]
pub enum RegradingState {
    /// Attempts are being judged, and nothing is changed.
    Looking,
    /// It can be read what would change.
    Shown,
    /// Scores are being added.
    Grading,
    /// All were added.
    Done,
}

/// What becomes of an attempt.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[cfg_attr(feature = "sqlx", derive(sqlx::Type))]
#[serde(rename_all = "lowercase")]
#[cfg_attr(feature = "sqlx", sqlx(type_name = "text", rename_all = "lowercase"))]
pub enum RegradingOutcome {
    /// It passes and did not before.
    Passes,
    /// It passed before and does no longer.
    Fails,
    /// Another score, and the same result.
    Changed,
    /// Another computed score; what somebody has put in its place goes on counting.
    Overridden,
    /// Another rubric, and the same score.
    Equal,
    /// It was graded by this rubric already.
    Same,
    /// Its recording cannot be judged.
    Unreadable,
    /// Somebody has graded it between the confirmation and its turn: it was left alone.
    Overtaken,
}

/// An attempt in a re-grading.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "sqlx", derive(sqlx::FromRow))]
pub struct RegradingLine {
    /// The attempt.
    pub session_id: SessionId,
    /// When it began.
    pub started_at: Moment,
    /// Who tried.
    pub trainee: String,
    /// The computed score before, 0–100.
    pub before: f64,
    /// It was a pass.
    pub passed_before: bool,
    /// The score by the rubric, 0–100.
    pub after: Option<f64>,
    /// It is a pass.
    pub passed_after: Option<bool>,
    /// What goes on counting in its place, 0–100.
    pub overridden: Option<f64>,
    /// What becomes of it.
    pub outcome: RegradingOutcome,
    /// Why it cannot be judged.
    pub why: Option<String>,
}

/// Attempts of one outcome.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "sqlx", derive(sqlx::FromRow))]
pub struct OutcomeCount {
    /// The outcome.
    pub outcome: RegradingOutcome,
    /// How many.
    pub attempts: i64,
    /// Sum of the computed scores before.
    pub before: f64,
    /// Sum of the scores by the rubric, of those before where there are none.
    pub after: f64,
}

/// How many attempts there are of some outcomes.
#[must_use]
pub fn count_attempts(counts: &[OutcomeCount], outcomes: &[RegradingOutcome]) -> i64 {
    counts.iter().filter(|count| outcomes.contains(&count.outcome)).map(|count| count.attempts).sum()
}
