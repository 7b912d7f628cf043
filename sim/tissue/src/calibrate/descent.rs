//! Least squares within bounds: Levenberg–Marquardt with projected steps.
//!
//! Each step solves (JᵀJ + λ diag JᵀJ) δ = −Jᵀr over the free variables: those not at a bound that
//! the gradient pushes against, and with an effect at all (Marquardt, "An algorithm for
//! least-squares estimation of nonlinear parameters", SIAM J. Appl. Math. 11, 1963). The step is
//! cut off at the bounds and accepted only if it lowers the sum of squares, so that the end is
//! never worse than the start.

use nalgebra::{DMatrix, DVector};

/// Number of times that λ is raised before a point counts as a minimum.
const TRIES: u32 = 13;
/// The residual is nearly linear, and friction and cutting nearly collinear: damping would only
/// slow the descent along their ridge.
const FIRST_LAMBDA: f64 = 1e-7;
/// A step that lowers the sum of squares by less than this fraction ends the descent.
const LEAST_GAIN: f64 = 1e-7;

/// A least-squares problem.
pub(super) struct LeastSquares<'p> {
    /// Residuals at a point, of constant length.
    pub residuals: &'p dyn Fn(&[f64]) -> Vec<f64>,
    pub lower: &'p [f64],
    pub upper: &'p [f64],
    /// Steps of the finite differences.
    pub step: &'p [f64],
    /// A sum of squares that counts as zero.
    pub enough: f64,
}

/// The end of a descent.
#[derive(Clone, Debug)]
pub(super) struct Lowest {
    pub at: Vec<f64>,
    /// Sum of the squares.
    pub cost: f64,
    pub iterations: u32,
    /// Whether it ended because no lower point was near.
    pub converged: bool,
}

impl LeastSquares<'_> {
    /// Descends from a point for at most `most` iterations.
    pub fn descend(&self, start: &[f64], most: u32) -> Lowest {
        let mut lambda = FIRST_LAMBDA;
        let at = self.within(start);
        let mut residuals = (self.residuals)(&at);
        let cost = square(&residuals);
        let mut lowest = Lowest { at, cost, iterations: 0, converged: false };
        while lowest.iterations < most && !lowest.converged {
            lowest.iterations += 1;
            let before = lowest.cost;
            if let Some((at, there)) = self.improve(&lowest, &residuals, &mut lambda) {
                lowest.at = at;
                lowest.cost = square(&there);
                residuals = there;
            }
            lowest.converged = before - lowest.cost <= LEAST_GAIN * before || lowest.cost <= self.enough;
        }
        lowest
    }

    /// One accepted step, if there is one: the new point and its residuals.
    fn improve(&self, from: &Lowest, residuals: &[f64], lambda: &mut f64) -> Option<(Vec<f64>, Vec<f64>)> {
        let jacobian = self.jacobian(&from.at, residuals);
        let gradient = jacobian.tr_mul(&DVector::from_column_slice(residuals));
        let normal = jacobian.tr_mul(&jacobian);
        let free = self.free(&from.at, &gradient, &normal);
        for _ in 0..TRIES {
            if let Some(step) = solve(&normal, &gradient, &free, *lambda) {
                let mut trial = from.at.clone();
                for (&variable, by) in free.iter().zip(step.iter()) {
                    trial[variable] += by;
                }
                let trial = self.within(&trial);
                let there = (self.residuals)(&trial);
                if square(&there) < from.cost {
                    *lambda = (*lambda * 0.1).max(1e-12);
                    return Some((trial, there));
                }
            }
            *lambda = (*lambda * 10.0).min(1e12);
        }
        None
    }

    /// ∂r/∂θ by one-sided differences, away from the upper bound, at a point and its residuals. A
    /// variable with equal bounds has no effect.
    pub fn jacobian(&self, at: &[f64], here: &[f64]) -> DMatrix<f64> {
        let mut jacobian = DMatrix::zeros(here.len(), at.len());
        for (variable, mut column) in jacobian.column_iter_mut().enumerate() {
            if self.lower[variable] >= self.upper[variable] {
                continue;
            }
            let step = self.step[variable];
            let by = if at[variable] + step <= self.upper[variable] { step } else { -step };
            let mut point = at.to_vec();
            point[variable] += by;
            let by = point[variable] - at[variable];
            let there = (self.residuals)(&point);
            column
                .iter_mut()
                .zip(there.iter().zip(here))
                .for_each(|(slope, (there, here))| *slope = (there - here) / by);
        }
        jacobian
    }

    fn free(&self, at: &[f64], gradient: &DVector<f64>, normal: &DMatrix<f64>) -> Vec<usize> {
        let is_free = |&variable: &usize| {
            let held_below = at[variable] <= self.lower[variable] && gradient[variable] >= 0.0;
            let held_above = at[variable] >= self.upper[variable] && gradient[variable] <= 0.0;
            normal[(variable, variable)] > 0.0 && !held_below && !held_above
        };
        (0..at.len()).filter(is_free).collect()
    }

    fn within(&self, point: &[f64]) -> Vec<f64> {
        point.iter().zip(self.lower.iter().zip(self.upper)).map(|(v, (low, high))| v.max(*low).min(*high)).collect()
    }
}

fn solve(normal: &DMatrix<f64>, gradient: &DVector<f64>, free: &[usize], lambda: f64) -> Option<DVector<f64>> {
    let mut damped = normal.select_rows(free).select_columns(free);
    for at in 0..free.len() {
        damped[(at, at)] *= 1.0 + lambda;
    }
    let down = -gradient.select_rows(free);
    damped.cholesky().map(|factor| factor.solve(&down))
}

/// Sum of the squares.
pub(super) fn square(residuals: &[f64]) -> f64 {
    residuals.iter().map(|r| r * r).sum()
}
