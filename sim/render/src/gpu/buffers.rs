//! Meshes on the GPU.

use std::ops::Range;

use wgpu::util::{BufferInitDescriptor, DeviceExt};
use wgpu::{Buffer, BufferUsages, Device, IndexFormat, RenderPass};

use crate::meshes::MeshShape;

/// A mesh on the GPU.
pub struct Loaded {
    corners: Buffer,
    indices: Buffer,
    count: u32,
}

impl Loaded {
    /// Uploads a mesh.
    #[must_use]
    pub fn new(device: &Device, shape: &MeshShape) -> Self {
        let buffer = |contents: &[u8], usage| {
            // An empty buffer cannot be bound.
            let contents = if contents.is_empty() { &[0; 32] } else { contents };
            device.create_buffer_init(&BufferInitDescriptor { label: None, contents, usage })
        };
        Self {
            corners: buffer(bytemuck::cast_slice(&shape.corners), BufferUsages::VERTEX),
            indices: buffer(bytemuck::cast_slice(&shape.indices), BufferUsages::INDEX),
            count: shape.indices.len() as u32,
        }
    }

    /// Whether there is anything to draw.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.count == 0
    }

    /// The range of all indices.
    #[must_use]
    pub fn indices(&self) -> Range<u32> {
        0..self.count
    }

    /// Number of triangles.
    #[must_use]
    pub fn triangles(&self) -> u32 {
        self.count / 3
    }

    /// Draws the whole mesh.
    pub fn draw(&self, pass: &mut RenderPass<'_>) {
        self.draw_part(pass, 0..self.count, 0..1);
    }

    /// Draws a range of indices for a range of instances.
    pub fn draw_part(&self, pass: &mut RenderPass<'_>, indices: Range<u32>, instances: Range<u32>) {
        if !indices.is_empty() && !instances.is_empty() {
            pass.set_vertex_buffer(0, self.corners.slice(..));
            pass.set_index_buffer(self.indices.slice(..), IndexFormat::Uint32);
            pass.draw_indexed(indices, 0, instances);
        }
    }
}
