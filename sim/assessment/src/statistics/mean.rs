//! The mean of a sample.

use statrs::distribution::{ContinuousCDF, StudentsT};

use super::{Estimate, NotComputable, arithmetic_mean, check_sample, count_as_number, sample_variance};

/// Computes the mean with Student's t interval. Without variance the interval has no width.
///
/// # Errors
/// With fewer than two values, or one that is not finite.
pub fn mean(values: &[f64]) -> Result<Estimate, NotComputable> {
    check_sample(values, 2)?;
    let n = count_as_number(values.len());
    let value = arithmetic_mean(values);
    let student = StudentsT::new(0.0, 1.0, n - 1.0).map_err(|_| NotComputable::OutOfRange)?;
    let half = student.inverse_cdf(0.975) * libm::sqrt(sample_variance(values) / n);
    Ok(Estimate { value, low: value - half, high: value + half, n: values.len() })
}
