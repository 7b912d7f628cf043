//! Reasons for lost points and for failures, as data; [`crate::words`] formats them.

pub mod words;

use documents::Wording;
use serde::{Deserialize, Serialize};

use crate::absent::Absent;
use crate::catalogue::first_version;
use crate::required::UnmetRequirement;

/// The reason for the points lost on a rubric line.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(tag = "kind", rename_all = "snake_case")]
pub enum DeductionCause {
    /// The metric has a value; `full` earns full marks, `zero` earns none. All in the metric's
    /// unit.
    Measured {
        /// Value.
        value: f64,
        /// Value for full marks.
        full: f64,
        /// Value for no marks.
        zero: f64,
    },
    /// The metric has no value.
    Absent {
        /// The reason.
        reason: Absent,
    },
    /// The line earns nothing: a requirement was not met.
    Required {
        /// The requirement.
        unmet: UnmetRequirement,
    },
    /// The scene has no such metric.
    NoSuchMetric,
    /// Stored by a version that stored words only.
    Worded {
        /// The words, without the points.
        words: String,
    },
}

/// Points lost on a rubric line, and the reason.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(into = "StoredDeduction", from = "StoredDeduction")]
pub struct Deduction {
    /// Metric id.
    pub metric: String,
    /// Version of the metric's definition.
    pub version: u32,
    /// Points lost, of 100; lines that lost 0 points are listed too, so that every line of the
    /// rubric is shown.
    pub points: f64,
    /// The reason.
    pub cause: DeductionCause,
}

/// The serialised form: with the reason in English in addition to the data, for readers of the
/// file.
#[derive(Serialize, Deserialize)]
struct StoredDeduction {
    metric: String,
    #[serde(default = "first_version")]
    version: u32,
    points: f64,
    cause: Option<DeductionCause>,
    why: String,
}

impl From<Deduction> for StoredDeduction {
    fn from(deduction: Deduction) -> Self {
        let why = words::deduction_in_words(&deduction);
        let Deduction { metric, version, points, cause } = deduction;
        Self { metric, version, points, cause: Some(cause), why }
    }
}

impl From<StoredDeduction> for Deduction {
    fn from(stored: StoredDeduction) -> Self {
        let StoredDeduction { metric, version, points, cause, why } = stored;
        // The points were part of the stored text; they are displayed separately now.
        let told = || why.strip_suffix(&words::cost_in_words(points)).unwrap_or(&why).to_owned();
        Self { metric, version, points, cause: cause.unwrap_or_else(|| DeductionCause::Worded { words: told() }) }
    }
}

/// The reason for a failure regardless of the score.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(tag = "kind", rename_all = "snake_case")]
pub enum FailureCause {
    /// A requirement was not met.
    Required {
        /// The requirement.
        unmet: UnmetRequirement,
    },
    /// A metric is above its limit. Both in the metric's unit.
    Limit {
        /// The author's message, in the languages of the document.
        words: Wording,
        /// Metric id.
        metric: String,
        /// Version of the metric's definition.
        version: u32,
        /// Value.
        value: f64,
        /// Largest allowed value.
        limit: f64,
    },
    /// Stored by a version that stored words only.
    Worded {
        /// The words.
        words: String,
    },
}

/// A hard failure in an assessment.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(into = "StoredFailure", from = "StoredFailure")]
pub struct HardFailure {
    /// The reason.
    pub cause: FailureCause,
}

/// The serialised form: with the reason in English in addition to the data; or words alone, as
/// earlier versions stored it.
#[derive(Serialize, Deserialize)]
#[serde(untagged)]
enum StoredFailure {
    Caused { cause: FailureCause, why: String },
    Words(String),
}

impl From<HardFailure> for StoredFailure {
    fn from(failure: HardFailure) -> Self {
        let why = words::failure_in_words(&failure);
        Self::Caused { cause: failure.cause, why }
    }
}

impl From<StoredFailure> for HardFailure {
    fn from(stored: StoredFailure) -> Self {
        let cause = match stored {
            StoredFailure::Caused { cause, .. } => cause,
            StoredFailure::Words(words) => FailureCause::Worded { words },
        };
        Self { cause }
    }
}

#[cfg(test)]
mod tests {
    //! Stored data is read back unchanged, from this version and earlier ones, and contains its
    //! words for readers of the file.

    use super::*;

    #[test]
    fn a_deduction_comes_back_with_its_figures_to_the_bit() {
        let cause = DeductionCause::Measured { value: 0.1 + 0.2, full: 1.8, zero: 6.0 };
        let deduction = Deduction { metric: "peak_force_n".to_owned(), version: 1, points: 4.8, cause };
        let text = serde_json::to_string(&deduction).expect("JSON");
        assert_eq!(serde_json::from_str::<Deduction>(&text).expect("the same"), deduction);
        let json: serde_json::Value = serde_json::from_str(&text).expect("JSON");
        assert!(json["why"].as_str().expect("words").starts_with("peak force 0.3 N, full marks"), "{json}");
        assert_eq!(json["cause"]["kind"], "measured");
    }

    #[test]
    fn words_of_before_stay_words() {
        let stored = r#"{"metric": "overshoot_mm", "points": 6.0, "why": "overshoot 1.9 mm: −6 points"}"#;
        let read: Deduction = serde_json::from_str(stored).expect("as it was stored");
        assert_eq!((read.version, words::deduction_in_words(&read).as_str()), (1, "overshoot 1.9 mm: −6 points"));
        let failures: Vec<HardFailure> =
            serde_json::from_str(r#"["too hard (peak force 12 N, limit 10 N)"]"#).expect("as it was stored");
        assert_eq!(words::failure_in_words(&failures[0]), "too hard (peak force 12 N, limit 10 N)");
    }

    #[test]
    fn a_failure_comes_back_as_it_was() {
        let (words, metric) = ("too hard".into(), "peak_force_n".to_owned());
        let limit = FailureCause::Limit { words, metric, version: 1, value: 12.3, limit: 10.0 };
        for cause in [limit, FailureCause::Required { unmet: UnmetRequirement::Confirmed }] {
            let failure = HardFailure { cause };
            let text = serde_json::to_string(&failure).expect("JSON");
            assert_eq!(serde_json::from_str::<HardFailure>(&text).expect("the same"), failure);
        }
    }
}
