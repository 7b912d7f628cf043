//! Agreement of raters: intraclass correlations (Shrout and Fleiss 1979, Psychological Bulletin 86,
//! 420–428). Intervals for random raters after McGraw and Wong 1996, Psychological Methods 1,
//! 30–46, table 7.

use statrs::distribution::{ContinuousCDF, FisherSnedecor};

use super::table::Complete;
use super::{NotComputable, ROUNDING, arithmetic_mean, count_as_number};

/// Distance from its pole below which ICC(2,k) is dominated by rounding.
const POLE: f64 = 1e-9;

/// Intraclass correlations of one table, dimensionless; each may be negative.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize)]
pub struct IntraclassCorrelation {
    /// ICC(2,1): random raters, single rating.
    pub single_random: f64,
    /// ICC(2,k): random raters, mean of their ratings; absent if the raters agree so much less than
    /// by chance that it is undefined.
    pub average_random: Option<f64>,
    /// 95 % interval of ICC(2,1); absent if the raters agree exactly.
    pub single_random_95: Option<(f64, f64)>,
    /// 95 % interval of ICC(2,k), if both ends can be computed.
    pub average_random_95: Option<(f64, f64)>,
    /// ICC(3,1): fixed raters, single rating.
    pub single_fixed: f64,
    /// ICC(3,k): fixed raters, mean of their ratings.
    pub average_fixed: f64,
    /// Number of complete rows (rated objects).
    pub n: usize,
    /// Number of raters.
    pub raters: usize,
    /// Number of rows left out because a rating is missing.
    pub missing: usize,
}

/// Mean squares of a two-way table without replication.
struct MeanSquares {
    rows: f64,
    columns: f64,
    error: f64,
}

/// Computes intraclass correlations of the complete rows: one row for each rated object, one column
/// for each rater.
///
/// # Errors
/// With fewer than two raters or complete rows, if the rated objects do not differ, or for rows of
/// different lengths.
pub fn intraclass_correlation(rows: &[Vec<Option<f64>>]) -> Result<IntraclassCorrelation, NotComputable> {
    let table = Complete::from_rows(rows)?;
    table.at_least_two()?;
    let squares = mean_squares(&table);
    let MeanSquares { rows: msr, columns: msc, error: mse } = squares;
    let (n, k) = (count_as_number(table.rows.len()), count_as_number(table.columns));
    if msr <= 0.0 {
        return Err(NotComputable::NoVariance);
    }
    let single_random = checked_ratio(msr - mse, msr + (k - 1.0) * mse + k * (msc - mse) / n)?;
    let interval = icc_interval(&squares, single_random, n, k);
    Ok(IntraclassCorrelation {
        single_random,
        average_random: icc_of_mean(single_random, k),
        single_random_95: interval,
        average_random_95: interval.and_then(|(low, high)| Some((icc_of_mean(low, k)?, icc_of_mean(high, k)?))),
        single_fixed: checked_ratio(msr - mse, msr + (k - 1.0) * mse)?,
        average_fixed: checked_ratio(msr - mse, msr)?,
        n: table.rows.len(),
        raters: table.columns,
        missing: table.missing,
    })
}

/// Returns the interval of ICC(2,1), with Satterthwaite's degrees of freedom for the combined
/// variance of raters and error.
fn icc_interval(squares: &MeanSquares, single: f64, n: f64, k: f64) -> Option<(f64, f64)> {
    let MeanSquares { rows: msr, columns: msc, error: mse } = *squares;
    let a = k * single / (n * (1.0 - single));
    let b = 1.0 + k * single * (n - 1.0) / (n * (1.0 - single));
    let (columns, error) = (a * msc, b * mse);
    let spread = columns * columns / (k - 1.0) + error * error / ((n - 1.0) * (k - 1.0));
    let freedom = (columns + error) * (columns + error) / spread;
    let quantile = |above, below| Some(FisherSnedecor::new(above, below).ok()?.inverse_cdf(0.975));
    let (lower, upper) = (quantile(n - 1.0, freedom)?, quantile(freedom, n - 1.0)?);
    let shared = k * msc + (k * n - k - n) * mse;
    let low = n * (msr - lower * mse) / (lower * shared + n * msr);
    let high = n * (upper * msr - mse) / (shared + n * upper * msr);
    (low.is_finite() && high.is_finite()).then_some((low, high))
}

/// Returns the reliability of the mean of `k` ratings (Spearman and Brown); `None` at or below the
/// pole, −1/(k − 1).
fn icc_of_mean(single: f64, k: f64) -> Option<f64> {
    let share = 1.0 + (k - 1.0) * single;
    (share > POLE).then(|| k * single / share)
}

fn checked_ratio(above: f64, below: f64) -> Result<f64, NotComputable> {
    if below > 0.0 { Ok(above / below) } else { Err(NotComputable::NoVariance) }
}

fn mean_squares(table: &Complete) -> MeanSquares {
    let (n, k) = (count_as_number(table.rows.len()), count_as_number(table.columns));
    let row_means: Vec<f64> = table.rows.iter().map(|row| arithmetic_mean(row)).collect();
    let column_means: Vec<f64> = (0..table.columns).map(|c| arithmetic_mean(&table.column(c))).collect();
    let grand = arithmetic_mean(&row_means);
    let squares = |means: &[f64]| means.iter().map(|m| (m - grand) * (m - grand)).sum::<f64>();
    let residual = |(row, r): (&Vec<f64>, &f64)| -> f64 {
        row.iter().zip(&column_means).map(|(x, c)| x - r - c + grand).map(|e| e * e).sum()
    };
    let error: f64 = table.rows.iter().zip(&row_means).map(residual).sum();
    let largest = table.rows.iter().flatten().fold(0.0, |m: f64, v| m.max(v.abs()));
    let floor = |mean_square: f64| if mean_square <= (ROUNDING * largest).powi(2) * n * k { 0.0 } else { mean_square };
    MeanSquares {
        rows: floor(k * squares(&row_means) / (n - 1.0)),
        columns: floor(n * squares(&column_means) / (k - 1.0)),
        error: floor(error / ((n - 1.0) * (k - 1.0))),
    }
}
