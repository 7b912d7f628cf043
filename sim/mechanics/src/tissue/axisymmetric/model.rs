//! The model of one load: a mesh, its factor and its last answer.

use super::assembly::Grid;
use super::basis::basis;
use super::load::{across, along};
use super::mesh::Spans;
use super::{AxisymmetricError, MeshSpec, Side};
use crate::tissue::multifrontal::{Cholesky, FIXED};
use crate::tissue::{FieldModel, Model, Problem};

/// A load on layers, meshed and factorised; solved for 1 N to begin with.
#[derive(Clone, Debug)]
pub struct Axisymmetric {
    grid: Grid,
    factor: Cholesky,
    /// Forces of 1 N on the unknowns, in N per radian.
    load: Vec<f64>,
    /// The last answer, in m.
    solution: Vec<f64>,
    scratch: Vec<f64>,
    /// Force for each metre that the tissue gives way at the load, in N/m.
    stiffness_n_per_m: f64,
}

impl Axisymmetric {
    /// Meshes and factorises a problem.
    ///
    /// # Errors
    /// The first number out of range, a mesh that does not fit the layers, or contrasts beyond double precision.
    pub fn new(problem: &Problem, mesh: &MeshSpec) -> Result<Self, AxisymmetricError> {
        Self::with_side(problem, mesh, Side::Clamped)
    }

    /// The same with a choice of what the side does.
    ///
    /// # Errors
    /// As for [`Self::new`].
    pub fn with_side(problem: &Problem, mesh: &MeshSpec, side: Side) -> Result<Self, AxisymmetricError> {
        problem.check()?;
        mesh.check(problem)?;
        let grid = Grid::new(Spans::new(&mesh.radial), Spans::new(&mesh.axial), side);
        let factor = grid.factorise(&problem.slab.solid())?;
        let (across, along) = (across(problem.load.radius_m, &grid.radial), along(&problem.load, &grid.axial));
        let mut load = vec![0.0; grid.unknowns];
        for (node, &[_, unknown]) in grid.nodes.iter().enumerate().filter(|&(_, &[_, unknown])| unknown != FIXED) {
            load[unknown as usize] = across[node / along.len()] * along[node % along.len()];
        }
        let scratch = vec![0.0; factor.scratch_len()];
        let mut model = Self { grid, factor, solution: load.clone(), load, scratch, stiffness_n_per_m: 0.0 };
        model.solve(1.0);
        let [from_m, to_m] = problem.load.ends_m();
        model.stiffness_n_per_m = 1.0 / model.displacement_m(0.0, 0.5 * (from_m + to_m))[0].abs();
        Ok(model)
    }

    /// The field's own stiffness: force over the axial displacement on the axis at the load, in the middle of a drag,
    /// in N/m. Infinite on the clamped base.
    #[must_use]
    pub fn stiffness_n_per_m(&self) -> f64 {
        self.stiffness_n_per_m
    }

    /// How many numbers the factor holds: a solve reads each twice.
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
        let numbers = self.load.len() + self.solution.len() + self.scratch.len() + self.grid.nodes.len();
        self.factor.bytes() + numbers * size_of::<f64>()
    }

    /// What is not a number, or infinite, leaves the last answer.
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
        let grid = &self.grid;
        let (Some((across, x)), Some((along, y))) = (grid.radial.find(r_m), grid.axial.find(depth_m)) else {
            return [0.0; 2];
        };
        let (phi, psi) = (basis(across.order).values(x), basis(along.order).values(y));
        let value = |unknown: u32| self.solution.get(unknown as usize).copied().unwrap_or(0.0);
        let [mut axial_m, mut radial_m] = [0.0; 2];
        for (column, phi) in phi[..=across.order].iter().enumerate() {
            let first = (across.first + column) * grid.axial.nodes() + along.first;
            for (&[radial, axial], psi) in grid.nodes[first..=first + along.order].iter().zip(psi) {
                radial_m += phi * psi * value(radial);
                // Inside, the second coordinate is the depth; outside, axial is out of the body.
                axial_m -= phi * psi * value(axial);
            }
        }
        [axial_m, radial_m]
    }
}
