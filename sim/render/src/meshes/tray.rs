//! The instruments next to the body: a steel tray with a syringe, a gauze pad and a bowl of
//! antiseptic. In the block's own frame: to the right of the cut's middle, away from the viewer, up
//! from the drape.

use std::f32::consts::FRAC_PI_2;

use glam::{Quat, Vec3};

use super::lathe::{Point, turn, turn_smooth};
use super::{Corner, MeshShape};
use crate::placement::{BEHIND_M, HALF_WIDTH_M};

const STEEL: f32 = 5.0;
const PLASTIC: f32 = 6.0;
const GAUZE: f32 = 7.0;
const ANTISEPTIC: f32 = 8.0;
/// Number of sides of round parts.
const SIDES: u32 = 28;
/// Half the tray's width and length, and the height of its rim, in m.
const HALF_M: [f32; 2] = [0.058, 0.042];
const RIM_M: f32 = 0.007;
/// The middle of the tray, in m: behind the block to its right.
pub const MIDDLE_M: [f32; 2] = [HALF_WIDTH_M + 0.042, BEHIND_M + 0.02];

/// Builds the tray with its instruments.
#[must_use]
pub fn build_tray() -> MeshShape {
    let mut shape = kidney_dish();
    let lying = Quat::from_rotation_y(FRAC_PI_2);
    shape.add(&syringe().placed(Vec3::new(-0.045, -0.024, 0.0085), Quat::from_rotation_z(0.12) * lying));
    shape.add(
        &tray_slab(Vec3::new(0.018, 0.014, 0.003), GAUZE).placed(Vec3::new(-0.028, 0.016, 0.0042), turned_part(-0.2)),
    );
    shape.add(
        &tray_slab(Vec3::new(0.017, 0.0135, 0.0015), GAUZE).placed(Vec3::new(-0.026, 0.017, 0.0087), turned_part(0.15)),
    );
    shape.add(&bowl().placed(Vec3::new(0.030, 0.014, 0.0012), Quat::IDENTITY));
    shape.placed(Vec3::new(MIDDLE_M[0], MIDDLE_M[1], 0.0), turned_part(-0.22))
}

fn turned_part(angle_rad: f32) -> Quat {
    Quat::from_rotation_z(angle_rad)
}

/// A steel plate with a rim.
fn kidney_dish() -> MeshShape {
    const THIN_M: f32 = 0.0006;
    let [wide, long] = HALF_M;
    let mut shape = tray_slab(Vec3::new(wide, long, THIN_M), STEEL).placed(Vec3::Z * THIN_M, Quat::IDENTITY);
    let up = Vec3::Z * 0.5 * RIM_M;
    for side in [-1.0, 1.0] {
        let across = tray_slab(Vec3::new(wide, THIN_M, 0.5 * RIM_M), STEEL);
        shape.add(&across.placed(up + Vec3::Y * side * long, Quat::IDENTITY));
        let along = tray_slab(Vec3::new(THIN_M, long, 0.5 * RIM_M), STEEL);
        shape.add(&along.placed(up + Vec3::X * side * wide, Quat::IDENTITY));
    }
    shape
}

/// A box around the origin.
fn tray_slab(half: Vec3, part: f32) -> MeshShape {
    let mut shape = MeshShape::default();
    for axis in 0..3 {
        for side in [-1.0, 1.0] {
            let pick = |k: usize| Vec3::AXES[(axis + k) % 3];
            let (normal, u) = (pick(0) * side, pick(1));
            let v = normal.cross(u);
            let corners = [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]]
                .map(|[a, b]| shape.corner(Corner::new(half * (normal + u * a + v * b), part, normal)));
            shape.quad(corners);
        }
    }
    shape
}

/// Along +z: plunger, barrel, nozzle.
fn syringe() -> MeshShape {
    let mut shape = MeshShape::default();
    let plunger: [Point; 6] =
        [[0.0, 0.0], [0.0068, 0.0], [0.0068, 0.0016], [0.0035, 0.0016], [0.0035, 0.024], [0.0, 0.024]];
    turn(&mut shape, &plunger, PLASTIC, SIDES);
    let barrel: [Point; 9] = [
        [0.0, 0.022],
        [0.0073, 0.022],
        [0.0073, 0.0238],
        [0.0066, 0.0238],
        [0.0066, 0.078],
        [0.0026, 0.0805],
        [0.0021, 0.0805],
        [0.0017, 0.090],
        [0.0, 0.090],
    ];
    turn(&mut shape, &barrel, PLASTIC, SIDES);
    shape
}

/// A filled steel bowl: outside, lip and inside, and the surface of its content.
fn bowl() -> MeshShape {
    const DEEP_M: f32 = 0.018;
    let mut shape = MeshShape::default();
    let wall = |radius_m: f32, i: u32| {
        let (sin, cos) = (FRAC_PI_2 * i as f32 / 8.0).sin_cos();
        [radius_m * (0.55 + 0.45 * sin), DEEP_M * (1.0 - cos)]
    };
    // Profiles have the body on their inner side: the outside runs upwards, the inside downwards.
    let outside: Vec<Point> = (0..=8).map(|i| wall(0.020, i)).collect();
    let inside: Vec<Point> = (0..=8).rev().map(|i| wall(0.019, i)).collect();
    turn_smooth(&mut shape, &outside, STEEL, SIDES);
    turn(&mut shape, &[outside[8], inside[0]], STEEL, SIDES);
    turn_smooth(&mut shape, &inside, STEEL, SIDES);
    turn(&mut shape, &[[0.0180, 0.62 * DEEP_M], [0.0, 0.62 * DEEP_M]], ANTISEPTIC, SIDES);
    shape
}
