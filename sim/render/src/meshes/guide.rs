//! The guide: the planned line in dashes, a cross at the entry, and rings around the target if it
//! is visible. Distinguished by shape, not only by colour.

use std::f32::consts::TAU;

use glam::{Quat, Vec3};

use super::lathe::turn;
use super::{Corner, MeshShape};
use crate::frame::Stage;

const LINE: f32 = 0.0;
const ENTRY: f32 = 1.0;
const TARGET: f32 = 2.0;
/// Start of the line above the skin, in m.
const ABOVE_M: f32 = 0.05;
/// Length of a dash and of the gap after it, in m.
const DASH_M: [f32; 2] = [0.0026, 0.0018];
const LINE_RADIUS_M: f32 = 2.2e-4;
const CROSS_M: f32 = 0.006;
const RING_RADIUS_M: f32 = 0.0028;
const RING_TUBE_M: f32 = 2.0e-4;

/// Builds the guide of a stage.
#[must_use]
pub fn build_guide(stage: &Stage) -> MeshShape {
    let (entry, target) = (Vec3::from(stage.entry_m), stage.target_m.map(Vec3::from));
    let axis = Vec3::from(stage.axis).normalize_or(Vec3::NEG_Z);
    let mut shape = MeshShape::default();
    let inside_m = target.map_or(0.0, |target| (target - entry).dot(axis).clamp(0.0, 0.5) - RING_RADIUS_M);
    let length_m = ABOVE_M + inside_m;
    let dashes = (length_m / (DASH_M[0] + DASH_M[1])) as u32;
    for dash in 0..dashes {
        let from = entry + axis * (dash as f32 * (DASH_M[0] + DASH_M[1]) - ABOVE_M);
        shape.add(&rod(from, axis * DASH_M[0], LINE_RADIUS_M, LINE));
    }
    cross(&mut shape, entry);
    for (target, normal) in
        target.into_iter().flat_map(|target| [(target, axis), (target, axis.any_orthonormal_vector())])
    {
        shape.add(&ring(target, normal, RING_RADIUS_M, TARGET));
    }
    shape
}

/// Two bars on the skin, open in the middle so that the puncture stays visible.
fn cross(shape: &mut MeshShape, entry: Vec3) {
    for direction in [Vec3::X, Vec3::NEG_X, Vec3::Y, Vec3::NEG_Y] {
        let from = entry + direction * (0.3 * CROSS_M) + Vec3::Z * 3e-4;
        shape.add(&rod(from, direction * (0.7 * CROSS_M), 1.6 * LINE_RADIUS_M, ENTRY));
    }
}

fn rod(from: Vec3, along: Vec3, radius_m: f32, part: f32) -> MeshShape {
    let mut shape = MeshShape::default();
    let length = along.length();
    turn(&mut shape, &[[0.0, 0.0], [radius_m, 0.0], [radius_m, length], [0.0, length]], part, 8);
    shape.placed(from, Quat::from_rotation_arc(Vec3::Z, along / length.max(f32::MIN_POSITIVE)))
}

fn ring(middle: Vec3, normal: Vec3, radius_m: f32, part: f32) -> MeshShape {
    const AROUND: u32 = 48;
    const TUBE: u32 = 6;
    let mut shape = MeshShape::default();
    for i in 0..=AROUND {
        let (sin, cos) = (TAU * i as f32 / AROUND as f32).sin_cos();
        let out = Vec3::new(cos, sin, 0.0);
        for k in 0..=TUBE {
            let (up, side) = (TAU * k as f32 / TUBE as f32).sin_cos();
            let normal = out * side + Vec3::Z * up;
            shape.corner(Corner::new(out * radius_m + normal * RING_TUBE_M, part, normal));
        }
    }
    shape.join(0, TUBE + 1, AROUND + 1);
    shape.placed(middle, Quat::from_rotation_arc(Vec3::Z, normal))
}
