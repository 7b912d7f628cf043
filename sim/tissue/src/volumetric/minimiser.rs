//! The nearest minimum of an energy, by a quasi-Newton method whose initial Hessian is a factor.
//!
//! L-BFGS with the stiffness at rest as its initial Hessian (Nocedal 1980; Liu, Bouaziz and Kavan
//! 2017): without rotations it converges at once, and with large ones it updates the Hessian. Every
//! step decreases the energy.

use super::dot;
use crate::multifrontal::Cholesky;

/// Number of stored pairs of a step and the change of the gradient.
const MEMORY: usize = 8;

/// Maximum number of halvings of a step that would raise the energy.
const HALVINGS: usize = 20;

/// Fraction of the decrease predicted by the slope that a step must achieve (Armijo).
const SUFFICIENT: f64 = 1e-4;

/// Energies closer than this fraction of their parts are equal.
const ROUNDING: f64 = 1e-13;

/// Stopping criteria.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Effort {
    /// Maximum number of iterations.
    pub iterations: usize,
    /// Relative error in the energy norm at which the search stops.
    pub tolerance: f64,
}

/// Result of a search.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Outcome {
    /// Number of iterations: each is a back-substitution and one or a few sums over the elements.
    pub iterations: usize,
    /// Estimate of the remaining relative error, in the energy norm.
    pub remaining: f64,
    /// Whether it is within the tolerance.
    pub converged: bool,
}

/// An energy, in J, at unknowns in m, with its gradient in N; and the magnitude of its largest
/// part, which determines the rounding error.
pub(super) trait DifferentiableEnergy {
    /// Fills the gradient. Returns the energy and the magnitude of its parts.
    fn at(&mut self, u_m: &[f64], gradient_n: &mut [f64]) -> (f64, f64);
}

/// A step and the change of the gradient along it.
#[derive(Clone, Debug)]
struct Pair {
    step: Vec<f64>,
    change: Vec<f64>,
    /// 1 / (step · change).
    reciprocal: f64,
    /// Scratch of the two-loop recursion.
    share: f64,
}

/// A factor and the memory of the search.
#[derive(Clone, Debug)]
pub(super) struct Minimiser {
    factor: Cholesky,
    /// The first `known` entries are used, oldest first.
    memory: Vec<Pair>,
    known: usize,
    gradient: Vec<f64>,
    direction: Vec<f64>,
    trial: Vec<f64>,
    trial_gradient: Vec<f64>,
    scratch: Vec<f64>,
}

impl Minimiser {
    pub fn new(factor: Cholesky, unknowns: usize) -> Self {
        let zeros = || vec![0.0; unknowns];
        let pair = || Pair { step: zeros(), change: zeros(), reciprocal: 0.0, share: 0.0 };
        let scratch = vec![0.0; factor.scratch_len()];
        Self {
            factor,
            memory: (0..MEMORY).map(|_| pair()).collect(),
            known: 0,
            gradient: zeros(),
            direction: zeros(),
            trial: zeros(),
            trial_gradient: zeros(),
            scratch,
        }
    }

    pub fn bytes(&self) -> usize {
        self.factor.bytes() + 8 * ((2 * MEMORY + 4) * self.gradient.len() + self.scratch.len())
    }

    /// Descends from `u_m`. Never allocates.
    pub fn minimise(&mut self, u_m: &mut [f64], energy: &mut impl DifferentiableEnergy, effort: &Effort) -> Outcome {
        let mut outcome = Outcome { iterations: 0, remaining: f64::INFINITY, converged: false };
        let (mut value, mut size) = energy.at(u_m, &mut self.gradient);
        let mut scale = 0.0_f64;
        while value.is_finite() {
            self.direct();
            let slope = dot(&self.gradient, &self.direction);
            scale = scale.max(-slope).max(size);
            outcome.remaining = if slope < 0.0 { (-slope / scale).sqrt() } else { 0.0 };
            outcome.converged = outcome.remaining <= effort.tolerance;
            if outcome.converged || outcome.iterations == effort.iterations {
                break;
            }
            outcome.iterations += 1;
            match self.go(u_m, energy, value, slope) {
                Some(found) => (value, size) = found,
                // Pairs learnt elsewhere may mislead: clear them before giving up.
                None if self.known > 0 => self.known = 0,
                None => break,
            }
        }
        outcome
    }

    /// The direction of the next step: minus the gradient, times the approximate inverse Hessian.
    fn direct(&mut self) {
        let direction = &mut self.direction;
        direction.copy_from_slice(&self.gradient);
        for pair in self.memory[..self.known].iter_mut().rev() {
            pair.share = pair.reciprocal * dot(&pair.step, direction);
            add(direction, -pair.share, &pair.change);
        }
        self.factor.solve(direction, &mut self.scratch);
        for pair in &self.memory[..self.known] {
            let share = pair.share - pair.reciprocal * dot(&pair.change, direction);
            add(direction, share, &pair.step);
        }
        direction.iter_mut().for_each(|d| *d = -*d);
    }

    /// One step along the direction, halved until the energy decreases; `None` if it does not.
    fn go(
        &mut self,
        u_m: &mut [f64],
        energy: &mut impl DifferentiableEnergy,
        value: f64,
        slope: f64,
    ) -> Option<(f64, f64)> {
        let mut length = 1.0;
        for _ in 0..=HALVINGS {
            for ((trial, u), d) in self.trial.iter_mut().zip(&*u_m).zip(&self.direction) {
                *trial = u + length * d;
            }
            let (found, size) = energy.at(&self.trial, &mut self.trial_gradient);
            if found <= value + SUFFICIENT * length * slope + ROUNDING * size {
                self.learn(u_m);
                u_m.copy_from_slice(&self.trial);
                std::mem::swap(&mut self.gradient, &mut self.trial_gradient);
                return Some((found, size));
            }
            length *= 0.5;
        }
        None
    }

    /// Stores the step from `u_m` to the trial in place of the oldest one.
    fn learn(&mut self, u_m: &[f64]) {
        if self.known == MEMORY {
            self.memory.rotate_left(1);
            self.known -= 1;
        }
        let pair = &mut self.memory[self.known];
        let old = u_m.iter().zip(&self.gradient);
        let new = self.trial.iter().zip(&self.trial_gradient);
        for (((step, change), new), old) in pair.step.iter_mut().zip(&mut pair.change).zip(new).zip(old) {
            (*step, *change) = (new.0 - old.0, new.1 - old.1);
        }
        let product = dot(&pair.step, &pair.change);
        let curved = product > 1e-10 * (dot(&pair.step, &pair.step) * dot(&pair.change, &pair.change)).sqrt();
        if curved && product.is_normal() {
            pair.reciprocal = 1.0 / product;
            self.known += 1;
        }
    }
}

fn add(target: &mut [f64], factor: f64, source: &[f64]) {
    for (t, s) in target.iter_mut().zip(source) {
        *t += factor * s;
    }
}
