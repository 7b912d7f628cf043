//! The thermal budget: the force's rms over any minute stays within the continuous force of the
//! motors.
//!
//! Squares of the force are summed in one-second buckets. When the sum over the last minute
//! approaches the budget, the maximum force is reduced, to zero at the budget itself, so that the
//! budget is never exceeded.

use nalgebra::Vector3;

/// Length of the window, in buckets of a second.
const WINDOW: usize = 60;
/// Fraction of the budget at which the maximum force begins to decrease.
const WARM: f64 = 0.8;

/// Thermal limits of the motors.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ThermalParams {
    /// Tick period, in s.
    pub period_s: f64,
    /// Maximum force, in N.
    pub max_force_n: f64,
    /// Continuous force, in N. If it is not below the maximum, there is no budget to keep.
    pub continuous_force_n: f64,
}

/// The last minute.
#[derive(Clone, Debug)]
pub struct ThermalState {
    /// Integral of the squared force over each finished second, in N²·s; the oldest is overwritten.
    buckets: [f64; WINDOW],
    oldest: usize,
    /// The same integral over the current second.
    current: f64,
    /// Elapsed time of the current second, in s.
    current_s: f64,
}

impl Default for ThermalState {
    fn default() -> Self {
        Self { buckets: [0.0; WINDOW], oldest: 0, current: 0.0, current_s: 0.0 }
    }
}

impl ThermalState {
    /// The integral over the window, in N²·s. Summed anew each time: a running sum would drift.
    fn sum(&self) -> f64 {
        self.buckets.iter().sum::<f64>() + self.current
    }

    fn book(&mut self, force_n: &Vector3<f64>, period_s: f64) {
        self.current += force_n.norm_squared() * period_s;
        self.current_s += period_s;
        if self.current_s >= 1.0 {
            if let Some(bucket) = self.buckets.get_mut(self.oldest) {
                *bucket = self.current;
            }
            self.oldest = (self.oldest + 1) % WINDOW;
            self.current = 0.0;
            self.current_s = 0.0;
        }
    }
}

/// Returns the force that the budget allows, in N, and whether it was reduced.
pub fn step(params: &ThermalParams, state: &mut ThermalState, wanted_n: &Vector3<f64>) -> (Vector3<f64>, bool) {
    let ThermalParams { period_s, max_force_n, continuous_force_n } = *params;
    if continuous_force_n >= max_force_n {
        return (*wanted_n, false);
    }
    let budget = continuous_force_n * continuous_force_n * WINDOW as f64;
    let used = state.sum() / budget;
    // With a budget of zero the quotient is NaN or infinite: no force then.
    let left = if used < 1.0 { ((1.0 - used) / (1.0 - WARM)).min(1.0) } else { 0.0 };
    let (force_n, reduced) = super::clamp::norm(wanted_n, max_force_n * left);
    state.book(&force_n, period_s);
    (force_n, reduced)
}

#[cfg(test)]
#[expect(clippy::float_cmp, reason = "what is kept must be kept to the bit")]
mod tests {
    //! A window that forgets, or a late reduction, would overheat the motors over a minute without
    //! being noticed.

    use super::*;

    const TOUCH: ThermalParams = ThermalParams { period_s: 1e-3, max_force_n: 3.3, continuous_force_n: 0.88 };

    /// Forces sent over `seconds` for a wanted force as a function of time, in N.
    fn sent(seconds: u32, wanted_n: impl Fn(f64) -> f64) -> Vec<f64> {
        let mut state = ThermalState::default();
        let ticks = 0..seconds * 1000;
        ticks
            .map(|tick| step(&TOUCH, &mut state, &Vector3::new(0.0, wanted_n(f64::from(tick) * 1e-3), 0.0)).0.y)
            .collect()
    }

    fn worst_rms_n(sent: &[f64]) -> f64 {
        let mut sums = vec![0.0];
        sent.iter().for_each(|f| sums.push(sums[sums.len() - 1] + f * f));
        (60_000..sums.len())
            .map(|end| ((sums[end] - sums[end - 60_000]) / 60_000.0).max(0.0).sqrt())
            .fold(0.0, f64::max)
    }

    #[test]
    fn the_rms_of_no_minute_exceeds_the_rating() {
        for (name, sent) in [
            ("all the time", sent(200, |_| 3.3)),
            ("late", sent(200, |t| if t < 55.0 { 0.0 } else { 3.3 })),
            ("in bursts", sent(200, |t| if t % 20.0 < 3.0 { 3.3 } else { 0.1 })),
        ] {
            let rms_n = worst_rms_n(&sent);
            assert!(rms_n <= 0.88 && rms_n > 0.5, "{name}: {rms_n} N");
        }
    }

    #[test]
    fn what_stays_below_the_rating_is_never_touched_and_a_pop_is_whole() {
        assert!(sent(150, |_| 0.75).iter().all(|&f| f == 0.75));
        assert!(sent(3, |_| 3.3).iter().all(|&f| f == 3.3), "three seconds of the largest force are within the budget");
    }

    #[test]
    fn without_a_rating_there_is_no_force() {
        let params = ThermalParams { continuous_force_n: 0.0, ..TOUCH };
        let mut state = ThermalState::default();
        assert_eq!(step(&params, &mut state, &Vector3::x()).0, Vector3::zeros());
    }
}
