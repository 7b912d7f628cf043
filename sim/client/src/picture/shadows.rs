//! The shadows on fifty bodies. The skin around the entry is drawn twice, as the patient's and as the
//! block's own, which gives way under the needle; the first is cut out where the second is drawn.
//! Fails if the shadow map contains the skin that was cut out: on bodies whose skin lies over the
//! block's, the block would get black blotches.

use anatomy::{AnatomyPart, Body, BodyOrder, BodyQuality, Level, Posture};
use image::RgbaImage;
use render::frame::{DrawnLayer, DrawnMaterial, Frame, Stage, View};
use render::{Headless, Quality};

use super::stage::drawn_mesh;

/// Bodies, each with a weight, an age and a posture of its own.
const BODIES: u64 = 50;
const SIZE: [u32; 2] = [192, 120];
/// Pixels per side of a patch.
const PATCH: u32 = 4;
/// Distance from the entry within which nothing but the needle casts a shadow on the skin, in m: the
/// block's own skin, with the cloth around it.
const NEAR_M: f32 = 0.05;
/// Least brightness of a patch with shadows, relative to the same one without.
const LEAST: f32 = 0.75;

/// The block of skin, fat and muscle, with the skin of a body around it.
fn stage_of_body(seed: u64) -> Stage {
    let posture = [Posture::Prone, Posture::Sitting, Posture::Side][seed as usize % 3];
    let (weight_kg, age_years) = (50.0 + 60.0 * (seed * 7 % 50) as f64 / 49.0, 20.0 + (seed * 13 % 50) as f64);
    let body = Body::new(&BodyOrder { posture, seed, weight_kg, age_years }).expect("a body of an adult");
    let levels = [Level::L2, Level::L3, Level::L4];
    let right_m = 0.03 * (seed % 3) as f64;
    let entry = body.enter(levels[seed as usize / 3 % 3], right_m, 0.0);
    let skin = body.mesh_from(&entry, AnatomyPart::Skin, BodyQuality::Low);
    let layers =
        [(DrawnMaterial::Skin, 0.0, 0.002), (DrawnMaterial::Fat, 0.002, 0.015), (DrawnMaterial::Muscle, 0.017, 0.04)];
    let layer =
        |(material, top_m, thickness_m)| DrawnLayer { name: format!("{material:?}"), material, top_m, thickness_m };
    Stage {
        layers: layers.map(layer).to_vec(),
        skin: Some(drawn_mesh(&skin.vertices_m, &skin.triangles)),
        ..Stage::default()
    }
}

/// Returns the brightness of each patch near the entry, from 0 to 1.
fn brightness_near_entry(picture: &RgbaImage, pixel: impl Fn([f32; 3]) -> [f32; 2]) -> Vec<f32> {
    let [x, y] = pixel([0.0; 3]);
    let radius = [[NEAR_M, 0.0, 0.0], [0.0, NEAR_M, 0.0]].map(pixel).map(|[a, b]| (a - x).hypot(b - y));
    let radius = radius[0].min(radius[1]);
    let (columns, rows) = (SIZE[0] / PATCH, SIZE[1] / PATCH);
    let patches = (0..columns * rows).map(|at| [at % columns * PATCH, at / columns * PATCH]);
    let near = patches.filter(|[left, top]| {
        let middle = [left, top].map(|side| *side as f32 + 0.5 * PATCH as f32);
        (middle[0] - x).hypot(middle[1] - y) < radius
    });
    near.map(|[left, top]| {
        let pixels = (0..PATCH * PATCH).map(|i| picture.get_pixel(left + i % PATCH, top + i / PATCH).0);
        let sum: f32 = pixels.map(|[r, g, b, _]| f32::from(r) + f32::from(g) + f32::from(b)).sum();
        sum / (3.0 * 255.0 * (PATCH * PATCH) as f32)
    })
    .collect()
}

#[test]
fn no_body_casts_a_shadow_on_the_skin_around_the_entry() {
    let mut painter = Headless::new(Quality::Medium).expect("an adapter: deploy/test installs a software one");
    let far_needle = Frame {
        view: View::Patient,
        closed: true,
        tip_m: [0.0, 0.0, 1.0],
        orientation: [1.0, 0.0, 0.0, 0.0],
        ..Frame::default()
    };
    let mut blotched = Vec::new();
    for seed in 0..BODIES {
        let stage = stage_of_body(seed);
        let [with, without] = [Quality::Medium, Quality::Least].map(|quality| {
            painter.set_quality(quality);
            let picture = painter.picture(&stage, &far_needle, SIZE).expect("a picture");
            let camera = painter.renderer().camera(&far_needle);
            brightness_near_entry(&picture, |place_m| camera.pixel(place_m.into(), SIZE))
        });
        assert!(with.len() > 20, "{} patches", with.len());
        let least = with.iter().zip(&without).map(|(with, without)| with / without).fold(f32::INFINITY, f32::min);
        if least < LEAST {
            blotched.push((seed, least));
        }
    }
    assert!(blotched.is_empty(), "{blotched:?}");
}
