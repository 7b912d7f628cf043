//! Pushes at several depths of one needle, on one mesh.

use nalgebra::{Point3, Vector3};

use super::load::unit_load;
use super::{MeshSpec3, Problem3, VolumetricError, mesh_body};
use crate::{Load, LoadKind};

/// Solutions for 1 N at each of several depths of a needle.
#[derive(Clone, Debug)]
pub(crate) struct NeedlePushes {
    /// Displacement along the needle at each point under a push at each depth, in m/N, ordered by
    /// push.
    pub answers_m: Vec<Vec<f64>>,
    /// Number of elements of the mesh.
    pub elements: usize,
    /// Number of unknowns.
    pub unknowns: usize,
    /// Memory held at a time, in bytes.
    pub bytes: usize,
}

/// Solves pushes along the needle of a problem at several depths below the skin, in m, and samples
/// them at points of it, also given by depth, in m. The mesh is made for the problem's own load, of
/// which only the radius is used otherwise.
///
/// # Errors
/// The first number of the problem or the mesh that is out of range.
pub(crate) fn push_along_needle(
    problem: &Problem3,
    spec: &MeshSpec3,
    pushes_m: &[f64],
    points_m: &[f64],
) -> Result<NeedlePushes, VolumetricError> {
    let (patch, body) = mesh_body(problem, spec)?;
    let factor = body.factorise(0.0)?;
    let mut scratch = vec![0.0; factor.scratch_len()];
    let points: Vec<Point3<f64>> = points_m.iter().map(|depth_m| problem.on_needle(*depth_m)).collect();
    let inwards = Vector3::new(libm::sin(problem.tilt_rad), 0.0, -libm::cos(problem.tilt_rad));
    let mut answer = |depth_m: &f64| {
        let mut pushed = problem.clone();
        pushed.flat.load = Load { kind: LoadKind::Contactor { depth_m: *depth_m }, ..problem.flat.load };
        let mut u_m = unit_load(&pushed, &patch, &body, spec.symmetry.share());
        factor.solve(&mut u_m, &mut scratch);
        points.iter().map(|point| body.mirrored_m(spec.symmetry, &u_m, point).dot(&inwards)).collect()
    };
    Ok(NeedlePushes {
        answers_m: pushes_m.iter().map(&mut answer).collect(),
        elements: body.elements(),
        unknowns: body.unknowns(),
        bytes: body.bytes() + factor.bytes(),
    })
}
