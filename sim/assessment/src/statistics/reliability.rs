//! Internal consistency of a scale.

use statrs::distribution::{ContinuousCDF, FisherSnedecor};

use super::rank::pearson;
use super::table::Complete;
use super::{NotComputable, count_as_number, sample_variance};

/// Cronbach's α with the size of its data.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize)]
pub struct Reliability {
    /// α, dimensionless; may be negative.
    pub alpha: f64,
    /// Lower end of its 95 % interval.
    pub low: f64,
    /// Upper end of its 95 % interval.
    pub high: f64,
    /// Number of items of the scale.
    pub items: usize,
    /// Number of complete rows used.
    pub n: usize,
    /// Number of rows left out because an item is missing.
    pub missing: usize,
}

/// Contribution of one item to its scale.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ItemAnalysis {
    /// Pearson's correlation of the item with the sum of the others, −1 to 1.
    pub rest_correlation: Result<f64, NotComputable>,
    /// α of the scale without the item.
    pub alpha_without: Result<f64, NotComputable>,
}

/// Computes Cronbach's α = k/(k−1)·(1 − Σs²ᵢ/s²ₓ) over the complete rows: one row per respondent,
/// one column per item. Interval after Feldt (1965), "The approximate sampling distribution of
/// Kuder–Richardson reliability coefficient twenty", Psychometrika 30, 357–370.
///
/// # Errors
/// With fewer than two items or complete rows, with no variance of the sums, or rows of different
/// lengths.
pub fn cronbach_alpha(rows: &[Vec<Option<f64>>]) -> Result<Reliability, NotComputable> {
    let table = Complete::from_rows(rows)?;
    let alpha = table_alpha(&table)?;
    let freedom = count_as_number(table.rows.len() - 1);
    let fisher = FisherSnedecor::new(freedom, freedom * count_as_number(table.columns - 1))
        .map_err(|_| NotComputable::OutOfRange)?;
    let end = |share: f64| 1.0 - (1.0 - alpha) * fisher.inverse_cdf(share);
    let (low, high) = (end(0.975), end(0.025));
    Ok(Reliability { alpha, low, high, items: table.columns, n: table.rows.len(), missing: table.missing })
}

/// Compares each item of a scale with the others, over the complete rows, in the order of the
/// columns.
///
/// # Errors
/// As [`cronbach_alpha`]; a statistic that is undefined for a single item has its own error.
pub fn item_analysis(rows: &[Vec<Option<f64>>]) -> Result<Vec<ItemAnalysis>, NotComputable> {
    let table = Complete::from_rows(rows)?;
    table_alpha(&table)?;
    let analysis = |item: usize| {
        let others = table.without_column(item);
        ItemAnalysis {
            rest_correlation: pearson(&table.column(item), &row_sums(&others)),
            alpha_without: table_alpha(&others),
        }
    };
    Ok((0..table.columns).map(analysis).collect())
}

/// Returns α of complete rows.
fn table_alpha(table: &Complete) -> Result<f64, NotComputable> {
    table.at_least_two()?;
    let of_sums = sample_variance(&row_sums(table));
    if of_sums <= 0.0 {
        return Err(NotComputable::NoVariance);
    }
    let of_items: f64 = (0..table.columns).map(|item| sample_variance(&table.column(item))).sum();
    let k = count_as_number(table.columns);
    Ok(k / (k - 1.0) * (1.0 - of_items / of_sums))
}

fn row_sums(table: &Complete) -> Vec<f64> {
    table.rows.iter().map(|row| row.iter().sum()).collect()
}
