//! The part of the drape where shadows can fall: the rest is drawn without shadow lookups.

use std::ops::Range;

use glam::Vec3;

use crate::camera::Camera;
use crate::frame::{Frame, Stage};
use crate::meshes::hub::needle_ends;
use crate::placement::{BEHIND_M, HALF_WIDTH_M, Placement};
use crate::scene_block::{casts, drape_m, lamp};

/// Maximum distance, in m, by which shadow casters exceed the lines and corners considered: the
/// needle's hub, a hill of the skin.
const MARGIN_M: f32 = 0.02;

/// Rows of a grid of `rows` rows over the image, from its lower edge up, in which shadows can fall
/// on the drape.
#[must_use]
pub fn shaded_rows(stage: &Stage, frame: &Frame, place: &Placement, camera: &Camera, rows: u32) -> Range<u32> {
    // The shadow of a whole patient can fall anywhere.
    if stage.patient(frame.view).is_some() {
        return 0..rows;
    }
    let mut corners = needle_ends(stage, frame, place).to_vec();
    if casts(frame.fade) {
        corners.extend(block(stage, frame, place));
    }
    let level_m = drape_m(stage, frame.view);
    let fallen = corners.into_iter().flat_map(|corner| around(fallen(corner, level_m, place)));
    let heights = fallen.map(|at| height(camera, at));
    // A point behind the camera can project anywhere.
    let Some(heights) = heights.collect::<Option<Vec<f32>>>() else { return 0..rows };
    let low = heights.iter().copied().fold(f32::INFINITY, f32::min);
    let high = heights.iter().copied().fold(f32::NEG_INFINITY, f32::max);
    let row = |height: f32| (0.5 * (height + 1.0) * rows as f32).clamp(0.0, rows as f32);
    row(low).floor() as u32..row(high).ceil() as u32
}

/// The upper corners of the block, and its lower ones, where its own shadow begins.
fn block(stage: &Stage, frame: &Frame, place: &Placement) -> [Vec3; 8] {
    let near_m = if frame.closed { -BEHIND_M } else { 0.0 };
    [0, 1, 2, 3, 4, 5, 6, 7].map(|corner| {
        let right_m = if corner & 1 == 0 { -HALF_WIDTH_M } else { HALF_WIDTH_M };
        let away_m = if corner & 2 == 0 { near_m } else { BEHIND_M };
        let deep_m = if corner & 4 == 0 { 0.0 } else { stage.depth_m() };
        place.point(right_m, away_m, 0.0) + place.down * deep_m
    })
}

/// The point at which the shadow of a point falls on the drape, whose height is given in m.
fn fallen(point: Vec3, level_m: f32, place: &Placement) -> Vec3 {
    let lamp = lamp(place);
    let up_m = (point.z - level_m).max(0.0);
    point - lamp * (up_m / lamp.z)
}

fn around(point: Vec3) -> [Vec3; 4] {
    [[-1.0, -1.0], [1.0, -1.0], [-1.0, 1.0], [1.0, 1.0]].map(|[x, y]| point + 2.0 * MARGIN_M * Vec3::new(x, y, 0.0))
}

/// Height of a point in the image, -1 to 1; `None` behind the camera.
fn height(camera: &Camera, point: Vec3) -> Option<f32> {
    let clip = camera.clip_from_world * point.extend(1.0);
    (clip.w > 1e-3).then(|| clip.y / clip.w)
}
