//! Rank correlation, and discrimination between two groups.

use super::{Estimate, NotComputable, Z_95, arithmetic_mean, check_sample, count_as_number, sample_variance};

/// Number of bisection steps, which reduces an interval to below rounding.
const HALVINGS: usize = 60;

/// Spearman's ρ of pairs, with mean ranks for ties; interval by Fisher's z with the variance (1 +
/// ρ²/2)/(n − 3) of Bonett and Wright (2000), "Sample size requirements for estimating Pearson,
/// Kendall and Spearman correlations", Psychometrika 65, 23–28. At ρ = ±1 the interval has no
/// width, because z is infinite there.
///
/// # Errors
/// With fewer than four pairs, without variance on either side, or with a value that is not finite.
pub fn rank_correlation(pairs: &[(f64, f64)]) -> Result<Estimate, NotComputable> {
    let (left, right): (Vec<f64>, Vec<f64>) = pairs.iter().copied().unzip();
    check_sample(&left, 4)?;
    check_sample(&right, 4)?;
    let rho = pearson(&ranks(&left), &ranks(&right))?;
    let half = Z_95 * libm::sqrt((1.0 + rho * rho / 2.0) / (count_as_number(pairs.len()) - 3.0));
    let z = libm::atanh(rho);
    Ok(Estimate { value: rho, low: libm::tanh(z - half), high: libm::tanh(z + half), n: pairs.len() })
}

/// Returns ranks from 1; equal values share the mean of their ranks.
pub(super) fn ranks(values: &[f64]) -> Vec<f64> {
    let mut order: Vec<usize> = (0..values.len()).collect();
    order.sort_by(|&a, &b| values[a].total_cmp(&values[b]));
    let mut ranks = vec![0.0; values.len()];
    let mut start = 0;
    // Not `total_cmp`, because −0 and 0 are equal.
    for tied in order.chunk_by(|&a, &b| values[a].partial_cmp(&values[b]).is_some_and(std::cmp::Ordering::is_eq)) {
        let rank = count_as_number(start) + (count_as_number(tied.len()) + 1.0) / 2.0;
        tied.iter().for_each(|&i| ranks[i] = rank);
        start += tied.len();
    }
    ranks
}

/// Returns Pearson's correlation of two columns of equal length.
pub(super) fn pearson(left: &[f64], right: &[f64]) -> Result<f64, NotComputable> {
    let product = sample_variance(left) * sample_variance(right);
    if product <= 0.0 {
        return Err(NotComputable::NoVariance);
    }
    let (l, r) = (arithmetic_mean(left), arithmetic_mean(right));
    let covariance =
        left.iter().zip(right).map(|(a, b)| (a - l) * (b - r)).sum::<f64>() / (count_as_number(left.len()) - 1.0);
    Ok((covariance / libm::sqrt(product)).clamp(-1.0, 1.0))
}

/// Area under the ROC curve, 0–1: how often a value of the first sample is above one of the second,
/// ties count half. Interval by the fifth method of Newcombe (2006), "Confidence intervals for an
/// effect size measure based on the Mann–Whitney statistic. Part 2: asymptotic methods and
/// evaluation", Statistics in Medicine 25, 559–573: unlike that of Hanley and McNeil it has a width
/// even at 0 and at 1.
///
/// # Errors
/// With fewer than two values on either side, or with a value that is not finite.
pub fn area_under_curve(above: &[f64], below: &[f64]) -> Result<Estimate, NotComputable> {
    check_sample(above, 2)?;
    check_sample(below, 2)?;
    let (n, m) = (count_as_number(above.len()), count_as_number(below.len()));
    let together: Vec<f64> = above.iter().chain(below).copied().collect();
    let rank_sum: f64 = ranks(&together)[..above.len()].iter().sum();
    let value = (rank_sum - n * (n + 1.0) / 2.0) / (n * m);
    // Squared distance from the estimate, minus that spanned by z standard errors.
    let beyond = |area: f64| (area - value) * (area - value) - Z_95 * Z_95 * area_variance(area, n, m);
    let end = |limit: f64| between(value, limit, beyond);
    Ok(Estimate { value, low: end(0.0), high: end(1.0), n: together.len() })
}

/// Returns the variance of an area estimated from samples of n and m values, with the mean of their
/// sizes in place of each.
fn area_variance(area: f64, n: f64, m: f64) -> f64 {
    let size = (n + m) / 2.0 - 1.0;
    area * (1.0 - area) * (1.0 + size * (1.0 - area) / (2.0 - area) + size * area / (1.0 + area)) / (n * m)
}

/// Finds by bisection where `beyond` becomes positive between `inside` and `limit`.
fn between(inside: f64, limit: f64, beyond: impl Fn(f64) -> f64) -> f64 {
    let (mut near, mut far) = (inside, limit);
    for _ in 0..HALVINGS {
        let middle = f64::midpoint(near, far);
        if beyond(middle) > 0.0 { far = middle } else { near = middle }
    }
    far
}
