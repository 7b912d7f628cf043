//! The skin's own shape, in addition to its curvature: a lower back, or the scene's mesh.

use glam::{Vec2, Vec3};

use crate::frame::{DrawnBend, Mesh, Stage};
use crate::placement::smooth;

/// Number of samples per side of the shape.
pub const SAMPLES: usize = 129;
/// Half the extent of the shape, in m.
pub const HALF_M: f32 = 0.16;
/// Distance from the entry up to which the skin coincides with that of the force law, in m.
const FLAT_M: f32 = 0.016;
/// Distance from which on it has its full shape, in m.
const SHAPED_M: f32 = 0.075;

/// Height above the skin of the force law around the planned entry (m) and its slope in x and y,
/// row by row in ascending y.
#[must_use]
pub fn shape(stage: &Stage) -> Vec<[f32; 4]> {
    let heights = heights(stage);
    let step = 2.0 * HALF_M / (SAMPLES - 1) as f32;
    let at = |x: usize, y: usize| heights[y.min(SAMPLES - 1) * SAMPLES + x.min(SAMPLES - 1)];
    let rise = |high: f32, low: f32| (high - low) / (2.0 * step);
    let texel = |x: usize, y: usize| {
        let slope_x = rise(at(x + 1, y), at(x.saturating_sub(1), y));
        [at(x, y), slope_x, rise(at(x, y + 1), at(x, y.saturating_sub(1))), 0.0]
    };
    (0..SAMPLES * SAMPLES).map(|i| texel(i % SAMPLES, i / SAMPLES)).collect()
}

/// Heights, in m.
fn heights(stage: &Stage) -> Vec<f32> {
    let entry = Vec2::new(stage.entry_m[0], stage.entry_m[1]);
    let place = |i: usize| 2.0 * HALF_M * (i as f32 / (SAMPLES - 1) as f32 - 0.5);
    let own = stage.skin.as_ref().map(|mesh| Raster::from_mesh(mesh, entry));
    let mut heights = Vec::with_capacity(SAMPLES * SAMPLES);
    for y in 0..SAMPLES {
        for x in 0..SAMPLES {
            let off = Vec2::new(place(x), place(y));
            let bent = stage.bend.height_m([entry.x + off.x, entry.y + off.y]);
            let made_up = || if stage.bend == DrawnBend::Flat { lower_back(off) } else { 0.0 };
            let height = own.as_ref().map_or_else(made_up, |raster| raster.heights[y * SAMPLES + x] - bent);
            heights.push(height * smooth((off.length() - FLAT_M) / (SHAPED_M - FLAT_M)));
        }
    }
    heights
}

/// A lower back: the furrow of the spine on the left, the long muscles next to it, the flank
/// descending to the right. Our choice.
fn lower_back(off: Vec2) -> f32 {
    let spine = off.x + 0.058;
    let furrow = -0.0085 * (-(spine / 0.017) * (spine / 0.017)).exp();
    let ridge = 0.0055 * (-((spine - 0.036) / 0.026) * ((spine - 0.036) / 0.026)).exp();
    let flank = -0.9 * (off.x - 0.01).max(0.0) * (off.x - 0.01).max(0.0);
    let waist = -0.45 * (off.y - 0.01) * (off.y - 0.01);
    furrow + ridge + flank + waist
}

/// Height map of a mesh: the highest surface at every sample.
struct Raster {
    heights: Vec<f32>,
}

impl Raster {
    fn from_mesh(mesh: &Mesh, entry: Vec2) -> Self {
        let mut raster = Self { heights: vec![f32::NEG_INFINITY; SAMPLES * SAMPLES] };
        for triangle in &mesh.triangles {
            let corners = triangle.map(|at| mesh.positions_m.get(at as usize).map(|p| Vec3::from(*p)));
            if let [Some(a), Some(b), Some(c)] = corners {
                raster.triangle([a, b, c], entry);
            }
        }
        for height in &mut raster.heights {
            // Outside the mesh the skin is flat.
            *height = if height.is_finite() { *height } else { 0.0 };
        }
        raster
    }

    fn triangle(&mut self, corners: [Vec3; 3], entry: Vec2) {
        let step = 2.0 * HALF_M / (SAMPLES - 1) as f32;
        let grid = corners.map(|p| (p.truncate() - entry + HALF_M) / step);
        let (low, high) = (grid[0].min(grid[1]).min(grid[2]), grid[0].max(grid[1]).max(grid[2]));
        let last = (SAMPLES - 1) as f32;
        let range = |low: f32, high: f32| low.ceil().clamp(0.0, last) as usize..=high.floor().clamp(0.0, last) as usize;
        let twice = (grid[1] - grid[0]).perp_dot(grid[2] - grid[0]);
        if twice == 0.0 || !twice.is_finite() {
            return;
        }
        for y in range(low.y, high.y) {
            for x in range(low.x, high.x) {
                let at = Vec2::new(x as f32, y as f32);
                let b = (at - grid[0]).perp_dot(grid[2] - grid[0]) / twice;
                let c = (grid[1] - grid[0]).perp_dot(at - grid[0]) / twice;
                let inside = b >= -1e-4 && c >= -1e-4 && b + c <= 1.0001;
                if inside {
                    let height = corners[0].z + b * (corners[1].z - corners[0].z) + c * (corners[2].z - corners[0].z);
                    let held = &mut self.heights[y * SAMPLES + x];
                    *held = held.max(height);
                }
            }
        }
    }
}
