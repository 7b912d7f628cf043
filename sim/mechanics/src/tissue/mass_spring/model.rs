//! The lattice as a model of the tissue: the answer of small strains to one load.

use super::LatticeError;
use super::grid::{Grid, Patch};
use super::kernel::{Field, pull_all};
use super::lattice::{Damping, Lattice};
use super::laws::Linear;
use super::load::NodalLoad;
use super::relax::{Limit, Relaxation, norm_squared};
use crate::tissue::{FieldModel, Model, Problem};

/// When an answer is at rest: two digits below what any lattice is worth.
const AT_REST: Limit = Limit { iterations: 5000, relative: 1e-7 };

/// A lattice at rest under one load. At small strains it is linear, so that it comes to rest once, under 1 N, and every
/// force is a multiple.
#[derive(Clone, Debug)]
pub struct MassSpring {
    grid: Grid,
    unknowns: usize,
    /// Displacement under 1 N, in m.
    unit_m: Field,
    force_n: f64,
}

impl MassSpring {
    /// Calibrates a lattice for a problem and lets it come to rest under 1 N.
    ///
    /// # Errors
    /// As [`Lattice::new`] and [`NodalLoad::new`].
    pub fn new(problem: &Problem, patch: &Patch) -> Result<Self, LatticeError> {
        problem.check()?;
        let lattice = Lattice::new(&problem.slab, patch, Damping::default())?;
        let load = NodalLoad::new(&lattice, &problem.load)?;
        let unit_m = rest(&lattice, &load);
        Ok(Self { unknowns: lattice.unknowns(), grid: lattice.grid, unit_m, force_n: 1.0 })
    }
}

/// Displacement of the linearised lattice at rest under 1 N, in m.
fn rest(lattice: &Lattice, load: &NodalLoad) -> Field {
    let mut displacement_m = Field::zeros(lattice.grid.places());
    let mut inverse_diagonal = lattice.diagonal.clone();
    for sum in inverse_diagonal.axes.iter_mut().flatten().filter(|sum| **sum > 0.0) {
        *sum = 1.0 / *sum;
    }
    let mut relaxation = Relaxation::new(lattice);
    load.add(1.0, &mut relaxation.residual);
    let whole = norm_squared(&relaxation.residual, &inverse_diagonal).sqrt();
    let apply = |p: &Field, product: &mut Field| pull_all(lattice, &Linear, [p], product);
    relaxation.solve(apply, &inverse_diagonal, &mut displacement_m, (AT_REST, whole));
    displacement_m
}

impl FieldModel for MassSpring {
    fn model(&self) -> Model {
        Model::MassSpring
    }

    fn unknowns(&self) -> usize {
        self.unknowns
    }

    fn bytes(&self) -> usize {
        self.unit_m.bytes()
    }

    /// What is not a number, or infinite, leaves the last answer.
    fn solve(&mut self, force_n: f64) {
        if force_n.is_finite() {
            self.force_n = force_n;
        }
    }

    fn displacement_m(&self, r_m: f64, depth_m: f64) -> [f64; 2] {
        let [radial_m, _, axial_m] = self.grid.interpolate(&self.unit_m, [r_m, 0.0, -depth_m]);
        [axial_m * self.force_n, radial_m * self.force_n]
    }
}
