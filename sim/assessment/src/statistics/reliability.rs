//! Internal consistency of a scale.

use super::table::Complete;
use super::{NotComputable, count_as_number, sample_variance};

/// Cronbach's α and what it is of.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize)]
pub struct Reliability {
    /// α, without a unit; may be negative.
    pub alpha: f64,
    /// Items of the scale.
    pub items: usize,
    /// Complete rows it is computed from.
    pub n: usize,
    /// Rows left out because an item is missing.
    pub missing: usize,
}

/// Cronbach's α = k/(k−1)·(1 − Σs²ᵢ/s²ₓ) over the complete rows: one row a respondent, one column an item.
///
/// # Errors
/// With fewer than two items or complete rows, with no variance of the sums, or rows of different lengths.
pub fn cronbach_alpha(rows: &[Vec<Option<f64>>]) -> Result<Reliability, NotComputable> {
    let table = Complete::from_rows(rows)?;
    table.at_least_two()?;
    let sums: Vec<f64> = table.rows.iter().map(|row| row.iter().sum()).collect();
    let of_sums = sample_variance(&sums);
    if of_sums <= 0.0 {
        return Err(NotComputable::NoVariance);
    }
    let of_items: f64 = (0..table.columns).map(|item| sample_variance(&table.column(item))).sum();
    let k = count_as_number(table.columns);
    let alpha = k / (k - 1.0) * (1.0 - of_items / of_sums);
    Ok(Reliability { alpha, items: table.columns, n: table.rows.len(), missing: table.missing })
}
