//! Statistics of proportions, scores, ratings and questionnaires.
//!
//! A value that cannot be computed is an error with a reason ([`NotComputable`]), never 0 and never
//! NaN. Intervals are 95 % intervals.

use phrase::{Phrase, phrase};

mod comparison;
mod content;
mod icc;
mod mean;
mod proportion;
mod quantile;
mod rank;
mod reliability;
mod table;

pub use comparison::{RankSumTest, hedges_g, holm_adjusted, mann_whitney};
pub use content::{ContentValidity, content_validity, scale_content_validity};
pub use icc::{IntraclassCorrelation, intraclass_correlation};
pub use mean::mean;
pub use proportion::wilson;
pub use quantile::{Summary, quantile, summary};
pub use rank::{area_under_curve, rank_correlation};
pub use reliability::{ItemAnalysis, Reliability, cronbach_alpha, item_analysis};

/// The standard normal quantile of 97.5 %.
const Z_95: f64 = 1.959_963_984_540_054;

/// Differences below this fraction of the largest value are rounding, not variance.
const ROUNDING: f64 = 1e-12;

/// The reason why a statistic cannot be computed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, serde::Serialize, thiserror::Error)]
#[serde(rename_all = "snake_case", tag = "reason")]
#[error("{}", self.in_words())]
pub enum NotComputable {
    /// Fewer observations (people, pairs, attempts) than required.
    TooFew {
        /// Number found.
        found: usize,
        /// Number required.
        needed: usize,
    },
    /// Fewer items or raters than required.
    TooFewItems {
        /// Number found.
        found: usize,
        /// Number required.
        needed: usize,
    },
    /// All values are equal.
    NoVariance,
    /// The rows of a table have different numbers of columns.
    Ragged,
    /// A value is outside the domain of the statistic, or not a number.
    OutOfRange,
}

impl NotComputable {
    /// Returns the translatable message.
    #[must_use]
    pub fn in_words(&self) -> Phrase {
        match self {
            Self::TooFew { found, needed } => {
                phrase!("{found} observations, at least {needed} needed", found = *found, needed = *needed)
            }
            Self::TooFewItems { found, needed } => {
                phrase!("{found} items, at least {needed} needed", found = *found, needed = *needed)
            }
            Self::NoVariance => phrase!("no variance"),
            Self::Ragged => phrase!("rows of different lengths"),
            Self::OutOfRange => phrase!("a value out of range"),
        }
    }
}

/// An estimate with its 95 % interval.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize)]
pub struct Estimate {
    /// The estimate, in the unit of the observations.
    pub value: f64,
    /// Lower end of the interval, in the same unit.
    pub low: f64,
    /// Upper end of the interval, in the same unit.
    pub high: f64,
    /// Number of observations.
    pub n: usize,
}

/// Converts a count to a float.
fn count_as_number(n: usize) -> f64 {
    n as f64
}

/// Refuses too few values, and values that are not finite.
fn check_sample(values: &[f64], needed: usize) -> Result<(), NotComputable> {
    if values.len() < needed {
        return Err(NotComputable::TooFew { found: values.len(), needed });
    }
    if values.iter().all(|v| v.is_finite()) { Ok(()) } else { Err(NotComputable::OutOfRange) }
}

/// Returns the arithmetic mean; the caller must ensure that there are values.
fn arithmetic_mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / count_as_number(values.len())
}

/// Returns the sample variance (divided by n − 1); exactly 0 if the values differ only by rounding.
fn sample_variance(values: &[f64]) -> f64 {
    let centre = arithmetic_mean(values);
    let largest = values.iter().fold(0.0, |m: f64, v| m.max(v.abs()));
    let spread = values.iter().fold(0.0, |m: f64, v| m.max((v - centre).abs()));
    if spread <= ROUNDING * largest {
        return 0.0;
    }
    values.iter().map(|v| (v - centre) * (v - centre)).sum::<f64>() / (count_as_number(values.len()) - 1.0)
}
