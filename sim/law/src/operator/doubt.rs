//! Doubt during an insertion: the operator hesitates now and then, and once in each insertion judges
//! where its line leads.
//!
//! It compares the point at which its line meets the depth of the target with the planned one, and
//! misjudges the angle between the two. If the distance seems too large, the operator withdraws the
//! needle and turns it. A careful operator thus turns back from a good line at times, and a careless
//! one stays on a bad line.

use nalgebra::Vector3;

use super::Skill;
use super::gauss::Draw;
use super::lean::Lean;

/// Part of the way to the target at which an operator judges its line, from and to (choice).
const JUDGED_AT: [f64; 2] = [0.3, 0.9];
/// Maximum number of insertions that an operator abandons in doubt (choice).
const MAX_ABANDONED: u32 = 3;

#[derive(Clone, Debug)]
pub(super) struct Doubt {
    draw: Draw,
    goal_m: f64,
    hesitations_per_m: f64,
    judgement_sd_rad: f64,
    accepted_m: f64,
    /// Depths of the next hesitation and of the judgement, in m.
    hesitates_at_m: f64,
    judges_at_m: f64,
    abandoned: u32,
}

impl Doubt {
    pub fn new(skill: &Skill, goal_m: f64, draw: Draw) -> Self {
        let mut doubt = Self {
            draw,
            goal_m,
            hesitations_per_m: skill.hesitations_per_m,
            judgement_sd_rad: skill.judgement_sd_rad,
            accepted_m: skill.accepted_m,
            hesitates_at_m: 0.0,
            judges_at_m: 0.0,
            abandoned: 0,
        };
        doubt.start_insertion();
        doubt
    }

    /// Draws the depths for a new insertion.
    pub fn start_insertion(&mut self) {
        let [from, to] = JUDGED_AT;
        self.judges_at_m = self.goal_m * (from + (to - from) * self.draw.uniform());
        self.hesitates_at_m = self.draw_way_m();
    }

    /// Whether the operator hesitates at a depth in m.
    pub fn hesitates(&mut self, x_m: f64) -> bool {
        let hesitates = x_m >= self.hesitates_at_m;
        if hesitates {
            self.hesitates_at_m = x_m + self.draw_way_m();
        }
        hesitates
    }

    /// Whether the operator abandons its line at a depth in m.
    pub fn abandons(&mut self, x_m: f64, lean: &Lean) -> bool {
        if x_m < self.judges_at_m {
            return false;
        }
        self.judges_at_m = f64::INFINITY;
        let error = Vector3::from_fn(|_, _| self.draw.normal(self.judgement_sd_rad * core::f64::consts::FRAC_1_SQRT_2));
        let across = error - lean.planned() * error.dot(lean.planned());
        let off_m = self.goal_m * (lean.axis - lean.planned() + across).norm();
        let abandons = off_m > self.accepted_m && self.abandoned < MAX_ABANDONED;
        self.abandoned += u32::from(abandons);
        abandons
    }

    /// A random distance to the next hesitation, in m; infinite for an operator that never hesitates.
    fn draw_way_m(&mut self) -> f64 {
        -libm::log(self.draw.uniform()) / self.hesitations_per_m
    }
}
