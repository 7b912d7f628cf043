//! A frame's uniforms, in the layout of `scene.wgsl`.

use bytemuck::{Pod, Zeroable};
use glam::camera::rh;
use glam::{Mat4, Quat, Vec3, Vec4};

use crate::camera::Camera;
use crate::field::{self, DrawnResponses, MOST_LOADS, SAMPLES};
use crate::frame::{DrawnHub, DrawnPuncture, Frame, MOST_LAYERS, Mesh, Stage, View};
use crate::meshes::hub::{self, HubForm};
use crate::placement::{BEHIND_M, HALF_WIDTH_M, Placement, smooth, unit};
use crate::quality::Quality;
use crate::skin;

/// Maximum number of punctures: the latest ones.
pub const MOST_PUNCTURES: usize = 16;
/// Direction of the lamp from the focus: to the right, away and up.
const LAMP: Vec3 = Vec3::new(-0.50, -0.46, 0.74);
/// Maximum extent of the lamp's frustum to each side, in m.
const LAMP_REACH_M: f32 = 0.5;

#[repr(C)]
#[derive(Clone, Copy, Pod, Zeroable)]
struct Hole {
    entry: [f32; 3],
    depth: f32,
    axis: [f32; 3],
    blood: f32,
}

/// The uniform block.
#[repr(C)]
#[derive(Clone, Copy, Pod, Zeroable)]
pub struct SceneBlock {
    clip_from_world: Mat4,
    world_from_clip: Mat4,
    light_clip_from_world: Mat4,
    eye: Vec4,
    forward: Vec4,
    focus: Vec4,
    across: Vec4,
    away: Vec4,
    down: Vec4,
    cut: Vec4,
    axis: Vec4,
    needle_x: Vec4,
    needle_y: Vec4,
    needle_z: Vec4,
    tip: Vec4,
    bend: Vec4,
    ghost_x: Vec4,
    ghost_y: Vec4,
    ghost_z: Vec4,
    ghost: Vec4,
    lamp: Vec4,
    look: Vec4,
    place: Vec4,
    shade_tip: Vec4,
    shade_end: Vec4,
    hub: Vec4,
    rim: Vec4,
    curve: Vec4,
    count: [u32; 4],
    layers: [Vec4; MOST_LAYERS],
    punctures: [Hole; MOST_PUNCTURES],
    loads: [f32; MOST_LOADS],
    dents: [f32; MOST_LAYERS],
}

/// Inputs of a block.
pub struct ShaderMoment<'a> {
    /// The constant data of the attempt.
    pub stage: &'a Stage,
    /// The frame.
    pub frame: &'a Frame,
    /// The composition.
    pub place: &'a Placement,
    /// The camera.
    pub camera: &'a Camera,
    /// The field.
    pub responses: &'a DrawnResponses,
    /// The quality.
    pub quality: Quality,
}

impl SceneBlock {
    /// Makes the block of a frame.
    #[must_use]
    pub fn at_moment(moment: &ShaderMoment<'_>) -> Self {
        let ShaderMoment { stage, frame, place, camera, responses, quality } = *moment;
        let loads = field::pack_loads(responses, &frame.loads_n);
        let shadow_texels = quality.shadow_texels();
        let lamp = lamp(place);
        let ghost = frame
            .ghost
            .map_or((Vec3::ZERO, Quat::IDENTITY), |ghost| (Vec3::from(ghost.tip_m), unit(ghost.orientation)));
        let needle = |axis: Vec3| place.needle * axis;
        let section = f32::from(u8::from(frame.view == View::Section));
        let shadows = f32::from(u8::from(shadow_texels > 0 && section == 0.0));
        let light_clip_from_world = light(camera, lamp);
        let [tip, shade_end] = shade(&light_clip_from_world, stage, frame, place);
        let shade_tip = tip.truncate().extend(camera.extent_m);
        let punctures = latest(&frame.punctures);
        let depth_m = stage.depth_m();
        let touched = frame.touched.map_or(-1.0, |which| which as f32);
        // A section shows the inside without fading.
        let fades = frame.fade.is_finite() && frame.view != View::Section;
        let fade = if fades { frame.fade.clamp(0.0, 1.0) } else { 0.0 };
        Self {
            clip_from_world: camera.clip_from_world,
            world_from_clip: camera.clip_from_world.inverse(),
            light_clip_from_world,
            eye: camera.eye.extend(f32::from(u8::from(camera.perspective))),
            forward: camera.forward.extend(0.0),
            focus: place.focus.extend(0.5 * stage.needle.diameter_m),
            across: place.across.extend(HALF_WIDTH_M),
            away: place.away.extend(BEHIND_M),
            down: place.down.extend(depth_m),
            cut: place.cut.extend(section),
            axis: place.axis.extend(place.near),
            needle_x: needle(Vec3::X).extend(stage.needle.length_m),
            needle_y: needle(Vec3::Y).extend(stage.needle.tip_to_rim_m),
            needle_z: needle(Vec3::Z).extend(place.tip_depth_m()),
            tip: (place.tip - Vec3::from(frame.bend_m)).extend(shadows),
            bend: Vec3::from(frame.bend_m).extend(shadows * shadow_strength(frame.fade)),
            ghost_x: (ghost.1 * Vec3::X).extend(0.0),
            ghost_y: (ghost.1 * Vec3::Y).extend(0.0),
            ghost_z: (ghost.1 * Vec3::Z).extend(0.0),
            ghost: ghost.0.extend(0.0),
            lamp: lamp.extend(1.0 / shadow_texels.max(1) as f32),
            look: Vec4::new(
                fade,
                f32::from(u8::from(frame.closed && frame.view != View::Section)),
                responses.reach_m,
                skin::HALF_M,
            ),
            place: Vec4::new(stage.entry_m[0], stage.entry_m[1], touched, drape_m(stage, frame.view)),
            shade_tip,
            shade_end,
            hub: hub(frame),
            rim: rim(stage),
            curve: Vec4::from(stage.bend.packed()),
            count: [stage.layers.len() as u32, punctures.len() as u32, SAMPLES as u32, responses.loads as u32],
            layers: layers(stage, frame),
            punctures: holes(stage, punctures),
            dents: field::pack_dents(responses, &loads, &frame.dents_m),
            loads,
        }
    }
}

/// Direction towards the lamp, unit length.
#[must_use]
pub fn lamp(place: &Placement) -> Vec3 {
    (place.across * LAMP.x + place.away * LAMP.y + Vec3::Z * LAMP.z).normalize()
}

/// Height of the drape under the body, in m.
#[must_use]
pub fn drape_m(stage: &Stage, view: View) -> f32 {
    let lowest = |skin: &Mesh| skin.positions_m.iter().map(|at| at[2]).fold(-stage.depth_m(), f32::min);
    stage.patient(view).map_or(-stage.depth_m(), lowest) - 0.001
}

/// The lamp's view of the camera's target.
fn light(camera: &Camera, lamp: Vec3) -> Mat4 {
    let view = rh::view::look_at_mat4(camera.target + lamp * LAMP_REACH_M, camera.target, Vec3::Y);
    let wide = camera.extent_m;
    rh::proj::directx::orthographic(-wide, wide, -wide, wide, 0.0, 2.0 * LAMP_REACH_M) * view
}

/// Fade from which the light passes through the body.
const LET_THROUGH: f32 = 0.25;

/// Whether the body casts shadows.
#[must_use]
pub fn casts(fade: f32) -> bool {
    fade.is_nan() || fade < LET_THROUGH
}

/// Strength of the body's shadows: it decreases with the fade.
fn shadow_strength(fade: f32) -> f32 {
    if fade.is_finite() { 1.0 - smooth(fade / LET_THROUGH) } else { 1.0 }
}

/// The needle in the lamp's view: its tip, and the end of the part on its hub, with the fraction of
/// its length at which the hub begins.
fn shade(light_clip: &Mat4, stage: &Stage, frame: &Frame, place: &Placement) -> [Vec4; 2] {
    let [tip, end] = hub::needle_ends(stage, frame, place).map(|at| light_clip.project_point3(at));
    let form = HubForm::of(&stage.needle);
    let hub = form.begins_m / form.ends_m(stage.needle.hub, frame.hub.open);
    [tip.extend(0.0), end.extend(hub)]
}

/// State of the hub: blood, travel of the plunger, radius of the hanging drop, and distance that
/// another has fallen, in m.
fn hub(frame: &Frame) -> Vec4 {
    let DrawnHub { blood, plunger, drop, fallen_m, .. } = frame.hub;
    let share = |number: f32| if number.is_finite() { number.clamp(0.0, 1.0) } else { 0.0 };
    let fallen_m = if fallen_m.is_finite() { fallen_m.max(0.0) } else { 0.0 };
    Vec4::new(share(blood), share(plunger) * hub::TRAVEL_M, share(drop) * hub::DROP_M, fallen_m)
}

/// Positions of the hub's start and mouth along the needle, and of a hanging drop off the axis and
/// along it, in m.
fn rim(stage: &Stage) -> Vec4 {
    let form = HubForm::of(&stage.needle);
    let [aside_m, along_m] = form.rim_m();
    Vec4::new(form.begins_m, form.mouth_m(), aside_m, along_m)
}

/// The punctures that are drawn: the latest ones.
#[must_use]
pub fn latest(punctures: &[DrawnPuncture]) -> &[DrawnPuncture] {
    &punctures[punctures.len().saturating_sub(MOST_PUNCTURES)..]
}

/// Tracks end at the first closed boundary: tissue beyond it was only pushed.
fn holes(stage: &Stage, punctures: &[DrawnPuncture]) -> [Hole; MOST_PUNCTURES] {
    let mut holes = [Hole::zeroed(); MOST_PUNCTURES];
    for (hole, puncture) in holes.iter_mut().zip(punctures) {
        let DrawnPuncture { entry_m, axis, depth_m, opened, blood } = *puncture;
        let closed_m =
            stage.layers.get(opened as usize).map_or(f32::INFINITY, |layer| layer.top_m / (-axis[2]).max(0.1));
        *hole = Hole { entry: entry_m, depth: depth_m.min(closed_m), axis, blood: blood.clamp(0.0, 1.0) };
    }
    holes
}

fn layers(stage: &Stage, frame: &Frame) -> [Vec4; MOST_LAYERS] {
    let opened = open_puncture(frame).map_or(0, |open| open.opened as usize);
    let mut rows = [Vec4::ZERO; MOST_LAYERS];
    for (at, (row, layer)) in rows.iter_mut().zip(&stage.layers).enumerate() {
        let bottom = layer.top_m + layer.thickness_m;
        *row = Vec4::new(layer.top_m, bottom, layer.material as u32 as f32, f32::from(u8::from(at < opened)));
    }
    rows
}

/// The puncture that contains the needle: the latest one at the frame's entry.
#[must_use]
pub fn open_puncture(frame: &Frame) -> Option<&DrawnPuncture> {
    let entry = Vec3::from(frame.entry_m?);
    frame.punctures.iter().rev().find(|puncture| Vec3::from(puncture.entry_m).distance(entry) < 1e-4)
}
