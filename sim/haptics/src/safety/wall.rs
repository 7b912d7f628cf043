//! Passivity of a virtual wall: b > K T/2 + |B| (Colgate and Schenkel 1997).
//!
//! A wall of stiffness K sampled with period T returns more energy than it absorbed, as if it were
//! damped by −K T/2; an additional force delay d adds K d. The handle's own damping b must exceed
//! that and the wall's own damping |B|.

/// A wall as the servo renders it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WorkspaceWall {
    /// Stiffness, in N/m.
    pub stiffness_n_per_m: f64,
    /// Virtual damping, in N·s/m.
    pub damping_n_s_per_m: f64,
    /// Tick period, in s.
    pub period_s: f64,
    /// Delay of the force in addition to the hold of one period, in s.
    pub delay_s: f64,
}

impl WorkspaceWall {
    /// The damping that the handle itself must have, in N·s/m.
    #[must_use]
    pub fn needs_n_s_per_m(&self) -> f64 {
        self.stiffness_n_per_m * (0.5 * self.period_s + self.delay_s) + self.damping_n_s_per_m.abs()
    }
}

#[cfg(test)]
mod tests {
    //! The two figures of physics section 5.

    use super::*;

    #[test]
    fn muscle_at_1_khz_and_a_millisecond_of_delay() {
        let wall = WorkspaceWall { stiffness_n_per_m: 497.0, damping_n_s_per_m: 0.0, period_s: 1e-3, delay_s: 0.0 };
        assert!((wall.needs_n_s_per_m() - 0.2485).abs() < 1e-12);
        let delayed = WorkspaceWall { delay_s: 1e-3, ..wall };
        assert!((delayed.needs_n_s_per_m() / wall.needs_n_s_per_m() - 3.0).abs() < 1e-12);
        let damped = WorkspaceWall { damping_n_s_per_m: -0.1, ..wall };
        assert!((damped.needs_n_s_per_m() - 0.3485).abs() < 1e-12);
    }
}
