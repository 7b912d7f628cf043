//! A moving lattice with its integrators.

use tissue::mass_spring::explicit::{self, ExplicitScratch};
use tissue::mass_spring::implicit::{self, ImplicitScratch};
use tissue::mass_spring::{Damping, Lattice, LatticeError, LatticeMotion, NodalLoad};

use super::{RADIUS_M, lower_back, patch, problem};
use crate::{Measured, largest};

/// A lattice of 1 mm cells under a load on the skin, with its integrators.
pub(super) struct Moved {
    pub(super) lattice: Lattice,
    pub(super) motion: LatticeMotion,
    explicit: ExplicitScratch,
    implicit: ImplicitScratch,
}

/// A function that integrates over a time in s.
pub(super) type Advance = fn(&mut Moved, f64) -> Result<(), LatticeError>;

impl Moved {
    pub(super) fn new(damping: Damping) -> Result<Self, LatticeError> {
        let problem = problem(lower_back());
        let lattice = Lattice::new(&problem.slab, &patch(1.1e-3, RADIUS_M), damping)?;
        let motion = LatticeMotion::new(&lattice, NodalLoad::new(&lattice, &problem.load)?);
        let (explicit, implicit) = (ExplicitScratch::new(&lattice), ImplicitScratch::new(&lattice));
        Ok(Self { lattice, motion, explicit, implicit })
    }

    pub(super) fn undamped() -> Result<Self, LatticeError> {
        Self::new(Damping::default())
    }

    /// Integrates in stable sub-steps.
    pub(super) fn explicitly(&mut self, time_s: f64) -> Result<(), LatticeError> {
        explicit::advance(&self.lattice, &mut self.motion, &mut self.explicit, time_s).map(|_| ())
    }

    /// Integrates in one implicit step.
    pub(super) fn implicitly(&mut self, time_s: f64) -> Result<(), LatticeError> {
        implicit::step(&self.lattice, &mut self.motion, &mut self.implicit, time_s)
    }

    /// Makes one explicit step of any length.
    pub(super) fn step(&mut self, step_s: f64) -> Result<(), LatticeError> {
        explicit::step(&self.lattice, &mut self.motion, &mut self.explicit, step_s)
    }

    pub(super) fn energy_j(&self) -> f64 {
        self.lattice.elastic_energy_j(&self.motion) + self.lattice.kinetic_energy_j(&self.motion)
    }

    /// Returns the displacement of the skin at the needle, in m.
    pub(super) fn skin_m(&self) -> f64 {
        self.motion.displacement_m(&self.lattice, [0.0; 3])[2]
    }

    /// Inverts the cells around the needle.
    pub(super) fn invert(&mut self) {
        let near = |[x, y, z]: [f64; 3]| x * x + y * y < 4e-6 && z > -2e-3;
        self.motion.displace(&self.lattice, |at| if near(at) { [0.0, 0.0, -2.5e-3] } else { [0.0; 3] });
    }

    pub(super) fn rest(&mut self) -> Result<(), LatticeError> {
        (0..8).try_for_each(|_| self.implicitly(f64::INFINITY))
    }
}

/// Returns the largest ratio of the energy to the most work done until then; the force is constant
/// during a tick.
pub(super) fn energy_over_work(
    moved: &mut Moved,
    advance: Advance,
    tick_s: f64,
    forces_n: impl IntoIterator<Item = f64>,
) -> Measured {
    let (mut ratios, mut work_j, mut most_j) = (Vec::new(), 0.0, 0.0_f64);
    for force_n in forces_n {
        moved.motion.push(force_n);
        let before_j = moved.lattice.load_work_j(&moved.motion);
        advance(moved, tick_s)?;
        work_j += moved.lattice.load_work_j(&moved.motion) - before_j;
        most_j = most_j.max(work_j);
        // There is no work yet before a force has moved anything.
        if most_j > 0.0 {
            ratios.push(moved.energy_j() / most_j);
        }
    }
    Ok(largest(ratios))
}
