//! How bone holds a needle's tip, from version 4 of the law.
//!
//! The tip rides on a place of the bone's surface, which slides along it without friction to where the tip pushes straight at it, and the bone
//! pushes the tip back towards that place. So the way out is never the far side, however thin a plate is or however hard one pushes
//! (Zilles and Salisbury 1995, the god-object), and an edge is rounded by what is far below what anybody feels (Ruspini, Kolarov and Khatib
//! 1997, the virtual proxy).

use nalgebra::{Point3, Vector3};
use serde::{Deserialize, Serialize};

use crate::structures::{BONE_N_PER_M, Structure};

/// Edges are as round as that, in m.
const ROUND_M: f64 = 2e-5;
/// The place slides so far in a step beyond what the tip itself moved, in m: 25 mN of bone, so that it lets go behind an edge without a blow.
const SLIDE_M: f64 = 1e-5;
/// A place slides in parts of this length, in m, and in so many parts a step at most: 0.8 mm, beyond what a hand moves in a millisecond.
const PART_M: f64 = 1e-4;
const PARTS: usize = 8;
/// So near its place along the surface, in m, a tip that is out is let go.
const LOOSE_M: f64 = 2e-6;
/// Farther from its place than this, in m, a tip was not pushed but put there, and nothing holds it.
const FARTHEST_M: f64 = 0.05;

/// The place of a bone's surface on which a tip rides.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Hold {
    /// The place, in the patient frame, in m.
    at_m: Point3<f64>,
    /// The way out there, of unit length.
    out: Vector3<f64>,
    /// Where the tip was, in m.
    tip_m: Point3<f64>,
}

impl Hold {
    /// The hold of a bone on a tip after it moved; none where it is outside.
    pub fn follow(before: Option<&Self>, bone: &Structure, tip_m: &Point3<f64>) -> Option<Self> {
        match before {
            Some(before) => before.slide(bone, tip_m),
            None => Self::begin(bone, tip_m),
        }
    }

    /// The nearest place, of a tip that has just come inside.
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

    /// How far the tip is out of the bone as its place has it, in m; negative inside.
    fn height_m(&self) -> f64 {
        (self.tip_m - self.at_m).dot(&self.out)
    }

    /// From its place to the tip along the surface, in m.
    fn along_m(&self) -> Vector3<f64> {
        self.tip_m - self.at_m - self.out * self.height_m()
    }

    /// Takes the place of the surface that is nearest to a point beside it, in m.
    fn place(&mut self, bone: &Structure, beside_m: &Point3<f64>) {
        let nearest = bone.nearest(beside_m);
        let away_m = if nearest.inside { nearest.at_m - beside_m } else { beside_m - nearest.at_m };
        self.at_m = nearest.at_m;
        self.out = away_m.try_normalize(0.0).unwrap_or(self.out);
    }

    /// Force of the bone on the tip, in N: towards its place, but never inwards.
    pub fn force_n(&self) -> Vector3<f64> {
        (self.out * (-self.height_m()).max(0.0) - self.along_m()) * BONE_N_PER_M
    }
}
