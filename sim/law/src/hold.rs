//! Contact of a needle's tip with bone, from version 4 of the law.
//!
//! The tip is coupled to a point of the bone's surface, which slides along it without friction to
//! where the tip pushes perpendicularly, and the bone pushes the tip back towards that point. So
//! the tip never exits on the far side, however thin a plate is or however hard the push (Zilles
//! and Salisbury 1995, the god-object), and an edge is rounded by an imperceptible radius (Ruspini,
//! Kolarov and Khatib 1997, the virtual proxy).

use nalgebra::{Point3, Vector3};
use serde::{Deserialize, Serialize};

use crate::structures::{BONE_N_PER_M, Structure};

/// Radius of rounded edges, in m.
const ROUND_M: f64 = 2e-5;
/// Maximum sliding of the point per step beyond the motion of the tip, in m: 25 mN of bone, so that
/// it releases behind an edge without a jolt.
const SLIDE_M: f64 = 1e-5;
/// Length of the sub-steps of a slide, in m, and their maximum number per step: 0.8 mm, more than a
/// hand moves in a millisecond.
const PART_M: f64 = 1e-4;
const PARTS: usize = 8;
/// Distance along the surface, in m, within which a tip outside the bone is released.
const LOOSE_M: f64 = 2e-6;
/// Distance between tip and point, in m, beyond which the tip was not pushed but repositioned, and
/// is not held.
const FARTHEST_M: f64 = 0.05;

/// The point of a bone's surface that holds a tip.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Hold {
    /// The point, in the patient frame, in m.
    at_m: Point3<f64>,
    /// Outward direction there, of unit length.
    out: Vector3<f64>,
    /// The last tip position, in m.
    tip_m: Point3<f64>,
}

impl Hold {
    /// The hold of a bone on a tip after a motion; `None` if the tip is outside.
    pub fn follow(before: Option<&Self>, bone: &Structure, tip_m: &Point3<f64>) -> Option<Self> {
        match before {
            Some(before) => before.slide(bone, tip_m),
            None => Self::begin(bone, tip_m),
        }
    }

    /// Begins at the point nearest to a tip that has just entered.
    fn begin(bone: &Structure, tip_m: &Point3<f64>) -> Option<Self> {
        let outward_m = bone.outward_m(tip_m);
        let out = outward_m.try_normalize(0.0)?;
        Some(Self { at_m: tip_m + outward_m, out, tip_m: *tip_m })
    }

    fn slide(&self, bone: &Structure, tip_m: &Point3<f64>) -> Option<Self> {
        let mut hold = Self { tip_m: *tip_m, ..*self };
        let mut left_m = SLIDE_M + (tip_m - self.tip_m).norm();
        for _ in 0..PARTS {
            let along_m = hold.along_m();
            let far_m = along_m.norm();
            let part_m = far_m.min(left_m).min(PART_M);
            if part_m <= 0.0 {
                break;
            }
            left_m -= part_m;
            hold.place(bone, &(hold.at_m + hold.out * ROUND_M + along_m * (part_m / far_m)));
        }
        let lets_go = hold.height_m() >= 0.0 && hold.along_m().norm() <= LOOSE_M;
        (!lets_go && (tip_m - hold.at_m).norm() <= FARTHEST_M).then_some(hold)
    }

    /// Height of the tip above the surface at its point, in m; negative inside.
    fn height_m(&self) -> f64 {
        (self.tip_m - self.at_m).dot(&self.out)
    }

    /// Displacement from the point to the tip along the surface, in m.
    fn along_m(&self) -> Vector3<f64> {
        self.tip_m - self.at_m - self.out * self.height_m()
    }

    /// Moves to the point of the surface nearest to a given point, in m.
    fn place(&mut self, bone: &Structure, beside_m: &Point3<f64>) {
        let nearest = bone.nearest(beside_m);
        let away_m = if nearest.inside { nearest.at_m - beside_m } else { beside_m - nearest.at_m };
        self.at_m = nearest.at_m;
        self.out = away_m.try_normalize(0.0).unwrap_or(self.out);
    }

    /// Force of the bone on the tip, in N: towards its point, but never inwards.
    pub fn force_n(&self) -> Vector3<f64> {
        (self.out * (-self.height_m()).max(0.0) - self.along_m()) * BONE_N_PER_M
    }
}
