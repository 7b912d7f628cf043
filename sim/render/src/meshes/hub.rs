//! The part on a needle's hub, in the needle's own frame: the stylet's knob, or a syringe; and the
//! drops from the hub.

use glam::Vec3;

use super::MeshShape;
use super::lathe::{Point, turn, turn_smooth};
use crate::frame::{DrawnNeedle, Frame, OnHub, Stage};
use crate::placement::Placement;

const KNOB: f32 = 4.0;
/// Part number of the plunger, which its shader moves.
const PLUNGER: f32 = 5.0;
const GLASS: f32 = 6.0;
const SIDES: u32 = 40;
/// Position of the hub's mouth, as a fraction of the hub's room; the knob takes the rest.
const MOUTH: f32 = 0.53;
/// Length of the hub with the stylet's knob, behind the shaft, in m.
const LENGTH_M: f32 = 0.030;
/// Radius of a syringe's barrel, and how long its nozzle, barrel and plunger are, in m.
const BARREL_M: f32 = 0.0072;
const NOZZLE_M: f32 = 0.008;
const LONG_M: f32 = 0.050;
const ROD_M: f32 = 0.026;
/// Travel of the plunger at loss of resistance, in m.
pub const TRAVEL_M: f32 = 0.018;
/// Radius of a falling drop, in m: about 0.05 ml.
pub const DROP_M: f32 = 0.0023;

/// Dimensions of the hub along a needle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HubForm {
    /// Start of the hub, in m from the tip, negative.
    pub begins_m: f32,
    /// Half its width, in m.
    pub wide_m: f32,
    /// Room for the hub and the stylet's knob, in m.
    long_m: f32,
}

/// Both ends of the straight needle, including the part on its hub, in m.
#[must_use]
pub fn needle_ends(stage: &Stage, frame: &Frame, place: &Placement) -> [Vec3; 2] {
    let end_m = HubForm::of(&stage.needle).ends_m(stage.needle.hub, frame.hub.open);
    [place.tip, place.tip + place.needle * Vec3::Z * end_m]
}

impl HubForm {
    /// The hub of a needle.
    #[must_use]
    pub fn of(needle: &DrawnNeedle) -> Self {
        let outer_m = 0.5 * needle.diameter_m;
        Self { begins_m: -needle.length_m, wide_m: 0.0046_f32.max(2.2 * outer_m), long_m: LENGTH_M }
    }

    /// Position along the needle at a fraction of the room, in m from the tip.
    #[must_use]
    pub fn at_share(&self, share: f32) -> f32 {
        self.begins_m - share * self.long_m
    }

    /// Position of the hub's mouth, in m from the tip.
    #[must_use]
    pub fn mouth_m(&self) -> f32 {
        self.at_share(MOUTH)
    }

    /// Position of a hanging drop: distance from the axis, and position along it, in m.
    #[must_use]
    pub fn rim_m(&self) -> [f32; 2] {
        [1.5 * self.wide_m, self.at_share(0.42)]
    }

    /// End of the needle including the part on its hub, in m from the tip.
    #[must_use]
    pub fn ends_m(&self, on: OnHub, open: bool) -> f32 {
        match (open, on) {
            (true, _) => self.mouth_m(),
            (false, OnHub::Stylet) => self.at_share(1.0),
            (false, OnHub::Syringe) => self.mouth_m() - NOZZLE_M - LONG_M,
        }
    }
}

/// Builds the part on the hub: its opaque and its transparent shape.
#[must_use]
pub fn build_on_hub(needle: &DrawnNeedle) -> [MeshShape; 2] {
    let form = HubForm::of(needle);
    match needle.hub {
        OnHub::Stylet => [build_knob(&form), MeshShape::default()],
        OnHub::Syringe => [build_plunger(form.mouth_m()), build_barrel(form.mouth_m())],
    }
}

fn build_knob(form: &HubForm) -> MeshShape {
    let (wide_m, z) = (form.wide_m, |share: f32| form.at_share(share));
    let knob = [
        [0.62 * wide_m, z(MOUTH)],
        [0.66 * wide_m, z(0.60)],
        [0.98 * wide_m, z(0.66)],
        [1.10 * wide_m, z(0.74)],
        [1.10 * wide_m, z(0.84)],
        [0.98 * wide_m, z(0.93)],
        [0.70 * wide_m, z(0.985)],
        [0.30 * wide_m, z(1.0)],
        [0.0, z(1.0)],
    ];
    let mut shape = MeshShape::default();
    turn_smooth(&mut shape, &reversed(&knob), KNOB, SIDES);
    shape
}

/// A glass syringe on a mouth: a nozzle, and the barrel with its rim.
fn build_barrel(mouth_m: f32) -> MeshShape {
    let z = |back_m: f32| mouth_m - back_m;
    let end_m = NOZZLE_M + LONG_M;
    let profile = [
        [0.0024, z(-0.004)],
        [0.0028, z(0.6 * NOZZLE_M)],
        [BARREL_M, z(NOZZLE_M)],
        [BARREL_M, z(end_m - 0.002)],
        [1.7 * BARREL_M, z(end_m - 0.002)],
        [1.7 * BARREL_M, z(end_m)],
        [0.8 * BARREL_M, z(end_m)],
    ];
    let mut shape = MeshShape::default();
    turn(&mut shape, &reversed(&profile), GLASS, SIDES);
    shape
}

/// The plunger in the hand's position: its head in the barrel, its rod and the thumb rest behind
/// it.
fn build_plunger(mouth_m: f32) -> MeshShape {
    let z = |back_m: f32| mouth_m - back_m;
    let (head_m, end_m) = (NOZZLE_M + TRAVEL_M + 0.002, NOZZLE_M + LONG_M + ROD_M);
    let profile = [
        [0.0, z(head_m)],
        [0.93 * BARREL_M, z(head_m)],
        [0.93 * BARREL_M, z(head_m + 0.007)],
        [0.55 * BARREL_M, z(head_m + 0.008)],
        [0.55 * BARREL_M, z(end_m - 0.003)],
        [1.35 * BARREL_M, z(end_m - 0.0025)],
        [1.35 * BARREL_M, z(end_m)],
        [0.0, z(end_m)],
    ];
    let mut shape = MeshShape::default();
    turn(&mut shape, &reversed(&profile), PLUNGER, SIDES);
    shape
}

/// Builds a drop of radius 1 around the origin.
#[must_use]
pub fn build_drop() -> MeshShape {
    let around = |i: u32| {
        let (sin, cos) = (std::f32::consts::PI * i as f32 / 12.0).sin_cos();
        [sin, -cos]
    };
    let mut shape = MeshShape::default();
    turn_smooth(&mut shape, &(0..=12).map(around).collect::<Vec<Point>>(), GLASS, 24);
    shape
}

/// Reverses a profile, from the hub's end towards the tip, as [`turn`] expects it.
#[must_use]
pub fn reversed(profile: &[Point]) -> Vec<Point> {
    profile.iter().rev().copied().collect()
}
