//! The block of the body: one grid for all boundaries and one strip of walls for all layers, which
//! the vertex shader positions. Vertices are dense around the needle.
//!
//! A vertex of the grid holds the end of its ray on the block's rim (m across and away), and its
//! position along the ray; a vertex of a wall also holds its outward normal, 1 at the layer's
//! bottom, and 1 to distinguish it from the grid.

use std::ops::Range;

use super::{Corner, MeshShape};
use crate::placement::{BEHIND_M, HALF_WIDTH_M};

/// Number of vertices along a ray, from the middle of the cut to the rim. A software renderer
/// processes blocks of 16 pixels once for each triangle that they touch, so this is the minimum
/// that the curvature needs.
const RINGS: u32 = 30;
/// Segments of the rim: right side, far side, left side.
const SIDE: u32 = 11;
const FAR: u32 = 22;

/// The block, and the index ranges of its parts.
pub struct BodyMesh {
    /// All vertices and triangles.
    pub shape: MeshShape,
    /// The grid of a boundary.
    pub grid: Range<u32>,
    /// The outer walls of a layer.
    pub outer: Range<u32>,
    /// The cut face of a layer.
    pub cut: Range<u32>,
}

impl BodyMesh {
    /// Index ranges of the grid within a distance from the middle of the cut (m), and of the rest.
    #[must_use]
    pub fn grid_within(&self, reach_m: f32) -> [Range<u32>; 2] {
        let end = self.grid.end * rings_within(reach_m) / RINGS;
        [0..end, end..self.grid.end]
    }

    /// Index ranges of the cut within a distance from its middle (m), and of the rest on both
    /// sides.
    #[must_use]
    pub fn cut_within(&self, reach_m: f32) -> [Range<u32>; 3] {
        let Range { start, end } = self.cut;
        let half = (end - start) / 2;
        let near = half * rings_within(reach_m) / RINGS;
        let (left, right) = (start + half - near, start + half + near);
        [left..right, start..left, right..end]
    }
}

/// Number of rings of the grid that cover a distance from the middle of the cut, in m.
fn rings_within(reach_m: f32) -> u32 {
    // Same as `placed` in `tissue.wgsl`, along the shortest ray.
    let distance_m = |ring: u32| {
        let along = ring as f32 / RINGS as f32;
        HALF_WIDTH_M * along * (0.02 + 0.98 * along * along)
    };
    (0..RINGS).find(|ring| distance_m(*ring) >= reach_m).unwrap_or(RINGS)
}

/// Builds the block.
#[must_use]
pub fn build_body() -> BodyMesh {
    let mut shape = MeshShape::default();
    let rim = add_rim();
    add_grid(&mut shape, &rim);
    let grid_end = shape.indices.len() as u32;
    add_outer_wall(&mut shape);
    let outer_end = shape.indices.len() as u32;
    add_section(&mut shape);
    let end = shape.indices.len() as u32;
    BodyMesh { shape, grid: 0..grid_end, outer: grid_end..outer_end, cut: outer_end..end }
}

fn outline_rows(from: [f32; 2], to: [f32; 2], steps: u32) -> impl Iterator<Item = [f32; 2]> {
    (0..=steps).map(move |i| {
        let t = i as f32 / steps as f32;
        [from[0] + t * (to[0] - from[0]), from[1] + t * (to[1] - from[1])]
    })
}

/// Corners of the block in plan view, from the right end of the cut around to its left end.
const CORNERS: [[f32; 2]; 4] =
    [[HALF_WIDTH_M, 0.0], [HALF_WIDTH_M, BEHIND_M], [-HALF_WIDTH_M, BEHIND_M], [-HALF_WIDTH_M, 0.0]];

fn add_rim() -> Vec<[f32; 2]> {
    let [a, b, c, d] = CORNERS;
    outline_rows(a, b, SIDE).chain(outline_rows(b, c, FAR).skip(1)).chain(outline_rows(c, d, SIDE).skip(1)).collect()
}

fn add_grid(shape: &mut MeshShape, rim: &[[f32; 2]]) {
    for ring in 0..=RINGS {
        let along = ring as f32 / RINGS as f32;
        for [x, y] in rim {
            shape.corner(Corner { at: [*x, *y, along, 0.0], normal: [0.0; 4] });
        }
    }
    shape.join(0, rim.len() as u32, RINGS + 1);
}

/// A wall: two rows of vertices, the layer's top and its bottom.
fn add_wall(shape: &mut MeshShape, plan: &[[f32; 3]], normal: [f32; 2]) {
    let first = shape.corners.len() as u32;
    for bottom in [0.0, 1.0] {
        for [x, y, along] in plan {
            shape.corner(Corner { at: [*x, *y, *along, 0.0], normal: [normal[0], normal[1], bottom, 1.0] });
        }
    }
    shape.join(first, plan.len() as u32, 2);
}

fn add_outer_wall(shape: &mut MeshShape) {
    let [a, b, c, d] = CORNERS;
    for (from, to, steps, normal) in [(a, b, SIDE, [1.0, 0.0]), (b, c, FAR, [0.0, 1.0]), (c, d, SIDE, [-1.0, 0.0])] {
        let plan: Vec<_> = outline_rows(from, to, steps).map(|[x, y]| [x, y, 1.0]).collect();
        add_wall(shape, &plan, normal);
    }
}

fn add_section(shape: &mut MeshShape) {
    let ray = |x: f32| (0..=RINGS).map(move |ring| [x, 0.0, ring as f32 / RINGS as f32]);
    let mut left: Vec<_> = ray(-HALF_WIDTH_M).collect();
    left.reverse();
    left.extend(ray(HALF_WIDTH_M).skip(1));
    add_wall(shape, &left, [0.0, -1.0]);
}
