//! Results of re-grading the attempts at an exercise.

use serde::{Deserialize, Serialize};

use crate::Moment;
use crate::ids::SessionId;

/// State of a re-grading.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "sqlx", derive(sqlx::Type))]
#[cfg_attr(feature = "sqlx", sqlx(type_name = "text", rename_all = "lowercase"))]
pub enum RegradingState {
    /// The preview is being computed; nothing has changed.
    Looking,
    /// The preview is complete.
    Shown,
    /// It was confirmed, and the new scores are being stored.
    Grading,
    /// All new scores are stored.
    Done,
}

/// Outcome for one attempt.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[cfg_attr(feature = "sqlx", derive(sqlx::Type))]
#[serde(rename_all = "lowercase")]
#[cfg_attr(feature = "sqlx", sqlx(type_name = "text", rename_all = "lowercase"))]
pub enum RegradingOutcome {
    /// It passes and did not pass before.
    Passes,
    /// It fails and passed before.
    Fails,
    /// The score changes, but not the result.
    Changed,
    /// The computed score changes, but an override stays effective.
    Overridden,
    /// The rubric differs, but not the score.
    Equal,
    /// It was already graded with this rubric.
    Same,
    /// Its recording cannot be graded.
    Unreadable,
    /// Its score changed after the confirmation, so that it was left unchanged.
    Overtaken,
}

/// An attempt in a re-grading.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "sqlx", derive(sqlx::FromRow))]
pub struct RegradingLine {
    /// The attempt.
    pub session_id: SessionId,
    /// Start time.
    pub started_at: Moment,
    /// Name of the trainee.
    pub trainee: String,
    /// Previous computed score, 0–100.
    pub before: f64,
    /// Previous result: passed.
    pub passed_before: bool,
    /// New score, 0–100.
    pub after: Option<f64>,
    /// New result: passed.
    pub passed_after: Option<bool>,
    /// Effective override, 0–100.
    pub overridden: Option<f64>,
    /// Outcome.
    pub outcome: RegradingOutcome,
    /// Reason why it cannot be graded.
    pub why: Option<String>,
}

/// Number of attempts with one outcome.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "sqlx", derive(sqlx::FromRow))]
pub struct OutcomeCount {
    /// Outcome.
    pub outcome: RegradingOutcome,
    /// Number of attempts.
    pub attempts: i64,
    /// Sum of the previous computed scores.
    pub before: f64,
    /// Sum of the new scores, or of the previous ones where there is no new one.
    pub after: f64,
}

/// Returns the number of attempts with the given outcomes.
#[must_use]
pub fn count_attempts(counts: &[OutcomeCount], outcomes: &[RegradingOutcome]) -> i64 {
    counts.iter().filter(|count| outcomes.contains(&count.outcome)).map(|count| count.attempts).sum()
}
