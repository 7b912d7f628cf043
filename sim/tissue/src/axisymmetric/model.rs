//! The model of one load: a mesh, its factor and its last solution.

use super::assembly::ElementGrid;
use super::element::stiffness;
use super::load::{across, along};
use super::mesh::Spans;
use super::{AxisymmetricError, MeshSpec, Side};
use crate::multifrontal::Cholesky;
use crate::{FieldModel, Load, Model, Problem};

/// A load on layers, meshed and factorised; initially solved for 1 N.
#[derive(Clone, Debug)]
pub struct Axisymmetric {
    grid: ElementGrid<2>,
    factor: Cholesky,
    /// Forces of 1 N on the unknowns, in N per radian.
    load: Vec<f64>,
    /// The last solution, in m.
    solution: Vec<f64>,
    scratch: Vec<f64>,
    /// Force per displacement of the tissue at the load, in N/m.
    stiffness_n_per_m: f64,
}

impl Axisymmetric {
    /// Meshes and factorises a problem.
    ///
    /// # Errors
    /// The first number out of range, a mesh that does not fit the layers, or contrasts beyond
    /// double precision.
    pub fn new(problem: &Problem, mesh: &MeshSpec) -> Result<Self, AxisymmetricError> {
        Self::with_side(problem, mesh, Side::Clamped)
    }

    /// Makes the model with a boundary condition at the side.
    ///
    /// # Errors
    /// Those of [`Self::new`].
    pub fn with_side(problem: &Problem, mesh: &MeshSpec, side: Side) -> Result<Self, AxisymmetricError> {
        problem.check()?;
        mesh.check(problem)?;
        let grid = ElementGrid::straight(Spans::new(&mesh.radial), Spans::new(&mesh.axial), side);
        let factor = grid.factorise(&problem.slab.solid(), stiffness)?;
        let scratch = vec![0.0; factor.scratch_len()];
        let solution = vec![0.0; grid.unknowns];
        let mut model = Self { grid, factor, load: Vec::new(), solution, scratch, stiffness_n_per_m: 0.0 };
        model.take(&problem.load);
        Ok(model)
    }

    /// Replaces the load by another, of 1 N, and keeps the factor. The mesh must have a line at
    /// each end of the load.
    pub(super) fn take(&mut self, load: &Load) {
        self.load = self.grid.load(1, &across(load.radius_m, &self.grid.radial), &along(load, &self.grid.axial));
        self.solve(1.0);
        let [from_m, to_m] = load.ends_m();
        self.stiffness_n_per_m = 1.0 / self.displacement_m(0.0, 0.5 * (from_m + to_m))[0].abs();
    }

    /// The field's own stiffness: force divided by the axial displacement on the axis at the load,
    /// in the middle of a drag, in N/m. Infinite on the clamped base.
    #[must_use]
    pub fn stiffness_n_per_m(&self) -> f64 {
        self.stiffness_n_per_m
    }

    /// Number of nonzeros of the factor: a solve reads each twice.
    #[must_use]
    pub fn nonzeros(&self) -> usize {
        self.factor.nonzeros()
    }
}

impl FieldModel for Axisymmetric {
    fn model(&self) -> Model {
        Model::Axisymmetric
    }

    fn unknowns(&self) -> usize {
        self.load.len()
    }

    fn bytes(&self) -> usize {
        let numbers = self.load.len() + self.solution.len() + self.scratch.len();
        self.factor.bytes() + self.grid.bytes() + numbers * size_of::<f64>()
    }

    /// A force that is not finite keeps the last solution.
    fn solve(&mut self, force_n: f64) {
        if !force_n.is_finite() {
            return;
        }
        for (value, load) in self.solution.iter_mut().zip(&self.load) {
            *value = load * force_n;
        }
        self.factor.solve(&mut self.solution, &mut self.scratch);
    }

    fn displacement_m(&self, r_m: f64, depth_m: f64) -> [f64; 2] {
        let [radial_m, depth_m] = self.grid.at(&self.solution, r_m, depth_m);
        // Inside, the second coordinate is the depth; outside, axial is out of the body.
        [0.0 - depth_m, radial_m]
    }
}
