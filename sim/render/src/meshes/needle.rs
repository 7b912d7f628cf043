//! The needle in its own frame: +z from hub to tip, tip at the origin. Stylet with its tip, cannula
//! with its bore, and the hub; the parts on the hub are in `hub.rs`.

use std::f32::consts::{PI, TAU};

use glam::Vec3;

use super::hub::{HubForm, reversed};
use super::lathe::{Point, turn, turn_smooth};
use super::{Corner, MeshShape};
use crate::frame::{DrawnNeedle, Tip};

const STEEL: f32 = 0.0;
const CANNULA: f32 = 1.0;
const BORE: f32 = 2.0;
const HUB: f32 = 3.0;
/// Number of sides of a shaft.
const SIDES: u32 = 24;
/// Number of segments of a shaft along its length, so that it can bend.
const STRETCHES: u32 = 24;
/// Radius of the stylet, as a fraction of the cannula's outer radius.
const STYLET: f32 = 0.80;

/// Builds the needle.
#[must_use]
pub fn build_needle(needle: &DrawnNeedle) -> MeshShape {
    let mut shape = MeshShape::default();
    let outer_m = 0.5 * needle.diameter_m;
    let form = HubForm::of(needle);
    let hub_m = form.begins_m;
    let cannulated = needle.tip_to_rim_m > 0.0;
    let inner_m = if cannulated { STYLET * outer_m } else { outer_m };
    let room_m = if cannulated { 0.95 * needle.tip_to_rim_m } else { f32::INFINITY };
    let end_m = if cannulated { -needle.tip_to_rim_m - 2.0 * outer_m } else { hub_m };
    add_tip(&mut shape, needle.tip, inner_m, room_m, end_m);
    if cannulated {
        add_cannula(&mut shape, outer_m, inner_m, -needle.tip_to_rim_m, hub_m);
    }
    add_hub(&mut shape, outer_m, &form);
    shape
}

/// The cannula: a shaft that narrows towards its rim, the rim, and the gap between rim and stylet.
fn add_cannula(shape: &mut MeshShape, outer_m: f32, inner_m: f32, rim_m: f32, hub_m: f32) {
    let bevel_m = 0.9 * outer_m;
    let bore_m = inner_m + 0.35 * (outer_m - inner_m);
    let rim_radius_m = inner_m + 0.62 * (outer_m - inner_m);
    add_shaft(shape, outer_m, CANNULA, [hub_m, rim_m - bevel_m]);
    turn(shape, &[[outer_m, rim_m - bevel_m], [rim_radius_m, rim_m], [bore_m, rim_m]], CANNULA, SIDES);
    turn(shape, &[[bore_m, rim_m], [bore_m, rim_m - outer_m]], BORE, SIDES);
    turn(shape, &[[bore_m, rim_m - outer_m], [inner_m, rim_m - outer_m]], BORE, SIDES);
}

fn add_shaft(shape: &mut MeshShape, radius_m: f32, part: f32, [from_m, to_m]: [f32; 2]) {
    let profile: Vec<Point> =
        (0..=STRETCHES).map(|i| [radius_m, from_m + (to_m - from_m) * i as f32 / STRETCHES as f32]).collect();
    turn_smooth(shape, &profile, part, SIDES);
}

/// The end of a shaft: the tip, and the shaft up to it.
fn add_tip(shape: &mut MeshShape, tip: Tip, radius_m: f32, room_m: f32, from_m: f32) {
    match tip {
        Tip::Diamond => add_diamond_tip(shape, radius_m, (2.1 * radius_m).min(room_m), from_m),
        Tip::Bevel => add_bevelled_tip(shape, radius_m, (4.2 * radius_m).min(room_m), from_m),
        Tip::Conical => {
            let long_m = (3.0 * radius_m).min(room_m);
            turn(shape, &[[radius_m, -long_m], [0.04 * radius_m, 0.0], [0.0, 0.0]], STEEL, SIDES);
            add_shaft(shape, radius_m, STEEL, [from_m, -long_m]);
        }
        Tip::Blunt => {
            let round = |i: u32| {
                let (sin, cos) = (0.5 * PI * i as f32 / 10.0).sin_cos();
                [radius_m * cos, radius_m * (sin - 1.0)]
            };
            turn_smooth(shape, &(0..=10).map(round).collect::<Vec<_>>(), STEEL, SIDES);
            add_shaft(shape, radius_m, STEEL, [from_m, -radius_m]);
        }
    }
}

/// Three flat facets that meet at the tip.
fn add_diamond_tip(shape: &mut MeshShape, radius_m: f32, long_m: f32, from_m: f32) {
    let per_facet = SIDES / 3;
    let depth = |angle: f32| -long_m * (angle - add_facet(angle)).cos();
    for face in 0..3 {
        let middle = TAU * face as f32 / 3.0;
        let normal = Vec3::new(middle.cos() * long_m, middle.sin() * long_m, radius_m).normalize();
        let apex = shape.corner(Corner::new(Vec3::ZERO, STEEL, normal));
        let edge: Vec<u32> = (0..=per_facet)
            .map(|i| {
                let off = TAU / 3.0 * (i as f32 / per_facet as f32 - 0.5);
                let (sin, cos) = (middle + off).sin_cos();
                let at = Vec3::new(radius_m * cos, radius_m * sin, -long_m * off.cos());
                shape.corner(Corner::new(at, STEEL, normal))
            })
            .collect();
        for pair in edge.windows(2) {
            shape.triangle([apex, pair[0], pair[1]]);
        }
    }
    shaft_to(shape, radius_m, from_m, depth);
}

/// The middle of the facet at an angle.
fn add_facet(angle: f32) -> f32 {
    TAU / 3.0 * (angle * 3.0 / TAU).round()
}

/// A bevel. Its point is bent onto the axis, like that of a Tuohy needle, so that it coincides with
/// the force law's tip.
fn add_bevelled_tip(shape: &mut MeshShape, radius_m: f32, long_m: f32, from_m: f32) {
    let depth = |angle: f32| -0.5 * long_m * (1.0 - angle.cos());
    let first = shape.corners.len() as u32;
    shaft_to(shape, radius_m, from_m, depth);
    let normal = Vec3::new(-long_m, 0.0, 2.0 * radius_m).normalize();
    let middle = shape.corner(Corner::new(Vec3::new(0.0, 0.0, -0.5 * long_m), STEEL, normal));
    let edge: Vec<u32> = (0..=SIDES)
        .map(|i| {
            let angle = TAU * i as f32 / SIDES as f32;
            let at = Vec3::new(radius_m * angle.cos(), radius_m * angle.sin(), depth(angle));
            shape.corner(Corner::new(at, STEEL, normal))
        })
        .collect();
    for pair in edge.windows(2) {
        shape.triangle([middle, pair[0], pair[1]]);
    }
    for corner in &mut shape.corners[first as usize..] {
        let share = (1.0 + corner.at[2] / long_m).clamp(0.0, 1.0);
        corner.at[0] -= radius_m * share * share;
    }
}

/// A shaft whose end follows a curve: `end` is the axial position at an angle.
fn shaft_to(shape: &mut MeshShape, radius_m: f32, from_m: f32, end: impl Fn(f32) -> f32) {
    let first = shape.corners.len() as u32;
    let rows = STRETCHES;
    for row in 0..=rows {
        for side in 0..=SIDES {
            let angle = TAU * side as f32 / SIDES as f32;
            let (sin, cos) = angle.sin_cos();
            let z = from_m + (end(angle) - from_m) * row as f32 / rows as f32;
            shape.corner(Corner::new(Vec3::new(radius_m * cos, radius_m * sin, z), STEEL, Vec3::new(cos, sin, 0.0)));
        }
    }
    shape.join(first, SIDES + 1, rows + 1);
}

/// Hub of the cannula with its flange, and the bore in its mouth.
fn add_hub(shape: &mut MeshShape, outer_m: f32, form: &HubForm) {
    let (wide_m, z) = (form.wide_m, |share: f32| form.at_share(share));
    let profile = [
        [outer_m, z(-0.10)],
        [0.42 * wide_m, z(0.0)],
        [0.55 * wide_m, z(0.12)],
        [0.58 * wide_m, z(0.34)],
        [wide_m, z(0.40)],
        [1.55 * wide_m, z(0.42)],
        [1.55 * wide_m, z(0.50)],
        [0.9 * wide_m, z(0.53)],
        [0.5 * wide_m, z(0.53)],
    ];
    turn(shape, &reversed(&profile), HUB, 40);
    turn(shape, &[[0.0, z(0.53)], [0.5 * wide_m, z(0.53)]], BORE, 40);
}
