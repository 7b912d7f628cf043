//! Positions of the cut and the needle: the frame in which an image is composed.

use glam::{Quat, Vec3};

use crate::frame::{Frame, Stage};

/// Half the width of the block, in m.
pub const HALF_WIDTH_M: f32 = 0.088;
/// Extent of the block behind the cut, in m.
pub const BEHIND_M: f32 = 0.095;
/// Distance of the tip from the skin at which the cut begins to follow the needle, in m.
const NEAR_M: f32 = 0.012;
/// Maximum distance from the planned entry to which the cut follows the needle, in m.
const FOLLOWS_M: f32 = 0.03;
/// A needle flatter than this (cosine to the vertical) no longer tilts the cut.
const FLATTEST: f32 = 0.4;

/// The composition of a frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Placement {
    /// Middle of the cut on the skin, in m: the intersection with the needle's line, or the planned
    /// entry while the needle is away.
    pub focus: Vec3,
    /// Horizontal, along the cut to the right.
    pub across: Vec3,
    /// Horizontal, into the block.
    pub away: Vec3,
    /// Along the cut face, per metre of depth.
    pub down: Vec3,
    /// Outward normal of the cut face.
    pub cut: Vec3,
    /// The needle's axis used for the tissue.
    pub axis: Vec3,
    /// Orientation of the needle.
    pub needle: Quat,
    /// The drawn tip, including its bend, in m.
    pub tip: Vec3,
    /// Proximity of the needle: 1 in the tissue, 0 away.
    pub near: f32,
}

impl Placement {
    /// Composes a frame. The cut contains the needle's axis, so that needle and tents lie in the
    /// cut face.
    #[must_use]
    pub fn for_frame(stage: &Stage, frame: &Frame) -> Self {
        let planned = down_or(Vec3::from(stage.axis));
        let across = cut_direction(planned);
        let away = Vec3::Z.cross(across);
        let needle = unit(frame.orientation);
        let tip = finite(Vec3::from(frame.tip_m)) + finite(Vec3::from(frame.bend_m));
        let above_m = tip.z - stage.bend.height_m([tip.x, tip.y]);
        let near = if frame.entry_m.is_some() { 1.0 } else { smooth(1.0 - above_m / NEAR_M) };
        let planned_entry = Vec3::from(stage.entry_m);
        let axis = planned.lerp(down_or(needle * Vec3::Z), near).normalize();
        // The intersection of the needle's line with the skin, which a hand may have displaced
        // since the entry.
        let wanted = if frame.entry_m.is_some() { meet_skin(stage, tip, axis) } else { tip };
        let off = ((wanted - planned_entry) * near * Vec3::new(1.0, 1.0, 0.0)).clamp_length_max(FOLLOWS_M);
        let down = (axis - across * axis.dot(across)) / -axis.z;
        let cut = -across.cross(down).normalize();
        let plan = planned_entry * Vec3::new(1.0, 1.0, 0.0) + off;
        let focus = plan + Vec3::Z * stage.bend.height_m([plan.x, plan.y]);
        Self { focus, across, away, down, cut, axis, needle, tip, near }
    }

    /// Depth of the tip along the axis below the skin, in m; negative in the air.
    #[must_use]
    pub fn tip_depth_m(&self) -> f32 {
        (self.tip - self.focus).dot(self.axis)
    }

    /// A point of the block: to the right, away and up from the focus, in m.
    #[must_use]
    pub fn point(&self, right: f32, away: f32, up: f32) -> Vec3 {
        self.focus + self.across * right + self.away * away + Vec3::Z * up
    }
}

/// The intersection of a needle's line with the skin.
fn meet_skin(stage: &Stage, tip: Vec3, axis: Vec3) -> Vec3 {
    let at_level = |level_m: f32| tip + axis * ((level_m - tip.z) / axis.z);
    let nearer = |place: Vec3, _| at_level(stage.bend.height_m([place.x, place.y]));
    (0..MEETINGS).fold(at_level(0.0), nearer)
}

/// Number of fixed-point iterations with the skin's height: they converge because the needle is
/// steeper than the skin.
const MEETINGS: usize = 4;

/// Converts to a rotation; the identity if the numbers are invalid.
#[must_use]
pub fn unit(orientation: [f32; 4]) -> Quat {
    let turn = Quat::from_array(orientation);
    if turn.is_finite() && turn.length() > 0.5 { turn.normalize() } else { Quat::IDENTITY }
}

/// Smoothstep from 0 to 1.
#[must_use]
pub fn smooth(t: f32) -> f32 {
    let t = t.clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}

fn finite(v: Vec3) -> Vec3 {
    if v.is_finite() { v } else { Vec3::ZERO }
}

/// Returns the axis if it descends steeply enough to cut along, otherwise straight down.
fn down_or(axis: Vec3) -> Vec3 {
    match axis.try_normalize() {
        Some(axis) if axis.z < -FLATTEST => axis,
        _ => Vec3::NEG_Z,
    }
}

/// The cut is along an oblique plan, and from left to right for a steep one.
fn cut_direction(planned: Vec3) -> Vec3 {
    let level = Vec3::new(planned.x, planned.y, 0.0);
    match level.length() > 0.05 {
        true if level.x < -1e-3 => -level.normalize(),
        true => level.normalize(),
        false => Vec3::X,
    }
}
