//! Tick times, on a grid of whole periods since the first tick.

use super::StartError;

/// Stamps ticks with strictly increasing whole numbers of periods.
#[derive(Clone, Debug)]
pub(super) struct TickGrid {
    rate_hz: f64,
    /// Time of the first tick, in s.
    origin_s: Option<f64>,
    /// Number of the next tick.
    next: u64,
}

impl TickGrid {
    /// A grid before its first tick.
    ///
    /// # Errors
    /// If `rate_hz` is not positive and finite.
    pub fn new(rate_hz: f64) -> Result<Self, StartError> {
        match rate_hz > 0.0 && rate_hz.is_finite() {
            true => Ok(Self { rate_hz, origin_s: None, next: 0 }),
            false => Err(StartError::Rate(rate_hz)),
        }
    }

    pub fn period_s(&self) -> f64 {
        1.0 / self.rate_hz
    }

    /// Due time of the next tick, in s of the same clock; `None` before the first.
    pub fn due_s(&self) -> Option<f64> {
        self.origin_s.map(|origin_s| origin_s + self.next as f64 / self.rate_hz)
    }

    /// Stamps a tick made now and returns its time, in s since the first: a multiple of the period.
    ///
    /// Each tick is one period after the last one, regardless of jitter. Only a tick more than a
    /// whole period late skips the missed periods, so that a stall is a gap in the times and not a
    /// change of rate.
    pub fn stamp(&mut self, now_s: f64) -> f64 {
        let passed = (now_s - *self.origin_s.get_or_insert(now_s)) * self.rate_hz;
        if passed - self.next as f64 > 1.0 {
            self.next = passed.round() as u64;
        }
        let t_s = self.next as f64 / self.rate_hz;
        self.next += 1;
        t_s
    }
}

#[cfg(test)]
mod tests {
    //! The force law rejects times that repeat or go back; times that drift no longer locate events.

    use super::*;

    /// Stamps of ticks made at times in ms, as numbers of periods of 1 ms.
    fn stamps(made_ms: impl IntoIterator<Item = f64>) -> Vec<u64> {
        let mut grid = TickGrid::new(1000.0).expect("a rate");
        made_ms.into_iter().map(|ms| (grid.stamp(5.0 + ms * 1e-3) * 1000.0).round() as u64).collect()
    }

    #[test]
    fn trembling_leaves_no_trace_and_a_stall_is_a_gap() {
        assert_eq!(stamps([0.0, 1.4, 1.9, 3.0, 3.9]), [0, 1, 2, 3, 4]);
        assert_eq!(stamps([0.0, 1.0, 9.2, 9.9, 11.0]), [0, 1, 9, 10, 11]);
        assert_eq!(stamps([0.0, 0.0, -3.0, 0.1]), [0, 1, 2, 3], "times rise whatever the clock says");
    }

    #[test]
    fn a_slower_clock_leaves_one_out_now_and_then() {
        let times = stamps((0..10_000).map(|tick| f64::from(tick) * 1.001));
        assert!(times.windows(2).all(|pair| pair[1] > pair[0] && pair[1] - pair[0] <= 2));
        assert!(times[9999].abs_diff(10_009) <= 1, "{}", times[9999]);
    }

    #[test]
    fn the_next_tick_is_due_a_period_after_the_last() {
        let mut grid = TickGrid::new(1000.0).expect("a rate");
        assert_eq!(grid.due_s(), None);
        grid.stamp(5.0);
        assert!((grid.due_s().expect("begun") - 5.001).abs() < 1e-12);
    }
}
