//! Virtual operators: a seeded hand that holds the device, follows a set-point, trembles and reacts to felt pops.

mod pose;

use nalgebra::{Isometry3, Point3, Vector3};

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
        unimplemented!()
    }
    /// The intermediate preset.
    #[must_use]
    pub fn intermediate() -> Self {
        unimplemented!()
    }
    /// The expert preset.
    #[must_use]
    pub fn expert() -> Self {
        unimplemented!()
    }
    /// A skill between two, `s` = 0 for `self`, 1 for `other`; used to let simulated trainees improve.
    #[must_use]
    pub fn towards(&self, _other: &Self, _s: f64) -> Self {
        unimplemented!()
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
    _private: (),
}

impl Operator {
    /// A hand of a skill.
    #[must_use]
    pub fn skilled(_skill: &Skill, _plan: &Plan, _seed: u64) -> Self {
        unimplemented!()
    }

    /// A perfectly stiff hand at constant speed, in m/s: the test machine of the paper's plots.
    #[must_use]
    pub fn constant(_speed_m_per_s: f64, _plan: &Plan) -> Self {
        unimplemented!()
    }

    /// Advances by `dt_s` under the force that the needle puts on the hand, in N, in the patient frame.
    pub fn step(&mut self, _dt_s: f64, _force_n: &Vector3<f64>) -> Motion {
        unimplemented!()
    }
}
