//! Overrides of computed scores by instructors.

use serde::Deserialize;

/// Maximum length of a reason, in characters.
pub const MOST_CHARACTERS: usize = 1000;

/// An override as entered.
#[derive(Clone, Debug, Default, PartialEq, Eq, Deserialize)]
pub struct TypedOverride {
    /// Score, 0–100.
    #[serde(default)]
    pub score: String,
    /// `passed` or `failed`.
    #[serde(default)]
    pub result: String,
    /// Reason.
    #[serde(default)]
    pub reason: String,
}

/// A valid override.
#[derive(Clone, Debug, PartialEq)]
pub struct ScoreOverride {
    /// Score, 0–100.
    pub score: f64,
    /// The attempt is passed.
    pub passed: bool,
    /// Reason.
    pub reason: String,
}

/// An override was refused: field, value and accepted values.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{0}")]
pub struct OverrideRefused(String);

impl ScoreOverride {
    /// Validates an entered override.
    ///
    /// # Errors
    /// If the score is not a number from 0 to 100, the result is unknown, or the reason is missing
    /// or too long.
    pub fn parse(typed: &TypedOverride) -> Result<Self, OverrideRefused> {
        let number = typed.score.trim().replace(',', ".").parse::<f64>().ok();
        let score = number.filter(|score| (0.0..=100.0).contains(score));
        let score =
            score.ok_or_else(|| OverrideRefused(tr!("score: “{typed}”; allowed: 0 to 100", typed = typed.score)))?;
        let passed = match typed.result.as_str() {
            "passed" => true,
            "failed" => false,
            other => {
                return Err(OverrideRefused(tr!("result: “{typed}”; allowed: passed, failed", typed = other)));
            }
        };
        Ok(Self { score, passed, reason: reason(&typed.reason)? })
    }
}

/// Validates the reason for a change of a grade.
///
/// # Errors
/// If it is empty or too long.
pub fn reason(typed: &str) -> Result<String, OverrideRefused> {
    let reason = typed.trim();
    match reason.chars().count() {
        0 => Err(OverrideRefused(tr!("reason: empty; changing a grade needs a reason").to_owned())),
        1..=MOST_CHARACTERS => Ok(reason.to_owned()),
        count => Err(OverrideRefused(tr!(
            "reason: {count} characters; allowed: at most {most}",
            count = count,
            most = MOST_CHARACTERS
        ))),
    }
}

#[cfg(test)]
mod tests {
    //! Checks that a grade cannot be changed without a reason, or to an invalid score.
    use super::*;

    fn typed(score: &str, result: &str, reason: &str) -> TypedOverride {
        TypedOverride { score: score.into(), result: result.into(), reason: reason.into() }
    }

    #[test]
    fn a_score_with_a_result_and_a_reason_is_taken() {
        let taken = ScoreOverride::parse(&typed("72,5", "passed", " The device slipped. ")).expect("allowed");
        assert_eq!(taken, ScoreOverride { score: 72.5, passed: true, reason: "The device slipped.".to_owned() });
    }

    #[test]
    fn anything_less_is_refused_with_the_field() {
        for (score, result, why, word) in [
            ("72", "passed", "", "reason"),
            ("72", "passed", "  \n", "reason"),
            ("72", "", "why", "result"),
            ("101", "passed", "why", "score"),
            ("-0.1", "failed", "why", "score"),
            ("NaN", "failed", "why", "score"),
            ("", "failed", "why", "score"),
        ] {
            let refused = ScoreOverride::parse(&typed(score, result, why)).expect_err(word).to_string();
            assert!(refused.starts_with(word), "{refused}");
        }
        assert!(reason(&"x".repeat(MOST_CHARACTERS + 1)).is_err());
    }
}
