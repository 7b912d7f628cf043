//! The meshes of an image, as vertices and triangles for the GPU.

pub mod body;
pub mod guide;
pub mod hub;
pub mod lathe;
pub mod needle;
pub mod sheet;
pub mod solids;
pub mod tray;

use bytemuck::{Pod, Zeroable};
use glam::{Quat, Vec3};

/// A vertex, interpreted by its shader.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct Corner {
    /// Position, and a number of the part.
    pub at: [f32; 4],
    /// Normal, and another number.
    pub normal: [f32; 4],
}

impl Corner {
    /// A vertex of a part.
    #[must_use]
    pub fn new(at: Vec3, part: f32, normal: Vec3) -> Self {
        Self { at: at.extend(part).to_array(), normal: normal.extend(0.0).to_array() }
    }
}

/// Vertices and triangles.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct MeshShape {
    /// Vertices.
    pub corners: Vec<Corner>,
    /// Three vertex indices per triangle.
    pub indices: Vec<u32>,
}

impl MeshShape {
    /// Adds a vertex and returns its index.
    pub fn corner(&mut self, corner: Corner) -> u32 {
        self.corners.push(corner);
        self.corners.len() as u32 - 1
    }

    /// Adds a triangle.
    pub fn triangle(&mut self, corners: [u32; 3]) {
        self.indices.extend(corners);
    }

    /// Adds a quadrilateral, with vertices in order around it.
    pub fn quad(&mut self, [a, b, c, d]: [u32; 4]) {
        self.indices.extend([a, b, c, a, c, d]);
    }

    /// The shape rotated around the origin, then translated.
    #[must_use]
    pub fn placed(mut self, at: Vec3, turn: Quat) -> Self {
        for corner in &mut self.corners {
            let [x, y, z, part] = corner.at;
            corner.at = (at + turn * Vec3::new(x, y, z)).extend(part).to_array();
            let [x, y, z, other] = corner.normal;
            corner.normal = (turn * Vec3::new(x, y, z)).extend(other).to_array();
        }
        self
    }

    /// Adds another shape.
    pub fn add(&mut self, other: &Self) {
        let base = self.corners.len() as u32;
        self.corners.extend(&other.corners);
        self.indices.extend(other.indices.iter().map(|index| base + index));
    }

    /// Joins neighbouring rows of vertices, each of `columns`, starting at vertex `first`.
    pub fn join(&mut self, first: u32, columns: u32, rows: u32) {
        for row in 0..rows.saturating_sub(1) {
            for column in 0..columns.saturating_sub(1) {
                let a = first + row * columns + column;
                self.quad([a, a + 1, a + columns + 1, a + columns]);
            }
        }
    }
}
