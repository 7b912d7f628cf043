//! The test machine: constant speed in, hold, the same speed out.

use super::{Motion, Plan, needle_pose};

#[derive(Clone, Debug)]
pub(super) struct Constant {
    plan: Plan,
    speed_m_per_s: f64,
    elapsed_s: f64,
    confirmed: bool,
}

impl Constant {
    pub fn new(speed_m_per_s: f64, plan: &Plan) -> Self {
        Self { plan: *plan, speed_m_per_s, elapsed_s: 0.0, confirmed: false }
    }

    /// Advances and returns the pose; confirms in the tick that ends the hold.
    pub fn advance(&mut self, dt_s: f64) -> Motion {
        self.elapsed_s += dt_s;
        let way_m = self.plan.target_x_m + self.plan.approach_m;
        let arrival_s = way_m / self.speed_m_per_s;
        let leave_s = arrival_s + self.plan.hold_s;
        let moves = self.speed_m_per_s > 0.0;
        let back_s = (self.elapsed_s - leave_s).max(0.0);
        let travelled_m = (self.speed_m_per_s * self.elapsed_s).min(way_m) - self.speed_m_per_s * back_s;
        let x_m = if moves { travelled_m.max(0.0) - self.plan.approach_m } else { -self.plan.approach_m };
        let confirm = moves && !self.confirmed && self.elapsed_s >= leave_s;
        self.confirmed |= confirm;
        Motion {
            patient_from_needle: needle_pose(&(self.plan.entry_m + self.plan.axis * x_m), &self.plan.axis),
            confirm,
            done: !moves || self.elapsed_s >= leave_s + arrival_s,
        }
    }
}
