//! Extent of the visible punctures: beyond it the shaders skip them.

use glam::Vec3;

use crate::frame::{DrawnPuncture, Stage};
use crate::placement::Placement;

/// Maximum distance of the rim of a pool of blood from the needle's surface, and maximum length of
/// a trickle, in m.
const POOL_M: f32 = 0.008;
const TRICKLE_M: f32 = 0.036;
/// Extent of a track with its seepage, in radii of the needle: the limit of `track` in
/// `tissue.wgsl`.
const TRACK: f32 = 4.0;

/// Distance from the middle of the cut within which holes and blood lie on the skin, in m; 0
/// without punctures.
#[must_use]
pub fn on_skin(stage: &Stage, place: &Placement, punctures: &[DrawnPuncture]) -> f32 {
    let reach = |puncture: &DrawnPuncture| {
        let blood = puncture.blood.clamp(0.0, 1.0);
        beside(place, puncture) + 0.5 * stage.needle.diameter_m + POOL_M * blood + TRICKLE_M * blood * blood
    };
    punctures.iter().map(reach).fold(0.0, f32::max)
}

/// Distance from the middle of the cut, to both sides, within which tracks lie in the cut, in m; 0
/// without punctures.
#[must_use]
pub fn on_cut(stage: &Stage, place: &Placement, punctures: &[DrawnPuncture]) -> f32 {
    let reach = |puncture: &DrawnPuncture| {
        let axis = Vec3::from(puncture.axis);
        let steep = (-axis.z).max(0.1);
        // Deviation of the track from the direction in which the cut descends.
        let aslant = (axis / steep - place.down).length() * stage.depth_m();
        beside(place, puncture) + aslant + TRACK * 0.5 * stage.needle.diameter_m / steep
    };
    punctures.iter().map(reach).fold(0.0, f32::max)
}

fn beside(place: &Placement, puncture: &DrawnPuncture) -> f32 {
    (Vec3::from(puncture.entry_m) - place.focus).truncate().length()
}
