//! The interval of a proportion.

use super::{Estimate, NotComputable, Z_95, count_as_number};

/// Wilson's score interval for `successes` among `trials` (Wilson 1927, without continuity
/// correction).
///
/// # Errors
/// Without trials, or with more successes than trials.
pub fn wilson(successes: usize, trials: usize) -> Result<Estimate, NotComputable> {
    if trials == 0 {
        return Err(NotComputable::TooFew { found: 0, needed: 1 });
    }
    if successes > trials {
        return Err(NotComputable::OutOfRange);
    }
    let n = count_as_number(trials);
    let share = count_as_number(successes) / n;
    let z2 = Z_95 * Z_95;
    let centre = (share + z2 / (2.0 * n)) / (1.0 + z2 / n);
    let half = Z_95 / (1.0 + z2 / n) * libm::sqrt(share * (1.0 - share) / n + z2 / (4.0 * n * n));
    Ok(Estimate { value: share, low: (centre - half).max(0.0), high: (centre + half).min(1.0), n: trials })
}
