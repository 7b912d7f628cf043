//! Lateness and compute time of ticks, in histograms of bounded memory that are allocated before
//! the first tick.

use std::fmt;

use hdrhistogram::Histogram;
use hdrhistogram::errors::CreationError;

/// Longest time that the histogram resolves, in ns: longer times count as this.
const LONGEST_NS: u64 = 10_000_000_000;
/// Significant decimal digits of the histogram.
const DIGITS: u8 = 2;

/// Quantiles of a time, in µs.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Quantiles {
    /// Median, in µs.
    pub p50_us: f64,
    /// 99th percentile, in µs.
    pub p99_us: f64,
    /// 99.9th percentile, in µs.
    pub p999_us: f64,
    /// Largest, in µs.
    pub max_us: f64,
}

impl fmt::Display for Quantiles {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { p50_us, p99_us, p999_us, max_us } = self;
        write!(f, "p50 {p50_us:.1}, p99 {p99_us:.1}, p99.9 {p999_us:.1}, max {max_us:.1} µs")
    }
}

/// The distribution of a time.
#[derive(Clone, Debug)]
pub struct Times {
    histogram: Histogram<u64>,
}

impl Times {
    /// An empty distribution.
    ///
    /// # Errors
    /// Never with the bounds used here; the library checks them.
    pub(super) fn new() -> Result<Self, CreationError> {
        Ok(Self { histogram: Histogram::new_with_bounds(10, LONGEST_NS, DIGITS)? })
    }

    /// Adds a time in s; negative times count as zero.
    pub(super) fn add(&mut self, time_s: f64) {
        // The cast saturates: negative values and NaN become 0.
        self.histogram.saturating_record((time_s * 1e9) as u64);
    }

    /// Number of measurements.
    #[must_use]
    pub fn count(&self) -> u64 {
        self.histogram.len()
    }

    /// Number of measurements longer than a time in µs, to the histogram's two digits.
    #[must_use]
    pub fn longer_than_us(&self, time_us: f64) -> u64 {
        let next = self.histogram.next_non_equivalent((time_us * 1e3) as u64);
        self.histogram.count_between(next, self.histogram.high())
    }

    /// The quantile at `share` (0 to 1), in µs.
    #[must_use]
    pub fn at_us(&self, share: f64) -> f64 {
        self.histogram.value_at_quantile(share) as f64 * 1e-3
    }

    /// The quantiles for reports.
    #[must_use]
    pub fn quantiles(&self) -> Quantiles {
        let max_us = self.histogram.max() as f64 * 1e-3;
        Quantiles { p50_us: self.at_us(0.5), p99_us: self.at_us(0.99), p999_us: self.at_us(0.999), max_us }
    }

    /// Each measured time, in µs, ascending, with the fraction of the measurements that exceed it.
    #[must_use]
    pub fn exceeded(&self) -> Vec<(f64, f64)> {
        let count = self.count().max(1) as f64;
        let mut left = self.count();
        let share = |bucket: hdrhistogram::iterators::IterationValue<u64>| {
            left -= bucket.count_since_last_iteration();
            (bucket.value_iterated_to() as f64 * 1e-3, left as f64 / count)
        };
        self.histogram.iter_recorded().map(share).collect()
    }
}

#[cfg(test)]
mod tests {
    //! The histogram must not grow, and its quantiles must be as precise as documented.

    use super::*;

    #[test]
    fn quantiles_are_right_within_two_digits() {
        let mut times = Times::new().expect("our bounds are right");
        (1..=1000).for_each(|us| times.add(f64::from(us) * 1e-6));
        let Quantiles { p50_us, p99_us, p999_us, max_us } = times.quantiles();
        for (found, right) in [(p50_us, 500.0), (p99_us, 990.0), (p999_us, 999.0), (max_us, 1000.0)] {
            assert!((found / right - 1.0).abs() < 0.01, "{found} for {right}");
        }
        assert!(times.longer_than_us(900.0).abs_diff(100) <= 10, "{}", times.longer_than_us(900.0));
        assert_eq!((times.longer_than_us(0.0), times.longer_than_us(2000.0)), (1000, 0));
        let exceeded = times.exceeded();
        assert!(exceeded.windows(2).all(|pair| pair[0].0 < pair[1].0 && pair[0].1 > pair[1].1));
        assert_eq!(exceeded.last().map(|point| point.1), Some(0.0));
    }

    #[test]
    fn nonsense_is_counted_and_contained() {
        let mut times = Times::new().expect("our bounds are right");
        [-1.0, f64::NAN, f64::INFINITY, 1e9].into_iter().for_each(|time_s| times.add(time_s));
        assert_eq!(times.count(), 4);
        assert!(times.quantiles().max_us <= 1.01e7);
    }
}
