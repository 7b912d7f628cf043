//! Quantiles, by linear interpolation between order statistics.

use super::{NotComputable, check_sample, count_as_number};

/// Minimum, quartiles and maximum of a sample, in its unit.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize)]
pub struct Summary {
    /// Number of values.
    pub n: usize,
    /// Minimum.
    pub min: f64,
    /// 25 % quantile.
    pub lower_quartile: f64,
    /// 50 % quantile.
    pub median: f64,
    /// 75 % quantile.
    pub upper_quartile: f64,
    /// Maximum.
    pub max: f64,
}

/// Returns the quantile of a share (0–1) of the values: the value at rank 1 + (n − 1)·share of the
/// sorted sample, linear between its neighbours. This is definition 7 of Hyndman and Fan (1996),
/// the default of R and NumPy.
///
/// # Errors
/// Without values, with one that is not finite, or for a share outside 0–1.
pub fn quantile(values: &[f64], share: f64) -> Result<f64, NotComputable> {
    of_sorted(&sorted(values)?, share)
}

/// Returns minimum, quartiles and maximum, with [`quantile`]'s definition.
///
/// # Errors
/// Without values, or with one that is not finite.
pub fn summary(values: &[f64]) -> Result<Summary, NotComputable> {
    let sorted = sorted(values)?;
    Ok(Summary {
        n: sorted.len(),
        min: of_sorted(&sorted, 0.0)?,
        lower_quartile: of_sorted(&sorted, 0.25)?,
        median: of_sorted(&sorted, 0.5)?,
        upper_quartile: of_sorted(&sorted, 0.75)?,
        max: of_sorted(&sorted, 1.0)?,
    })
}

fn sorted(values: &[f64]) -> Result<Vec<f64>, NotComputable> {
    check_sample(values, 1)?;
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    Ok(sorted)
}

fn of_sorted(sorted: &[f64], share: f64) -> Result<f64, NotComputable> {
    if !(0.0..=1.0).contains(&share) {
        return Err(NotComputable::OutOfRange);
    }
    let rank = share * count_as_number(sorted.len() - 1);
    // Not negative, and at most the last index: the cast rounds down.
    let below = (rank as usize).min(sorted.len() - 1);
    let above = (below + 1).min(sorted.len() - 1);
    Ok(sorted[below] + (rank - count_as_number(below)) * (sorted[above] - sorted[below]))
}
