//! A hand for measurements: repeats the same in–hold–out, with a tremor that no codec can compress
//! away.

use attempt::simulate::MotionSource;
use law::operator::{Felt, Motion, Plan, needle_pose};
use nalgebra::Vector3;

/// Duration of one in–hold–out, in s.
const PERIOD_S: f64 = 15.0;
/// Largest displacement, in m, and height above the skin in between.
const DEEPEST_M: f64 = 0.025;
const ABOVE_M: f64 = 0.005;
/// Tremor: amplitude in m, and frequencies in Hz that share no period.
const TREMOR_M: f64 = 100e-6;
const TREMOR_HZ: [f64; 3] = [8.31, 9.77, 11.13];

/// The hand.
pub struct Rehearsal {
    plan: Plan,
    length_s: f64,
    t_s: f64,
}

impl Rehearsal {
    /// Creates a hand that moves for `length_s`, in s.
    pub fn new(plan: Plan, length_s: f64) -> Self {
        Self { plan, length_s, t_s: 0.0 }
    }
}

impl MotionSource for Rehearsal {
    fn step(&mut self, dt_s: f64, _felt: &Felt) -> Motion {
        self.t_s += dt_s;
        let share = (self.t_s / PERIOD_S).fract();
        let stroke = (share / 0.4).min(1.0).min((1.0 - share) / 0.4);
        let depth_m = stroke * (DEEPEST_M + ABOVE_M) - ABOVE_M;
        let tremor = TREMOR_HZ.map(|hz| TREMOR_M * libm::sin(std::f64::consts::TAU * hz * self.t_s));
        let tip = self.plan.entry_m + self.plan.axis * depth_m + Vector3::from(tremor);
        Motion {
            patient_from_needle: needle_pose(&tip, &self.plan.axis),
            confirm: false,
            done: self.t_s >= self.length_s,
        }
    }
}
