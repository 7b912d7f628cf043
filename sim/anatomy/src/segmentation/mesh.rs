//! The mesh of a label.

use law::structures::Surface;
use nalgebra::Point3;

use super::contour::{Contour, contour};
use super::error::SegmentationError;
use super::grid::Filling;
use super::map::LabelMap;
use super::smooth::{smooth, volume_and_area};
use super::survey::LabelExtent;

/// Parameters of a mesh.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MeshRequest {
    /// Maximum displacement of a vertex by smoothing, in voxels along the image's axes; 0 keeps the
    /// voxel steps.
    pub smoothing_voxels: f64,
    /// Maximum number of triangles; voxels are merged until it is met.
    pub most_triangles: usize,
}

/// A closed mesh around the voxels of a label, with its deviation from them.
#[derive(Clone, Debug, PartialEq)]
pub struct LabelMesh {
    /// Vertices in the world (right, anterior, superior), in m, and triangles, counter-clockwise
    /// seen from outside.
    pub surface: Surface,
    /// Volume of the voxels, in m³.
    pub voxels_m3: f64,
    /// Volume of the mesh, in m³.
    pub mesh_m3: f64,
    /// Maximum displacement of a vertex by smoothing, in m.
    pub moved_m: f64,
    /// Number of voxels merged along each axis.
    pub voxels_together: usize,
    /// Number of connected components.
    pub pieces: usize,
}

/// Maximum number of voxels merged along each axis.
const MOST_TOGETHER: usize = 64;
/// Approximate number of triangles of a surface per face of a voxel in it.
const TRIANGLES_A_FACE: f64 = 2.0;

/// Makes a closed, manifold mesh around the voxels of a label, counter-clockwise seen from outside.
///
/// # Errors
/// If no voxel has the label, or nothing is left of it after merging voxels.
pub fn mesh_label(
    map: &LabelMap,
    label: u16,
    extent: &LabelExtent,
    request: MeshRequest,
) -> Result<LabelMesh, SegmentationError> {
    if extent.voxels == 0 {
        return Err(SegmentationError::Empty);
    }
    let faces = TRIANGLES_A_FACE * extent.faces as f64;
    let mut together = (libm::ceil(libm::sqrt(faces / request.most_triangles as f64)) as usize).max(1);
    loop {
        let filling = Filling::new(map, label, extent, together);
        let found = contour(&filling);
        if found.triangles.is_empty() {
            return Err(SegmentationError::Lost);
        }
        if found.triangles.len() <= request.most_triangles || together >= MOST_TOGETHER {
            return Ok(finish(map, &filling, found, request.smoothing_voxels));
        }
        together += 1;
    }
}

fn finish(map: &LabelMap, filling: &Filling, mut found: Contour, smoothing: f64) -> LabelMesh {
    let before = found.vertices.clone();
    let cells: f64 = filling.parts.iter().map(|part| f64::from(*part)).sum();
    smooth(&mut found, smoothing, cells);
    let place = |cells: &_| map.to_world_m(&filling.to_voxels(cells));
    let moved = before.iter().zip(&found.vertices).map(|(one, other)| (place(other) - place(one)).norm());
    let moved_m = moved.fold(0.0, f64::max);
    let cell_m3 = map.voxel_m3() * (filling.edge * filling.edge * filling.edge) as f64;
    let (volume, _) = volume_and_area(&found);
    let vertices_m: Vec<Point3<f64>> = found.vertices.iter().map(place).collect();
    let is_mirrored = map.placement.steps_m.determinant() < 0.0;
    let turned = |[a, b, c]: [u32; 3]| if is_mirrored { [a, c, b] } else { [a, b, c] };
    LabelMesh {
        pieces: count_pieces(vertices_m.len(), &found.triangles),
        surface: (vertices_m, found.triangles.into_iter().map(turned).collect()),
        voxels_m3: cells * cell_m3,
        mesh_m3: volume * cell_m3,
        moved_m,
        voxels_together: filling.edge,
    }
}

/// Number of connected components.
fn count_pieces(vertices: usize, triangles: &[[u32; 3]]) -> usize {
    let mut leaders: Vec<u32> = (0..vertices as u32).collect();
    let mut pieces = vertices;
    for &[a, b, c] in triangles {
        for (one, other) in [(a, b), (b, c)] {
            let [one, other] = [one, other].map(|vertex| lead(&mut leaders, vertex));
            if one != other {
                leaders[one as usize] = other;
                pieces -= 1;
            }
        }
    }
    pieces
}

fn lead(leaders: &mut [u32], mut vertex: u32) -> u32 {
    while leaders[vertex as usize] != vertex {
        leaders[vertex as usize] = leaders[leaders[vertex as usize] as usize];
        vertex = leaders[vertex as usize];
    }
    vertex
}
