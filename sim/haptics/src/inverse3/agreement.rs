//! Detects a service that does not apply the commanded force: it silently ignores messages that it
//! does not understand, but its state reports the force that the arm applies.

use nalgebra::Vector3;

/// Number of recent commands that a report may refer to: those of some twenty milliseconds.
const RECENT: usize = 32;
/// A report matches a command within this, in N, plus a fraction of the force: the service rounds
/// and filters.
const NEAR_N: f64 = 0.15;
const NEAR_PART: f64 = 0.15;
/// Time for which reports must differ before they count as a disagreement, in s.
const PATIENCE_S: f64 = 0.25;

/// Recent commands, and the start of the current run of differing reports.
#[derive(Clone, Debug)]
pub struct Agreement {
    told_n: [Vector3<f64>; RECENT],
    differs_since_s: Option<f64>,
}

impl Default for Agreement {
    /// No command yet: zero force.
    fn default() -> Self {
        Self { told_n: [Vector3::zeros(); RECENT], differs_since_s: None }
    }
}

impl Agreement {
    /// Records a commanded force, in N.
    pub fn told(&mut self, force_n: Vector3<f64>) {
        self.told_n.rotate_right(1);
        self.told_n[0] = force_n;
    }

    /// Returns whether the service applies a force other than the commanded one, given a report in
    /// N at a time in s.
    pub fn disagrees(&mut self, reported_n: &Vector3<f64>, now_s: f64) -> bool {
        let is_near = |told_n: &Vector3<f64>| (reported_n - told_n).norm() <= NEAR_N + NEAR_PART * told_n.norm();
        self.differs_since_s = match self.told_n.iter().any(is_near) {
            true => None,
            false => self.differs_since_s.or(Some(now_s)),
        };
        self.differs_since_s.is_some_and(|since_s| now_s - since_s >= PATIENCE_S)
    }
}

#[cfg(test)]
mod tests {
    //! A service that ignores forces must be detected; one that is late, rounds or filters must
    //! not.

    use super::*;

    /// Whether it disagrees after a second in which a force along x is commanded and another
    /// reported each millisecond.
    fn after_a_second(told_n: impl Fn(f64) -> f64, reported_n: impl Fn(f64) -> f64) -> bool {
        let mut agreement = Agreement::default();
        let along = |n: f64| Vector3::new(n, 0.0, 0.0);
        (0..1000).fold(false, |_, ms| {
            let t_s = f64::from(ms) * 1e-3;
            agreement.told(along(told_n(t_s)));
            agreement.disagrees(&along(reported_n(t_s)), t_s)
        })
    }

    #[test]
    fn missing_force_is_detected_and_a_late_force_is_tolerated() {
        assert!(after_a_second(|_| 1.0, |_| 0.0), "ignored");
        assert!(after_a_second(|_| 2.0, |_| 1.0), "halved by a setting");
        assert!(after_a_second(|_| 1.0, |_| -1.0), "turned round");
        assert!(!after_a_second(|_| 1.0, |_| 0.9), "rounded");
        let push = |t_s: f64| 3.0 * (8.0 * t_s.rem_euclid(0.25) - 1.0);
        assert!(!after_a_second(push, |t_s| push((t_s - 0.01).max(0.0))), "ten milliseconds late");
        assert!(!after_a_second(|_| 0.0, |_| 0.0));
    }

    #[test]
    fn a_moment_is_no_disagreement() {
        assert!(!after_a_second(|_| 1.0, |t_s| if t_s > 0.8 { 0.0 } else { 1.0 }));
    }
}
