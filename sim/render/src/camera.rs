//! The camera of an image.

use glam::camera::rh;
use glam::{Mat4, Vec3};

use crate::frame::{Frame, Orbit, Stage, View};
use crate::placement::Placement;

/// Vertical angle of view, in rad.
const ANGLE_RAD: f32 = 0.49;
/// Height above the skin shown by the whole view, in m: space for the needle and the hand.
const ABOVE_M: f32 = 0.092;
/// Half the height shown by the view of the patient, in m: a back from the shoulder blades to the
/// hips, and the needle.
const PATIENT_M: f32 = 0.165;
/// Height above the skin shown by the section, in m.
const SECTION_ABOVE_M: f32 = 0.024;
/// Half the height shown by the close-up, in m, for a needle of 2 mm.
const CLOSE_M: f32 = 0.0105;
/// Maximum elevation of orbits, in rad.
const STEEPEST_RAD: f32 = 1.45;

/// Target of a view.
struct CameraAim {
    /// Middle of the image, in m.
    target: Vec3,
    /// Half the visible height there, in m.
    half_m: f32,
    /// The view's own rotation to the right and up, in rad.
    turn_rad: [f32; 2],
    /// Relevant radius around the target, in m.
    extent_m: f32,
}

/// A camera.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Camera {
    /// From the patient frame to clip space (depth 0 near, 1 far).
    pub clip_from_world: Mat4,
    /// Position, in m.
    pub eye: Vec3,
    /// Viewing direction, unit length.
    pub forward: Vec3,
    /// Whether the projection is perspective; orthographic otherwise.
    pub perspective: bool,
    /// Point that it looks at, in m.
    pub target: Vec3,
    /// Relevant radius around the target, in m: shadows are drawn there.
    pub extent_m: f32,
}

impl Camera {
    /// The camera of a frame; `aspect` is width divided by height.
    #[must_use]
    pub fn for_frame(stage: &Stage, frame: &Frame, place: &Placement, aspect: f32) -> Self {
        let aspect = aspect.clamp(0.1, 10.0);
        let depth_m = stage.depth_m();
        let aim = match frame.view {
            View::Whole => CameraAim {
                // A body that is not cut open is shown closer.
                target: place.point(0.0, if frame.closed { -0.03 } else { 0.012 }, 0.5 * (ABOVE_M - depth_m) - 0.019),
                half_m: if frame.closed { 0.62 } else { 0.53 } * (depth_m + ABOVE_M) * (1.6 / aspect).max(1.0),
                turn_rad: [-0.36, 0.40],
                extent_m: 0.17,
            },
            View::Patient => CameraAim {
                target: place.point(0.0, -0.01, -0.01),
                half_m: PATIENT_M * (1.6 / aspect).max(1.0),
                turn_rad: [-0.50, 0.78],
                extent_m: 0.42,
            },
            View::Tip => {
                let half_m = CLOSE_M * (stage.needle.diameter_m / 0.002).clamp(0.6, 2.0);
                let target = place.tip - place.axis * 0.25 * half_m;
                CameraAim { target, half_m, turn_rad: [-0.42, 0.20], extent_m: 0.045 }
            }
            View::Section => return Self::flat(place, depth_m, turned(frame.orbit, [0.0; 2]).distance, aspect),
        };
        Self::around(place, &aim, turned(frame.orbit, aim.turn_rad), aspect)
    }

    fn around(place: &Placement, aim: &CameraAim, orbit: Orbit, aspect: f32) -> Self {
        let CameraAim { target, half_m, extent_m, .. } = *aim;
        let away_m = half_m / (0.5 * ANGLE_RAD).tan() * orbit.distance;
        let (yaw, pitch) = (orbit.yaw_rad, orbit.pitch_rad.clamp(-STEEPEST_RAD, STEEPEST_RAD));
        let level = place.across * yaw.sin() - place.away * yaw.cos();
        let back = level * pitch.cos() + Vec3::Z * pitch.sin();
        let eye = target + back * away_m;
        let view = rh::view::look_at_mat4(eye, target, Vec3::Z);
        let projection = rh::proj::directx::perspective(ANGLE_RAD, aspect, 0.06 * away_m, away_m + 3.0);
        Self { clip_from_world: projection * view, eye, forward: -back, perspective: true, target, extent_m }
    }

    /// Perpendicular to the cut face, orthographic.
    fn flat(place: &Placement, depth_m: f32, distance: f32, aspect: f32) -> Self {
        let half_m = 0.5 * (depth_m + SECTION_ABOVE_M + 0.003) * distance;
        let middle = 0.5 * (depth_m + 0.003 - SECTION_ABOVE_M);
        let target = place.focus + place.down * middle;
        let eye = target + place.cut * 0.5;
        let view = rh::view::look_at_mat4(eye, target, Vec3::Z);
        let wide_m = half_m * aspect;
        let projection = rh::proj::directx::orthographic(-wide_m, wide_m, -half_m, half_m, 0.01, 1.0);
        let (clip_from_world, forward) = (projection * view, -place.cut);
        Self { clip_from_world, eye, forward, perspective: false, target, extent_m: 1.2 * wide_m }
    }

    /// Position of a point of the patient frame (m) in an image, in pixels from its upper left
    /// corner.
    #[must_use]
    pub fn pixel(&self, point: Vec3, size: [u32; 2]) -> [f32; 2] {
        let clip = self.clip_from_world.project_point3(point);
        [0.5 * (clip.x + 1.0) * size[0] as f32, 0.5 * (1.0 - clip.y) * size[1] as f32]
    }
}

/// The user's rotation, added to the view's own.
fn turned(orbit: Orbit, [yaw_rad, pitch_rad]: [f32; 2]) -> Orbit {
    let sound = |number: f32, otherwise: f32| if number.is_finite() { number } else { otherwise };
    Orbit {
        yaw_rad: sound(orbit.yaw_rad, 0.0) + yaw_rad,
        pitch_rad: sound(orbit.pitch_rad, 0.0) + pitch_rad,
        distance: sound(orbit.distance, 1.0).clamp(0.2, 4.0),
    }
}
