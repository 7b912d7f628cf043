//! Implicit integration: backward Euler, as a minimisation.
//!
//! With x the displacement at the start, v the velocity and s the displacement step to be found,
//! backward Euler M(s/h − v)/h = f(x + s) − αMs/h − βK s/h holds where
//!
//! ```text
//! E(s) = |s − hv|²/(2h²) + α|s|²/(2h) + (β/2h) sᵀK(x)s + U(x + s) − F w(x + s),   |s|² = sᵀMs
//! ```
//!
//! is minimal (Martin et al. 2011). A few Newton steps decrease E: the stiffness they use is
//! positive semidefinite, so that each is a descent direction, and halving its length eventually
//! decreases E. From E(s) ≤ E(0) follows U − Fw ≤ U₀ − Fw₀ + ½|v|², so the velocity can always be
//! scaled to the remaining energy: **energy never grows**, however few Newton steps were made.

use super::LatticeError;
use super::kernel::{NodalField, pull_all};
use super::lattice::Lattice;
use super::laws::{Elastic, Stiffness};
use super::motion::LatticeMotion;
use super::relax::{Relaxation, RelaxationLimit, norm_squared};

/// Maximum number of Newton steps per time step.
pub const NEWTON_STEPS: usize = 6;
/// Maximum number of conjugate gradient iterations per Newton step.
pub const ITERATIONS: usize = 400;
/// Maximum number of halvings of a Newton step that went too far.
pub const HALVINGS: usize = 20;

/// Residual relative to the first at which a Newton step ends: the next one continues from there.
const ROUGH: f64 = 1e-6;
/// Residual relative to the forces in the tissue at which a time step ends.
const TIGHT: f64 = 1e-9;

/// Scratch of the implicit steps.
#[derive(Clone, Debug)]
pub struct ImplicitScratch {
    relaxation: Relaxation,
    /// Displacement at the start, in m.
    start_m: NodalField,
    /// Displacement step being found, in m.
    step_m: NodalField,
    /// Trial step, in m.
    tried_m: NodalField,
    correction_m: NodalField,
    inverse_diagonal: NodalField,
    /// Pulls of the springs, in N.
    work: NodalField,
}

impl ImplicitScratch {
    /// Scratch for this lattice.
    #[must_use]
    pub fn new(lattice: &Lattice) -> Self {
        let zeros = || NodalField::zeros(lattice.grid.places());
        Self {
            relaxation: Relaxation::new(lattice),
            start_m: zeros(),
            step_m: zeros(),
            tried_m: zeros(),
            correction_m: zeros(),
            inverse_diagonal: zeros(),
            work: zeros(),
        }
    }
}

/// Makes one step of any length; an infinite one goes to rest. A step of 0 changes nothing.
///
/// # Errors
/// If the step is negative or NaN; nothing has moved then.
pub fn step(
    lattice: &Lattice,
    motion: &mut LatticeMotion,
    scratch: &mut ImplicitScratch,
    step_s: f64,
) -> Result<(), LatticeError> {
    if step_s.is_nan() || step_s < 0.0 {
        return Err(LatticeError::Time { time_s: step_s, longest_s: f64::INFINITY });
    }
    if step_s > 0.0 {
        Step { lattice, motion, scratch, per_s: 1.0 / step_s }.make();
    }
    Ok(())
}

/// A step in progress. In terms of 1/h an infinite step needs no special case.
struct Step<'a> {
    lattice: &'a Lattice,
    motion: &'a mut LatticeMotion,
    scratch: &'a mut ImplicitScratch,
    /// 1/h, in 1/s.
    per_s: f64,
}

impl Step<'_> {
    fn make(mut self) {
        self.scratch.start_m.copy_from(&self.motion.displacement_m);
        self.scratch.step_m.clear();
        let (potential_j, moving_j) = (self.potential_j(), self.moving_j());
        let first_j = potential_j + moving_j;
        self.precondition();
        let mut cost_j = self.coast(first_j);
        let mut floor = TIGHT * TIGHT * (potential_j.abs() + moving_j);
        for newton in 0..NEWTON_STEPS {
            self.find_residual();
            let square = norm_squared(&self.scratch.relaxation.residual, &self.scratch.inverse_diagonal);
            if newton == 0 {
                floor = floor.max(TIGHT * TIGHT * square);
            }
            if square <= floor || !self.find_correction(square.sqrt()) {
                break;
            }
            let Some(lower_j) = self.descend(cost_j) else { break };
            cost_j = lower_j;
        }
        self.finish(first_j);
    }

    /// Starts from the extrapolated position if that is cheaper than the present one. Returns the
    /// cost.
    fn coast(&mut self, staying_j: f64) -> f64 {
        if self.per_s > 0.0 {
            self.scratch.tried_m.copy_from(&self.motion.velocity_m_per_s);
            self.scratch.tried_m.scale(1.0 / self.per_s);
            if let Some(cost_j) = self.try_step(staying_j) {
                return cost_j;
            }
        }
        self.motion.displacement_m.copy_from(&self.scratch.start_m);
        staying_j
    }

    /// Applies the part of the correction that decreases E. Returns the new E, or `None` if no part
    /// did.
    fn descend(&mut self, cost_j: f64) -> Option<f64> {
        let mut part = 1.0;
        for _ in 0..HALVINGS {
            self.scratch.tried_m.copy_from(&self.scratch.step_m);
            self.scratch.tried_m.add_scaled(part, &self.scratch.correction_m);
            if let Some(lower_j) = self.try_step(cost_j) {
                return Some(lower_j);
            }
            part *= 0.5;
        }
        None
    }

    /// Accepts the trial step if E is below a bound. Returns the new E.
    fn try_step(&mut self, below_j: f64) -> Option<f64> {
        self.motion.displacement_m.copy_from(&self.scratch.start_m);
        self.motion.displacement_m.add_scaled(1.0, &self.scratch.tried_m);
        let cost_j = self.potential_j() + self.delay_j() + self.dashpots_j();
        if cost_j < below_j {
            self.scratch.step_m.copy_from(&self.scratch.tried_m);
            return Some(cost_j);
        }
        None
    }

    /// Energy of the springs minus the work of the load, in J.
    fn potential_j(&self) -> f64 {
        let u = &self.motion.displacement_m;
        self.lattice.spring_energy_j(u) - self.motion.force_n * self.motion.load.work_m(u)
    }

    fn moving_j(&self) -> f64 {
        self.lattice.motion_energy_j(&self.motion.velocity_m_per_s)
    }

    /// Terms of E for inertia and drag of the trial step, in J.
    fn delay_j(&self) -> f64 {
        let (per_s, drag) = (self.per_s, self.lattice.damping.mass_per_s * self.per_s);
        let axis_j = |axis: usize| -> f64 {
            let velocities = self.motion.velocity_m_per_s.axes[axis].iter();
            let known = velocities.zip(&self.lattice.masses.axes[axis]).zip(&self.scratch.tried_m.axes[axis]);
            known.map(|((v, m), s)| 0.5 * m * ((s * per_s - v) * (s * per_s - v) + drag * s * s)).sum()
        };
        (0..3).map(axis_j).sum()
    }

    /// Term of E for the dashpots of the trial step, in J.
    fn dashpots_j(&mut self) -> f64 {
        let law = self.dashpots();
        if law.along <= 0.0 {
            return 0.0;
        }
        self.scratch.work.clear();
        let fields = [&self.scratch.start_m, &self.scratch.tried_m];
        pull_all(self.lattice, &law, fields, &mut self.scratch.work);
        0.5 * self.scratch.work.dot(&self.scratch.tried_m)
    }

    /// Resistance of the dashpots to the step, in the directions of the springs at its start.
    fn dashpots(&self) -> Stiffness {
        Stiffness { along: self.lattice.damping.stiffness_s * self.per_s, across: 0.0 }
    }

    /// Inertia and drag per displacement, over mass, in 1/s².
    fn inertia_per_s2(&self) -> f64 {
        self.per_s * (self.per_s + self.lattice.damping.mass_per_s)
    }

    /// The inverse of the diagonal at rest: sufficient as a preconditioner in any deformed state.
    fn precondition(&mut self) {
        let (inertia, along) = (self.inertia_per_s2(), 1.0 + self.dashpots().along);
        for axis in 0..3 {
            let known = self.lattice.masses.axes[axis].iter().zip(&self.lattice.diagonal.axes[axis]);
            for (inverse, (mass, diagonal)) in self.scratch.inverse_diagonal.axes[axis].iter_mut().zip(known) {
                let sum = inertia * mass + along * diagonal;
                *inverse = if *mass > 0.0 { 1.0 / sum } else { 0.0 };
            }
        }
    }

    /// −∂E/∂s, in N.
    fn find_residual(&mut self) {
        let law = self.dashpots();
        let inertia = self.inertia_per_s2();
        let scratch = &mut *self.scratch;
        scratch.work.clear();
        if law.along > 0.0 {
            pull_all(self.lattice, &law, [&scratch.start_m, &scratch.step_m], &mut scratch.work);
            scratch.work.scale(-1.0);
        }
        pull_all(self.lattice, &Elastic, [&self.motion.displacement_m], &mut scratch.work);
        self.motion.load.add(self.motion.force_n, &mut scratch.work);
        for axis in 0..3 {
            let known = self.lattice.masses.axes[axis].iter().zip(&self.motion.velocity_m_per_s.axes[axis]);
            let known = known.zip(&scratch.step_m.axes[axis]).zip(&scratch.work.axes[axis]);
            for (residual, (((mass, v), s), force)) in scratch.relaxation.residual.axes[axis].iter_mut().zip(known) {
                *residual = force + mass * (self.per_s * v - inertia * s);
            }
        }
    }

    /// Computes a Newton step from the residual. Returns whether one was found.
    fn find_correction(&mut self, scale: f64) -> bool {
        let law = Stiffness { along: 1.0 + self.dashpots().along, across: 1.0 };
        let inertia = self.inertia_per_s2();
        let (lattice, displacement_m) = (self.lattice, &self.motion.displacement_m);
        let scratch = &mut *self.scratch;
        scratch.correction_m.clear();
        let apply = |p: &NodalField, product: &mut NodalField| {
            pull_all(lattice, &law, [displacement_m, p], product);
            for axis in 0..3 {
                let known = lattice.masses.axes[axis].iter().zip(&p.axes[axis]);
                product.axes[axis].iter_mut().zip(known).for_each(|(sum, (mass, p))| *sum += inertia * mass * p);
            }
        };
        let limit = RelaxationLimit { iterations: ITERATIONS, relative: ROUGH, scale };
        scratch.relaxation.solve(apply, &scratch.inverse_diagonal, &mut scratch.correction_m, limit) > 0
    }

    /// Sets displacement and velocity from the step, with the velocity scaled to the remaining
    /// energy.
    fn finish(self, first_j: f64) {
        let Self { lattice, motion, scratch, per_s } = self;
        motion.displacement_m.copy_from(&scratch.start_m);
        motion.displacement_m.add_scaled(1.0, &scratch.step_m);
        motion.velocity_m_per_s.copy_from(&scratch.step_m);
        motion.velocity_m_per_s.scale(per_s);
        let u = &motion.displacement_m;
        let potential_j = lattice.spring_energy_j(u) - motion.force_n * motion.load.work_m(u);
        let moving_j = lattice.motion_energy_j(&motion.velocity_m_per_s);
        let left_j = (first_j - potential_j).max(0.0);
        if moving_j > left_j {
            motion.velocity_m_per_s.scale((left_j / moving_j).sqrt());
        }
    }
}
