//! Virtual operators: a seeded hand that holds the device, follows a set-point, trembles and reacts to felt pops.
//!
//! A skilled operator is a mass on a spring and a damper (physics section 6) following a set-point along a line that was drawn, with
//! its errors, at the start. After a felt pop the set-point halts, one reaction time late, and goes on after a pause.
//! At the depth the operator takes for the target it stops (one reaction time late again), corrects, holds, confirms
//! and withdraws. Tremor is added to the tip. [`Operator::constant`] is kinematic.
//!
//! The first call of [`Operator::step`] answers the start position, `approach_m` above the entry, whatever its step;
//! each later call advances by its step. A loop that stamps its n-th call (from 0) with n·dt so has t = 0 at the start.

mod constant;
pub(crate) mod gauss;
mod hand;
mod intent;
mod pop;
mod pose;
mod skilled;
mod tremor;

use nalgebra::{Isometry3, Point3, Vector3};

use constant::Constant;
use skilled::Skilled;

pub use hand::{Hand, SetPoint};
pub use pose::needle_pose;

/// What an operator intends.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Plan {
    /// Planned entry on the skin, in the patient frame, in m.
    pub entry_m: Point3<f64>,
    /// Planned direction into the body, unit length.
    pub axis: Vector3<f64>,
    /// Axial displacement to stop at, in m.
    pub target_x_m: f64,
    /// Distance above the skin to start from, in m.
    pub approach_m: f64,
    /// Time to hold at the target before withdrawing, in s.
    pub hold_s: f64,
}

/// How skilled a hand is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Skill {
    /// Mass of the hand, in kg.
    pub mass_kg: f64,
    /// Damping of the hand, in N·s/m.
    pub damping_n_s_per_m: f64,
    /// Stiffness of the hand, in N/m.
    pub stiffness_n_per_m: f64,
    /// Mean insertion speed, in m/s.
    pub speed_m_per_s: f64,
    /// Standard deviation of the speed between attempts, in m/s.
    pub speed_sd_m_per_s: f64,
    /// Mean reaction time to a felt pop, in s.
    pub reaction_s: f64,
    /// Standard deviation of the reaction time, in s.
    pub reaction_sd_s: f64,
    /// Tremor, rms, in m.
    pub tremor_m: f64,
    /// Standard deviation of the angle error, in rad.
    pub angle_sd_rad: f64,
}

impl Skill {
    /// The novice preset.
    #[must_use]
    pub fn novice() -> Self {
        Self {
            mass_kg: 0.55,
            damping_n_s_per_m: 10.0,
            stiffness_n_per_m: 300.0,
            speed_m_per_s: 0.006,
            speed_sd_m_per_s: 0.003,
            reaction_s: 0.25,
            reaction_sd_s: 0.06,
            tremor_m: 150e-6,
            angle_sd_rad: 6.0_f64.to_radians(),
        }
    }

    /// The intermediate preset.
    #[must_use]
    pub fn intermediate() -> Self {
        Self {
            mass_kg: 0.55,
            damping_n_s_per_m: 15.0,
            stiffness_n_per_m: 600.0,
            speed_m_per_s: 0.003,
            speed_sd_m_per_s: 0.001,
            reaction_s: 0.20,
            reaction_sd_s: 0.0,
            tremor_m: 100e-6,
            angle_sd_rad: 4.0_f64.to_radians(),
        }
    }

    /// The expert preset.
    #[must_use]
    pub fn expert() -> Self {
        Self {
            mass_kg: 0.55,
            damping_n_s_per_m: 30.0,
            stiffness_n_per_m: 1500.0,
            speed_m_per_s: 0.0015,
            speed_sd_m_per_s: 0.0005,
            reaction_s: 0.15,
            reaction_sd_s: 0.0,
            tremor_m: 60e-6,
            angle_sd_rad: 2.0_f64.to_radians(),
        }
    }

    /// A skill between two, `s` = 0 for `self`, 1 for `other`; used to let simulated trainees improve.
    #[must_use]
    pub fn towards(&self, other: &Self, s: f64) -> Self {
        let between = |from: f64, to: f64| from * (1.0 - s) + to * s;
        Self {
            mass_kg: between(self.mass_kg, other.mass_kg),
            damping_n_s_per_m: between(self.damping_n_s_per_m, other.damping_n_s_per_m),
            stiffness_n_per_m: between(self.stiffness_n_per_m, other.stiffness_n_per_m),
            speed_m_per_s: between(self.speed_m_per_s, other.speed_m_per_s),
            speed_sd_m_per_s: between(self.speed_sd_m_per_s, other.speed_sd_m_per_s),
            reaction_s: between(self.reaction_s, other.reaction_s),
            reaction_sd_s: between(self.reaction_sd_s, other.reaction_sd_s),
            tremor_m: between(self.tremor_m, other.tremor_m),
            angle_sd_rad: between(self.angle_sd_rad, other.angle_sd_rad),
        }
    }
}

/// What the hand does in a tick.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Motion {
    /// Pose of the needle.
    pub patient_from_needle: Isometry3<f64>,
    /// The operator confirms the position in this tick.
    pub confirm: bool,
    /// The attempt is over.
    pub done: bool,
}

/// A hand at work. Bit-reproducible for a seed.
#[derive(Clone, Debug)]
pub struct Operator {
    hand: Kind,
    last: Option<Motion>,
}

#[derive(Clone, Debug)]
enum Kind {
    Skilled(Box<Skilled>),
    Constant(Constant),
}

impl Operator {
    /// A hand of a skill.
    #[must_use]
    pub fn skilled(skill: &Skill, plan: &Plan, seed: u64) -> Self {
        Self { hand: Kind::Skilled(Box::new(Skilled::new(skill, plan, seed))), last: None }
    }

    /// A perfectly stiff hand at constant speed, in m/s: the test machine of the paper's plots. A speed that is not
    /// above 0 is done at once.
    #[must_use]
    pub fn constant(speed_m_per_s: f64, plan: &Plan) -> Self {
        Self { hand: Kind::Constant(Constant::new(speed_m_per_s, plan)), last: None }
    }

    /// Advances by `dt_s` under the force that the needle puts on the hand, in N, in the patient frame.
    ///
    /// A step that is not above 0 repeats the last motion; a force that is not finite counts as none.
    pub fn step(&mut self, dt_s: f64, force_n: &Vector3<f64>) -> Motion {
        let force_n = if force_n.iter().all(|part| part.is_finite()) { *force_n } else { Vector3::zeros() };
        let motion = match (&mut self.hand, self.last) {
            (Kind::Skilled(hand), None) => hand.start(),
            (Kind::Constant(hand), None) => hand.advance(0.0),
            (_, Some(last)) if !(dt_s > 0.0 && dt_s.is_finite()) => Motion { confirm: false, ..last },
            (Kind::Skilled(hand), Some(_)) => hand.advance(dt_s, &force_n),
            (Kind::Constant(hand), Some(_)) => hand.advance(dt_s),
        };
        self.last = Some(motion);
        motion
    }
}
