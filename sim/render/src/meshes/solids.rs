//! Structures inside the body, with normals: edges sharper than a crease stay sharp.

use glam::Vec3;

use super::{Corner, MeshShape};
use crate::frame::{DrawnStructure, DrawnStructureKind, Mesh};

/// Cosine of the maximum angle between faces of a smooth surface: for a structure, and for skin,
/// which has no edges.
const CREASE: f32 = 0.7;
const NO_CREASE: f32 = -1.0;

/// All structures in one shape: the part is the kind, the other number the index of the structure.
#[must_use]
pub fn build_solids(structures: &[DrawnStructure]) -> MeshShape {
    let mut shape = MeshShape::default();
    for (which, structure) in structures.iter().enumerate() {
        let mut solid = smoothed(&structure.mesh, part(structure.kind), CREASE);
        solid.corners.iter_mut().for_each(|corner| corner.normal[3] = which as f32);
        shape.add(&solid);
    }
    shape
}

/// The skin of a whole patient.
#[must_use]
pub fn build_patient(skin: Option<&Mesh>) -> MeshShape {
    skin.map_or_else(MeshShape::default, |mesh| smoothed(mesh, 0.0, NO_CREASE))
}

fn part(kind: DrawnStructureKind) -> f32 {
    match kind {
        DrawnStructureKind::Target => 0.0,
        DrawnStructureKind::Vessel => 1.0,
        DrawnStructureKind::Nerve => 2.0,
        DrawnStructureKind::Bone => 3.0,
        DrawnStructureKind::Organ => 4.0,
    }
}

fn smoothed(mesh: &Mesh, part: f32, crease: f32) -> MeshShape {
    let place = |index: u32| mesh.positions_m.get(index as usize).map(|at| Vec3::from(*at));
    let faces: Vec<([u32; 3], [Vec3; 3], Vec3)> = mesh
        .triangles
        .iter()
        .filter_map(|&[a, b, c]| {
            let corners = [place(a)?, place(b)?, place(c)?];
            let area = (corners[1] - corners[0]).cross(corners[2] - corners[0]);
            Some(([a, b, c], corners, area))
        })
        .collect();
    let mut around = vec![Vec::new(); mesh.positions_m.len()];
    for (indices, _, area) in &faces {
        indices.iter().for_each(|&index| around[index as usize].push(*area));
    }
    let mut shape = MeshShape::default();
    for (indices, corners, area) in &faces {
        let flat = area.normalize_or_zero();
        let placed = [0, 1, 2].map(|k| {
            let smooth: Vec3 =
                around[indices[k] as usize].iter().filter(|a| a.normalize_or_zero().dot(flat) >= crease).sum();
            shape.corner(Corner::new(corners[k], part, smooth.normalize_or(flat)))
        });
        shape.triangle(placed);
    }
    shape
}
