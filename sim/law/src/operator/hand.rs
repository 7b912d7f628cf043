//! The hand: a mass on a spring and a damper, pulled by a set-point and pushed by the tissue.

use nalgebra::Vector3;

use super::Skill;

/// Mass of the device that the hand holds, in kg (physics section 6).
const DEVICE_KG: f64 = 0.045;

/// The set-point of a hand.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SetPoint {
    /// Position, in m.
    pub position_m: Vector3<f64>,
    /// Velocity, in m/s.
    pub velocity_m_per_s: Vector3<f64>,
}

/// Hand and device as one moving mass.
#[derive(Clone, Debug, PartialEq)]
pub struct Hand {
    mass_kg: f64,
    damping_n_s_per_m: f64,
    stiffness_n_per_m: f64,
    /// Damping divided by the root of the stiffness, constant for any grip.
    damping_per_root: f64,
    /// Position, in m.
    pub position_m: Vector3<f64>,
    velocity_m_per_s: Vector3<f64>,
}

impl Hand {
    /// A hand with a skill, at rest at a position in m.
    #[must_use]
    pub fn new(skill: &Skill, position_m: Vector3<f64>) -> Self {
        Self {
            mass_kg: skill.mass_kg + DEVICE_KG,
            damping_n_s_per_m: skill.damping_n_s_per_m,
            stiffness_n_per_m: skill.stiffness_n_per_m,
            damping_per_root: skill.damping_n_s_per_m / libm::sqrt(skill.stiffness_n_per_m),
            position_m,
            velocity_m_per_s: Vector3::zeros(),
        }
    }

    /// Advances by `dt_s` under a force on the hand, in N.
    ///
    /// M a = K (p_set − p) + B (v_set − v) + F, backward Euler in the hand's own spring and damper,
    /// explicit in the tissue's force.
    ///
    /// The hand's part is stable at any step; the tissue's needs k dt² < 4 M, which at 1 kHz holds
    /// up to 2 MN/m.
    pub fn step(&mut self, dt_s: f64, set_point: &SetPoint, force_n: &Vector3<f64>) {
        let (k, b) = (self.stiffness_n_per_m, self.damping_n_s_per_m);
        let pull_n = (set_point.position_m - self.position_m) * k + set_point.velocity_m_per_s * b + force_n;
        let inertia_kg = self.mass_kg + dt_s * b + dt_s * dt_s * k;
        self.velocity_m_per_s = (self.velocity_m_per_s * self.mass_kg + pull_n * dt_s) / inertia_kg;
        self.position_m += self.velocity_m_per_s * dt_s;
    }

    /// Sets the stiffness of the grip, in N/m. The damping follows with the root of the stiffness,
    /// so that the damping ratio is constant.
    pub(super) fn grip(&mut self, stiffness_n_per_m: f64) {
        self.stiffness_n_per_m = stiffness_n_per_m;
        self.damping_n_s_per_m = self.damping_per_root * libm::sqrt(stiffness_n_per_m);
    }

    /// Stops at an obstacle that was penetrated by a depth along a unit vector, in m: removes the
    /// penetration and the velocity along it.
    pub(super) fn stop(&mut self, axis: &Vector3<f64>, depth_m: f64) {
        self.position_m -= axis * depth_m;
        self.velocity_m_per_s -= axis * self.velocity_m_per_s.dot(axis).max(0.0);
    }
}
