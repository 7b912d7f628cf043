//! Surfaces of revolution: a profile rotated around an axis.

use std::f32::consts::TAU;

use glam::Vec3;

use super::{Corner, MeshShape};

/// A point of a profile: distance from the axis and position along it, in m.
pub type Point = [f32; 2];

/// Rotates a profile around +z, with `sides` sides. Each segment has its own edges, so that rims
/// stay sharp; the profile runs from the hub's side to the tip's with the body on its inner side.
pub fn turn(shape: &mut MeshShape, profile: &[Point], part: f32, sides: u32) {
    for stretch in profile.windows(2) {
        let [[r0, z0], [r1, z1]] = [stretch[0], stretch[1]];
        let slope = Vec3::new(z1 - z0, 0.0, r0 - r1).normalize_or_zero();
        let first = shape.corners.len() as u32;
        for [r, z] in [[r0, z0], [r1, z1]] {
            for side in 0..=sides {
                let (sin, cos) = (TAU * side as f32 / sides as f32).sin_cos();
                let normal = Vec3::new(slope.x * cos, slope.x * sin, slope.z);
                shape.corner(Corner::new(Vec3::new(r * cos, r * sin, z), part, normal));
            }
        }
        shape.join(first, sides + 1, 2);
    }
}

/// Rotates a smooth profile: normals are interpolated between segments.
pub fn turn_smooth(shape: &mut MeshShape, profile: &[Point], part: f32, sides: u32) {
    let first = shape.corners.len() as u32;
    for (at, [r, z]) in profile.iter().enumerate() {
        let before = profile[at.saturating_sub(1)];
        let after = profile[(at + 1).min(profile.len() - 1)];
        let slope = Vec3::new(after[1] - before[1], 0.0, before[0] - after[0]).normalize_or_zero();
        for side in 0..=sides {
            let (sin, cos) = (TAU * side as f32 / sides as f32).sin_cos();
            let normal = Vec3::new(slope.x * cos, slope.x * sin, slope.z);
            shape.corner(Corner::new(Vec3::new(r * cos, r * sin, *z), part, normal));
        }
    }
    shape.join(first, sides + 1, profile.len() as u32);
}
