//! The lattice as a model of the tissue: the answer of small strains to one load.

use super::LatticeError;
use super::grid::Patch;
use super::kernel::{Field, pull_all};
use super::lattice::{Damping, Lattice};
use super::laws::Linear;
use super::load::NodalLoad;
use super::relax::{Limit, Relaxation, norm_squared};
use crate::tissue::{FieldModel, Model, Problem};

/// When an answer is at rest: two digits below what any lattice is worth.
const AT_REST: Limit = Limit { iterations: 5000, relative: 1e-7 };

/// A lattice at rest under one load.
#[derive(Clone, Debug)]
pub struct MassSpring {
    lattice: Lattice,
    load: NodalLoad,
    displacement_m: Field,
    force_n: f64,
    relaxation: Relaxation,
    inverse_diagonal: Field,
    iterations: usize,
}

impl MassSpring {
    /// Calibrates a lattice for a problem; nothing pushes yet.
    ///
    /// # Errors
    /// As [`Lattice::new`] and [`NodalLoad::new`].
    pub fn new(problem: &Problem, patch: &Patch) -> Result<Self, LatticeError> {
        problem.check()?;
        let lattice = Lattice::new(&problem.slab, patch, Damping::default())?;
        let load = NodalLoad::new(&lattice, &problem.load)?;
        let zeros = || Field::zeros(lattice.grid.places());
        let mut inverse_diagonal = zeros();
        for (inverses, diagonal) in inverse_diagonal.axes.iter_mut().zip(&lattice.diagonal.axes) {
            for (inverse, &sum) in inverses.iter_mut().zip(diagonal) {
                *inverse = if sum > 0.0 { 1.0 / sum } else { 0.0 };
            }
        }
        let (displacement_m, relaxation) = (zeros(), Relaxation::new(&lattice));
        Ok(Self { lattice, load, displacement_m, force_n: 0.0, relaxation, inverse_diagonal, iterations: 0 })
    }

    /// The lattice.
    #[must_use]
    pub fn lattice(&self) -> &Lattice {
        &self.lattice
    }

    /// Iterations of the last answer.
    #[must_use]
    pub fn iterations(&self) -> usize {
        self.iterations
    }
}

impl FieldModel for MassSpring {
    fn model(&self) -> Model {
        Model::MassSpring
    }

    fn unknowns(&self) -> usize {
        self.lattice.unknowns()
    }

    fn bytes(&self) -> usize {
        let fields = self.displacement_m.bytes() + self.inverse_diagonal.bytes();
        self.lattice.bytes() + fields + self.relaxation.bytes()
    }

    /// Warm: from the last answer, scaled to the new force. What is not a number, or infinite, leaves the last answer.
    fn solve(&mut self, force_n: f64) {
        if !force_n.is_finite() {
            return;
        }
        let scale = if self.force_n == 0.0 { 0.0 } else { force_n / self.force_n };
        self.displacement_m.scale(scale);
        self.force_n = force_n;
        let Self { lattice, load, displacement_m, relaxation, inverse_diagonal, .. } = self;
        let residual = &mut relaxation.residual;
        residual.clear();
        load.add(force_n, residual);
        let whole = norm_squared(residual, inverse_diagonal).sqrt();
        // The law resists, so its pulls of −u are the springs' pulls of u.
        residual.scale(-1.0);
        pull_all(lattice, &Linear, [displacement_m], residual);
        residual.scale(-1.0);
        let apply = |p: &Field, product: &mut Field| pull_all(lattice, &Linear, [p], product);
        self.iterations = relaxation.solve(apply, inverse_diagonal, displacement_m, (AT_REST, whole));
    }

    fn displacement_m(&self, r_m: f64, depth_m: f64) -> [f64; 2] {
        let [radial_m, _, axial_m] = self.lattice.interpolate(&self.displacement_m, [r_m, 0.0, -depth_m]);
        [axial_m, radial_m]
    }
}
