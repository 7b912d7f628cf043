//! Comparison of two groups: significance, effect size, and correction for multiple tests.

use statrs::distribution::{ContinuousCDF, StudentsT};

use super::rank::ranks;
use super::{Estimate, NotComputable, arithmetic_mean, check_sample, count_as_number, sample_variance};

/// Largest total number of observations for which the distribution of the rank sum is enumerated;
/// above, the normal approximation is accurate to four digits.
const COUNTED: usize = 40;

/// The Mann–Whitney test of two independent groups.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize)]
pub struct RankSumTest {
    /// Number of pairs in which the first group's value is the larger, ties count half: 0 to n₁·n₂.
    pub u: f64,
    /// Two-sided p-value: probability of a U at least as far from its mean if the groups do not
    /// differ, 0–1.
    pub p: f64,
    /// Whether the p-value is exact (enumerated) or approximated.
    pub exact: bool,
    /// Size of the first group.
    pub first_n: usize,
    /// Size of the second group.
    pub second_n: usize,
}

/// Mann and Whitney (1947), "On a test of whether one of two random variables is stochastically
/// larger than the other", Annals of Mathematical Statistics 18, 50–60. For up to 40 values the
/// p-value is exact: enumerated over all assignments of the values (including ties) to the groups,
/// twice the smaller tail; above, by the normal distribution with corrections for ties and for
/// continuity.
///
/// # Errors
/// With fewer than two values on either side, if all values are equal, or with a value that is not
/// finite.
pub fn mann_whitney(first: &[f64], second: &[f64]) -> Result<RankSumTest, NotComputable> {
    check_sample(first, 2)?;
    check_sample(second, 2)?;
    let together: Vec<f64> = first.iter().chain(second).copied().collect();
    let ranks = ranks(&together);
    if ranks.iter().all(|rank| rank.total_cmp(&ranks[0]).is_eq()) {
        return Err(NotComputable::NoVariance);
    }
    let n = count_as_number(first.len());
    let rank_sum: f64 = ranks[..first.len()].iter().sum();
    let exact = together.len() <= COUNTED;
    let p = if exact { counted_tail(&ranks, first.len()) } else { normal_tail(&ranks, first.len()) };
    Ok(RankSumTest { u: rank_sum - n * (n + 1.0) / 2.0, p, exact, first_n: first.len(), second_n: second.len() })
}

/// Returns twice the smaller tail of the rank sum of the first `taken`, enumerated over all subsets
/// of that size.
fn counted_tail(ranks: &[f64], taken: usize) -> f64 {
    // Mean ranks are multiples of one half, so twice a rank is an integer.
    let doubled: Vec<usize> = ranks.iter().map(|rank| (rank * 2.0) as usize).collect();
    let observed: usize = doubled[..taken].iter().sum();
    let most: usize = doubled.iter().sum();
    // `ways[k][s]`: number of subsets of k ranks whose doubled ranks sum to s.
    let mut ways = vec![vec![0.0; most + 1]; taken + 1];
    ways[0][0] = 1.0;
    for rank in doubled {
        for count in (1..=taken).rev() {
            let (fewer, with) = ways.split_at_mut(count);
            for sum in rank..=most {
                with[0][sum] += fewer[count - 1][sum - rank];
            }
        }
    }
    let all: f64 = ways[taken].iter().sum();
    let below: f64 = ways[taken][..=observed].iter().sum();
    let above: f64 = ways[taken][observed..].iter().sum();
    (2.0 * below.min(above) / all).min(1.0)
}

/// Returns the same by the normal approximation.
fn normal_tail(ranks: &[f64], taken: usize) -> f64 {
    let (n, m) = (count_as_number(taken), count_as_number(ranks.len() - taken));
    let all = n + m;
    let u = ranks[..taken].iter().sum::<f64>() - n * (n + 1.0) / 2.0;
    let mut sorted = ranks.to_vec();
    sorted.sort_by(f64::total_cmp);
    let ties: f64 = sorted
        .chunk_by(|a, b| a.total_cmp(b).is_eq())
        .map(|tied| count_as_number(tied.len()))
        .map(|t| t * t * t - t)
        .sum();
    let deviation = libm::sqrt(n * m / 12.0 * (all + 1.0 - ties / (all * (all - 1.0))));
    let z = ((u - n * m / 2.0).abs() - 0.5).max(0.0) / deviation;
    libm::erfc(z / std::f64::consts::SQRT_2)
}

/// Difference of two groups' means in units of the pooled standard deviation, corrected for small
/// samples; positive if the first is larger. Hedges (1981), "Distribution theory for Glass's
/// estimator of effect size and related estimators", Journal of Educational Statistics 6, 107–128;
/// interval from the standard error √((n+m)/(n·m) + g²/(2(n+m))) and Student's t.
///
/// # Errors
/// With fewer than two values on either side, without variance within the groups, or with a value
/// that is not finite.
pub fn hedges_g(first: &[f64], second: &[f64]) -> Result<Estimate, NotComputable> {
    check_sample(first, 2)?;
    check_sample(second, 2)?;
    let (n, m) = (count_as_number(first.len()), count_as_number(second.len()));
    let freedom = n + m - 2.0;
    let variance = ((n - 1.0) * sample_variance(first) + (m - 1.0) * sample_variance(second)) / freedom;
    if variance <= 0.0 {
        return Err(NotComputable::NoVariance);
    }
    let apart = (arithmetic_mean(first) - arithmetic_mean(second)) / libm::sqrt(variance);
    let value = apart * (1.0 - 3.0 / (4.0 * freedom - 1.0));
    let student = StudentsT::new(0.0, 1.0, freedom).map_err(|_| NotComputable::OutOfRange)?;
    let half = student.inverse_cdf(0.975) * libm::sqrt((n + m) / (n * m) + value * value / (2.0 * (n + m)));
    Ok(Estimate { value, low: value - half, high: value + half, n: first.len() + second.len() })
}

/// Adjusts p-values for multiple tests, so that the familywise error rate stays at that of a single
/// test: Holm (1979), "A simple sequentially rejective multiple test procedure", Scandinavian
/// Journal of Statistics 6, 65–70. Returns them in the given order.
#[must_use]
pub fn holm_adjusted(probabilities: &[f64]) -> Vec<f64> {
    let mut order: Vec<usize> = (0..probabilities.len()).collect();
    order.sort_by(|&a, &b| probabilities[a].total_cmp(&probabilities[b]));
    let mut adjusted = vec![0.0; probabilities.len()];
    let mut so_far: f64 = 0.0;
    for (place, &at) in order.iter().enumerate() {
        so_far = so_far.max(probabilities[at] * count_as_number(probabilities.len() - place)).min(1.0);
        adjusted[at] = so_far;
    }
    adjusted
}
