//! The lattice as a model of the tissue: the solution for small strains under one load.

use super::LatticeError;
use super::grid::LatticePatch;
use super::kernel::{NodalField, pull_all};
use super::lattice::{Damping, Lattice};
use super::laws::Linear;
use super::load::NodalLoad;
use super::relax::{Relaxation, RelaxationLimit, norm_squared};
use crate::{FieldModel, Model, Problem};

/// Convergence limit of a solution: two digits below the accuracy of any lattice.
const AT_REST: RelaxationLimit = RelaxationLimit { iterations: 5000, relative: 1e-7, scale: 1.0 };

/// A lattice at rest under one load, initially solved for 1 N. Each solve starts from zero
/// displacement.
#[derive(Clone, Debug)]
pub struct MassSpring {
    lattice: Lattice,
    load: NodalLoad,
    inverse_diagonal: NodalField,
    relaxation: Relaxation,
    displacement_m: NodalField,
}

impl MassSpring {
    /// Calibrates a lattice for a problem and solves it for 1 N.
    ///
    /// # Errors
    /// Those of [`Lattice::new`] and [`NodalLoad::new`].
    pub fn new(problem: &Problem, patch: &LatticePatch) -> Result<Self, LatticeError> {
        problem.check()?;
        let lattice = Lattice::new(&problem.slab, patch, Damping::default())?;
        let load = NodalLoad::new(&lattice, &problem.load)?;
        let mut inverse_diagonal = lattice.diagonal.clone();
        for sum in inverse_diagonal.axes.iter_mut().flatten().filter(|sum| **sum > 0.0) {
            *sum = 1.0 / *sum;
        }
        let (relaxation, displacement_m) = (Relaxation::new(&lattice), NodalField::zeros(lattice.grid.places()));
        let mut model = Self { lattice, load, inverse_diagonal, relaxation, displacement_m };
        model.solve(1.0);
        Ok(model)
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
        self.lattice.bytes() + self.relaxation.bytes() + self.inverse_diagonal.bytes() + self.displacement_m.bytes()
    }

    /// Solves for the displacement of the linearised lattice at rest. A force that is not finite
    /// keeps the last solution.
    fn solve(&mut self, force_n: f64) {
        if !force_n.is_finite() {
            return;
        }
        self.displacement_m.clear();
        self.relaxation.residual.clear();
        self.load.add(force_n, &mut self.relaxation.residual);
        let whole = norm_squared(&self.relaxation.residual, &self.inverse_diagonal).sqrt();
        let lattice = &self.lattice;
        let apply = |p: &NodalField, product: &mut NodalField| pull_all(lattice, &Linear, [p], product);
        self.relaxation.solve(
            apply,
            &self.inverse_diagonal,
            &mut self.displacement_m,
            RelaxationLimit { scale: whole, ..AT_REST },
        );
    }

    fn displacement_m(&self, r_m: f64, depth_m: f64) -> [f64; 2] {
        let [radial_m, _, axial_m] = self.lattice.grid.interpolate(&self.displacement_m, [r_m, 0.0, -depth_m]);
        [axial_m, radial_m]
    }
}
