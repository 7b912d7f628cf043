//! Corotational finite elements in 3-D, for problems without an axis of symmetry: an oblique
//! needle, a curved skin, inclusions.
//!
//! Hexahedra of order 2 to 4 on a disc around the needle, graded towards the load, with a plane of
//! nodes at every boundary; only the part that the symmetry of the problem requires is meshed.
//! Quadratic elements do not lock where linear ones do, and a graded mesh of them needs few
//! unknowns.
//!
//! [`Volumetric`] solves for small strains: the stiffness at rest is factorised once, and a solve
//! is one back-substitution. [`Corotational`] follows large rotations, in equilibrium or in time,
//! with that factor as its preconditioner.

mod along;
mod basis;
mod body;
mod corotational;
mod element;
mod fit;
mod kernel;
mod load;
mod locate;
mod mesh;
mod minimiser;
mod plan;
mod problem;
mod rotation;

pub(crate) use along::push_along_needle;
pub use body::Body;
pub use corotational::{Corotational, Energies, RefusedLoad, TissueMotion};
pub use fit::{FittedVolumetric, fit, fit_by, fit_rung};
pub use law::Skin;
use law::axial::ParamError;
use mesh::PatchMesh;
pub use mesh::{Grading, HexMesh, MeshSpec3, ORDERS};
pub use minimiser::{Effort, Outcome};
use nalgebra::{Point3, Vector3};
pub use problem::{Footprint, Inclusion, InclusionShape, Material, Problem3, Symmetry};

use super::multifrontal::{Cholesky, NotPositiveDefinite};
use super::{FieldModel, Model};

/// Why a problem cannot be modelled.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum VolumetricError {
    /// A number is out of range.
    #[error(transparent)]
    Param(#[from] ParamError),
    /// The order of the elements is not supported.
    #[error("mesh.order = {0}: must be from {1} to {2}")]
    Order(usize, usize, usize),
    /// The mesh folds over itself.
    #[error("element {element} is inverted at rest: the determinant of its map is {determinant} m³")]
    Inverted {
        /// Index of the element.
        element: usize,
        /// Determinant of its map, in m³.
        determinant: f64,
    },
    /// A part of the body is free to move.
    #[error(transparent)]
    Free(#[from] NotPositiveDefinite),
}

/// The tissue around a needle: a body, and the load of 1 N on it.
#[derive(Clone, Debug)]
pub struct Patch {
    problem: Problem3,
    symmetry: Symmetry,
    body: Body,
    /// Forces on the unknowns of a load of 1 N, in N.
    load: Vec<f64>,
}

impl Patch {
    /// Meshes the tissue of a problem.
    ///
    /// # Errors
    /// If a number of the problem or of the mesh is out of range.
    pub fn new(problem: &Problem3, spec: &MeshSpec3) -> Result<Self, VolumetricError> {
        let (patch, body) = mesh_body(problem, spec)?;
        let load = load::unit_load(problem, &patch, &body, spec.symmetry.share());
        Ok(Self { problem: problem.clone(), symmetry: spec.symmetry, body, load })
    }

    /// The body.
    #[must_use]
    pub fn body(&self) -> &Body {
        &self.body
    }

    /// Forces on the unknowns of a load of 1 N on the whole tissue, in N.
    #[must_use]
    pub fn load(&self) -> &[f64] {
        &self.load
    }

    /// Displacement, in m, of the point at `point` at rest; zero outside the patch.
    #[must_use]
    pub fn displacement_m(&self, u_m: &[f64], point: &Point3<f64>) -> Vector3<f64> {
        self.body.mirrored_m(self.symmetry, u_m, point)
    }

    /// Axial and radial displacement, in m, in the direction of `+x`, at a distance along the skin
    /// and a depth below it, in m.
    #[must_use]
    pub fn along_x_m(&self, u_m: &[f64], r_m: f64, depth_m: f64) -> [f64; 2] {
        let moved = self.displacement_m(u_m, &self.problem.skin.bend(&Point3::new(r_m, 0.0, -depth_m)));
        [moved.z, moved.x]
    }

    /// Memory of the patch, in bytes.
    #[must_use]
    pub fn bytes(&self) -> usize {
        self.body.bytes() + size_of_val(&self.load[..])
    }
}

/// Meshes the tissue of a problem, and makes a body of it.
fn mesh_body(problem: &Problem3, spec: &MeshSpec3) -> Result<(PatchMesh, Body), VolumetricError> {
    problem.check()?;
    let patch = spec.mesh(problem)?;
    let per_interval = patch.mesh.elements.len() / patch.mesh.nodes_each() / (patch.planes_m.len() - 1);
    let depth_m = |element: usize| {
        let interval = element / per_interval;
        0.5 * (patch.planes_m[interval] + patch.planes_m[interval + 1])
    };
    let material = |element: usize, point: &Point3<f64>| problem.material(depth_m(element), point);
    let base_m = patch.planes_m[patch.planes_m.len() - 1];
    let symmetry = spec.symmetry;
    let held = |node: usize| {
        let flat = &patch.flat_m[node];
        let side = libm::hypot(flat.x, flat.y) > patch.radius_m * (1.0 - 1e-9);
        let clamped = side || flat.z < -base_m * (1.0 - 1e-9);
        // The displacement normal to a plane of symmetry is zero.
        let x = symmetry == Symmetry::Quarter && flat.x.abs() < 1e-12;
        let y = symmetry != Symmetry::Full && flat.y.abs() < 1e-12;
        [clamped || x, clamped || y, clamped]
    };
    let body = Body::new(patch.mesh.clone(), material, held)?;
    Ok((patch, body))
}

/// The model for small strains: one back-substitution per load.
#[derive(Clone, Debug)]
pub struct Volumetric {
    patch: Patch,
    factor: Cholesky,
    u_m: Vec<f64>,
    scratch: Vec<f64>,
}

impl Volumetric {
    /// Meshes and factorises a problem.
    ///
    /// # Errors
    /// If a number of the problem or of the mesh is out of range.
    pub fn new(problem: &Problem3, spec: &MeshSpec3) -> Result<Self, VolumetricError> {
        let patch = Patch::new(problem, spec)?;
        let factor = patch.body.factorise(0.0)?;
        let (u_m, scratch) = (vec![0.0; patch.body.unknowns()], vec![0.0; factor.scratch_len()]);
        Ok(Self { patch, factor, u_m, scratch })
    }

    /// The tissue.
    #[must_use]
    pub fn patch(&self) -> &Patch {
        &self.patch
    }

    /// Number of nonzeros of the factor.
    #[must_use]
    pub fn nonzeros(&self) -> usize {
        self.factor.nonzeros()
    }

    /// The last solution, in m.
    #[must_use]
    pub fn unknowns_m(&self) -> &[f64] {
        &self.u_m
    }

    /// Displacement of the last solution, in m, of the point at `point` at rest, in the patient
    /// frame; zero outside the patch. Never allocates.
    #[must_use]
    pub fn displacement_at(&self, point: &Point3<f64>) -> Vector3<f64> {
        self.patch.displacement_m(&self.u_m, point)
    }
}

impl FieldModel for Volumetric {
    fn model(&self) -> Model {
        Model::Volumetric
    }

    fn unknowns(&self) -> usize {
        self.u_m.len()
    }

    fn bytes(&self) -> usize {
        self.patch.bytes() + self.factor.bytes() + 8 * (self.u_m.len() + self.scratch.len())
    }

    /// A force that cannot be solved for keeps the last solution.
    fn solve(&mut self, force_n: f64) {
        if !answerable(force_n) {
            return;
        }
        for (u, load) in self.u_m.iter_mut().zip(&self.patch.load) {
            *u = force_n * load;
        }
        self.factor.solve(&mut self.u_m, &mut self.scratch);
    }

    fn displacement_m(&self, r_m: f64, depth_m: f64) -> [f64; 2] {
        self.patch.along_x_m(&self.u_m, r_m, depth_m)
    }
}

/// Whether a force, in N, is a number whose products do not overflow.
fn answerable(force_n: f64) -> bool {
    force_n.abs() <= 1e9
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// The index of a node as stored in elements.
#[expect(clippy::expect_used, reason = "as many nodes would need 100 GB, and the planner refuses far smaller meshes")]
fn number_node(node: usize) -> u32 {
    u32::try_from(node).expect("a mesh has fewer than 2³² nodes")
}
