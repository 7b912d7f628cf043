//! Large rotations, in equilibrium or in time.

use super::minimiser::{DifferentiableEnergy, Effort, Minimiser, Outcome};
use super::{Body, Patch, VolumetricError, answerable, dot};
use crate::{FieldModel, Model};

/// A body that rotates and moves under forces on its unknowns.
#[derive(Clone, Debug)]
pub struct TissueMotion {
    minimiser: Minimiser,
    /// Length of a time step, in s; `None` makes every step an equilibrium.
    step_s: Option<f64>,
    effort: Effort,
    u_m: Vec<f64>,
    v_m_per_s: Vec<f64>,
    /// Positions of the unknowns after a step without forces.
    coasting_m: Vec<f64>,
    start_m: Vec<f64>,
}

/// Energies of a body, in J.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Energies {
    /// Energy of its deformation.
    pub elastic_j: f64,
    /// Energy of its motion.
    pub kinetic_j: f64,
}

/// Elastic energy, minus the work of the load, plus the inertial term (Martin and others 2011).
struct Incremental<'a> {
    body: &'a Body,
    load_n: &'a [f64],
    coasting_m: &'a [f64],
    per_s2: f64,
}

impl DifferentiableEnergy for Incremental<'_> {
    fn at(&mut self, u_m: &[f64], gradient_n: &mut [f64]) -> (f64, f64) {
        gradient_n.fill(0.0);
        let elastic_j = self.body.energy_j(u_m, gradient_n);
        let (mut work_j, mut inertial_j) = (0.0, 0.0);
        let known = self.load_n.iter().zip(self.coasting_m).zip(self.body.mass_kg());
        for ((gradient, u), ((load, coasting), mass)) in gradient_n.iter_mut().zip(u_m).zip(known) {
            let pull = self.per_s2 * mass * (u - coasting);
            *gradient += pull - load;
            work_j += load * u;
            inertial_j += 0.5 * pull * (u - coasting);
        }
        (elastic_j + inertial_j - work_j, elastic_j + inertial_j + work_j.abs())
    }
}

impl TissueMotion {
    /// A body at rest. A step is an equilibrium, or one of backward Euler with a length in s.
    ///
    /// # Errors
    /// If a part of the body is free to move, or the length is not a positive number.
    pub fn new(body: &Body, step_s: Option<f64>, effort: Effort) -> Result<Self, VolumetricError> {
        if let Some(step_s) = step_s {
            law::axial::Domain::Positive.check("step_s", step_s, "s")?;
        }
        let per_s2 = step_s.map_or(0.0, |step_s| 1.0 / (step_s * step_s));
        let minimiser = Minimiser::new(body.factorise(per_s2)?, body.unknowns());
        let zeros = || vec![0.0; body.unknowns()];
        let (u_m, v_m_per_s, coasting_m, start_m) = (zeros(), zeros(), zeros(), zeros());
        Ok(Self { minimiser, step_s, effort, u_m, v_m_per_s, coasting_m, start_m })
    }

    /// Returns to the start of the last step, with zero velocity.
    fn retreat(&mut self) {
        self.u_m.copy_from_slice(&self.start_m);
        self.v_m_per_s.fill(0.0);
    }

    /// Displacement of the unknowns, in m.
    #[must_use]
    pub fn u_m(&self) -> &[f64] {
        &self.u_m
    }

    /// Sets the unknowns, in m, with zero velocity.
    pub fn displace(&mut self, u_m: &[f64]) {
        self.u_m.copy_from_slice(u_m);
        self.v_m_per_s.fill(0.0);
    }

    /// Makes one step under forces on the unknowns, in N. Forces that are not finite leave the body
    /// unchanged.
    ///
    /// Under a steady load the sum of elastic and kinetic energy minus the load's work never
    /// increases, however early the search ends: it starts at the body's present position, where
    /// the incremental energy equals the body's energy, and any increase through the velocity is
    /// removed from the velocity.
    pub fn step(&mut self, body: &Body, load_n: &[f64]) -> Outcome {
        if !load_n.iter().sum::<f64>().is_finite() {
            return Outcome { iterations: 0, remaining: f64::INFINITY, converged: false };
        }
        let step_s = self.step_s.unwrap_or(0.0);
        self.start_m.copy_from_slice(&self.u_m);
        for ((coasting, u), v) in self.coasting_m.iter_mut().zip(&self.u_m).zip(&self.v_m_per_s) {
            *coasting = u + step_s * v;
        }
        let per_s2 = self.step_s.map_or(0.0, |step_s| 1.0 / (step_s * step_s));
        let mut energy = Incremental { body, load_n, coasting_m: &self.coasting_m, per_s2 };
        let outcome = self.minimiser.minimise(&mut self.u_m, &mut energy, &self.effort);
        if self.step_s.is_some() {
            self.brake(body, load_n, step_s);
        }
        outcome
    }

    /// Reduces the velocity after a step so that the total energy does not increase.
    fn brake(&mut self, body: &Body, load_n: &[f64], step_s: f64) {
        let before = self.kinetic_j(body);
        let unused = &mut self.coasting_m;
        let free_j = before + body.energy_j(&self.start_m, unused)
            - dot(load_n, &self.start_m)
            - body.energy_j(&self.u_m, unused)
            + dot(load_n, &self.u_m);
        for ((v, u), start) in self.v_m_per_s.iter_mut().zip(&self.u_m).zip(&self.start_m) {
            *v = (u - start) / step_s;
        }
        let kinetic = self.kinetic_j(body);
        if kinetic > free_j {
            let share = (free_j.max(0.0) / kinetic).sqrt();
            self.v_m_per_s.iter_mut().for_each(|v| *v *= share);
        }
    }

    fn kinetic_j(&self, body: &Body) -> f64 {
        0.5 * self.v_m_per_s.iter().zip(body.mass_kg()).map(|(v, mass)| mass * v * v).sum::<f64>()
    }

    /// The current energies.
    #[must_use]
    pub fn energies(&self, body: &Body) -> Energies {
        let elastic_j = body.energy_j(&self.u_m, &mut vec![0.0; self.u_m.len()]);
        Energies { elastic_j, kinetic_j: self.kinetic_j(body) }
    }

    fn bytes(&self) -> usize {
        self.minimiser.bytes() + 8 * 4 * self.u_m.len()
    }
}

/// Number of partial loads that are tried before a load is rejected.
const ATTEMPTS: usize = 10;

/// A load without an equilibrium, and the one that is held instead.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[error("force_n = {wanted_n} N: no equilibrium was found; the nearest load with an equilibrium is {held_n} N")]
pub struct RefusedLoad {
    /// The requested load, in N.
    pub wanted_n: f64,
    /// The load of the solution, in N.
    pub held_n: f64,
}

/// The tissue around a needle, with large rotations.
#[derive(Clone, Debug)]
pub struct Corotational {
    patch: Patch,
    motion: TissueMotion,
    load_n: Vec<f64>,
    last: Outcome,
    /// The acting load, in N.
    held_n: f64,
    /// The nearest load without an equilibrium, in N.
    lost_n: Option<f64>,
    refused: Option<RefusedLoad>,
}

impl Corotational {
    /// A patch at rest. A step is an equilibrium, or one of backward Euler with a length in s.
    ///
    /// # Errors
    /// If the length is not a positive number.
    pub fn new(patch: Patch, step_s: Option<f64>, effort: Effort) -> Result<Self, VolumetricError> {
        let motion = TissueMotion::new(patch.body(), step_s, effort)?;
        let load_n = vec![0.0; patch.body().unknowns()];
        Ok(Self { patch, motion, load_n, last: Outcome::default(), held_n: 0.0, lost_n: None, refused: None })
    }

    /// The tissue.
    #[must_use]
    pub fn patch(&self) -> &Patch {
        &self.patch
    }

    /// Its displacement and velocity.
    #[must_use]
    pub fn motion(&self) -> &TissueMotion {
        &self.motion
    }

    /// The same, mutable.
    pub fn motion_mut(&mut self) -> &mut TissueMotion {
        &mut self.motion
    }

    /// Result of the last step.
    #[must_use]
    pub fn last(&self) -> Outcome {
        self.last
    }

    /// Checks whether an equilibrium was found under the last load. If not, the solution is that of
    /// the nearest load with one. A time step is never rejected: it goes as far as its effort
    /// allows.
    ///
    /// # Errors
    /// The rejected load, with the one that is held.
    pub fn check(&self) -> Result<(), RefusedLoad> {
        self.refused.map_or(Ok(()), Err)
    }

    /// The current energies.
    #[must_use]
    pub fn energies(&self) -> Energies {
        self.motion.energies(self.patch.body())
    }

    /// Makes one step under a load, in N.
    fn step(&mut self, force_n: f64) {
        for (force, unit) in self.load_n.iter_mut().zip(self.patch.load()) {
            *force = force_n * unit;
        }
        self.last = self.motion.step(self.patch.body(), &self.load_n);
    }

    /// Finds the equilibrium under a load, in N: directly, otherwise in parts that are halved until
    /// one is found.
    fn approach(&mut self, wanted_n: f64) {
        let mut part = wanted_n - self.held_n;
        let beyond =
            |lost: f64| (lost - self.held_n).signum() == part.signum() && (lost - self.held_n).abs() <= part.abs();
        let attempts = if self.lost_n.is_some_and(beyond) { 0 } else { ATTEMPTS };
        for _ in 0..attempts {
            let left = wanted_n - self.held_n;
            let whole = left.abs() <= part.abs();
            let next_n = if whole { wanted_n } else { self.held_n + part };
            self.step(next_n);
            if self.last.converged {
                (self.held_n, self.lost_n) = (next_n, None);
                if whole {
                    self.refused = None;
                    return;
                }
            } else {
                self.motion.retreat();
                self.lost_n = Some(next_n);
                part *= 0.5;
            }
        }
        self.refused = Some(RefusedLoad { wanted_n, held_n: self.held_n });
    }
}

impl FieldModel for Corotational {
    fn model(&self) -> Model {
        Model::Volumetric
    }

    fn unknowns(&self) -> usize {
        self.load_n.len()
    }

    fn bytes(&self) -> usize {
        self.patch.bytes() + self.motion.bytes() + 8 * self.load_n.len()
    }

    /// Makes one step. A force that cannot be solved for, such as NaN, keeps the last load; a load
    /// without an equilibrium is rejected, see [`Self::check`].
    fn solve(&mut self, force_n: f64) {
        let force_n = if answerable(force_n) { force_n } else { self.held_n };
        if self.motion.step_s.is_some() {
            self.held_n = force_n;
            self.step(force_n);
        } else {
            self.approach(force_n);
        }
    }

    fn displacement_m(&self, r_m: f64, depth_m: f64) -> [f64; 2] {
        self.patch.along_x_m(self.motion.u_m(), r_m, depth_m)
    }
}
