//! Stiffness of the grip: it follows the force, and a hard push brings in the other hand.
//!
//! An arm's stiffness grows about in proportion to the force it exerts (Gomi and Osu 1998). Needles
//! that need much force are pushed with two hands that rest on the body. The grip tightens within a
//! tenth of a second and loosens slowly, so that a drop of the force occurs at the stiffness of the
//! push.

/// Push, in N, at which the other hand joins, and at which both are braced (choice).
const BRACING_N: (f64, f64) = (3.5, 8.0);
/// Time constant of tightening, in s (choice, near the electromechanical delay of muscle).
const TIGHTENING_S: f64 = 0.1;
/// Time constant of loosening, in s (choice).
const LOOSENING_S: f64 = 1.0;

/// The stiffness of the grip.
#[derive(Clone, Debug)]
pub(super) struct Grip {
    light_n_per_m: f64,
    brace_n_per_m: f64,
    /// The current stiffness, in N/m.
    pub stiffness_n_per_m: f64,
}

impl Grip {
    /// A light grip, with the stiffness that bracing adds, both in N/m.
    pub fn new(light_n_per_m: f64, brace_n_per_m: f64) -> Self {
        Self { light_n_per_m, brace_n_per_m, stiffness_n_per_m: light_n_per_m }
    }

    /// Follows a push, in N, for `dt_s`. Returns the old stiffness divided by the new.
    pub fn follow(&mut self, dt_s: f64, push_n: f64) -> f64 {
        let (from_n, to_n) = BRACING_N;
        let braced = ((push_n - from_n) / (to_n - from_n)).clamp(0.0, 1.0);
        let wanted_n_per_m = self.light_n_per_m + braced * self.brace_n_per_m;
        let old_n_per_m = self.stiffness_n_per_m;
        let time_s = if wanted_n_per_m > old_n_per_m { TIGHTENING_S } else { LOOSENING_S };
        self.stiffness_n_per_m += (wanted_n_per_m - old_n_per_m) * (dt_s / (time_s + dt_s));
        old_n_per_m / self.stiffness_n_per_m
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn hard_push_braces_the_grip_quickly_and_a_drop_loosens_slowly() {
        let mut grip = Grip::new(200.0, 2000.0);
        (0..1000).for_each(|_| _ = grip.follow(1e-3, 3.0));
        assert!((grip.stiffness_n_per_m - 200.0).abs() < 1e-9, "three newtons are one hand's");
        (0..500).for_each(|_| _ = grip.follow(1e-3, 12.0));
        let braced = grip.stiffness_n_per_m;
        assert!((2100.0..=2200.0).contains(&braced), "{braced}");
        (0..100).for_each(|_| _ = grip.follow(1e-3, 0.5));
        assert!(grip.stiffness_n_per_m > 0.9 * braced, "still braced a tenth of a second after the drop");
    }
}
