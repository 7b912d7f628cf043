//! How far the fitted numbers can be trusted, and what the curve does not tell at all.
//!
//! With the Jacobian J of the law and residual deviation σ, the variables' covariance is σ² (JᵀJ)⁻¹. Each variable is
//! measured in its own size, so that an eigenvector of JᵀJ with eigenvalue λ is a joint relative change that alters the
//! curve by √λ; one that could be as large as the variables themselves before it showed, σ/√λ > 1, is not determined.

use nalgebra::{DMatrix, DVector, SymmetricEigen};

use super::model::{Guess, Model, Quantity, VARIABLES, residual_rms_n};
use crate::axial::Layer;

/// A residual never speaks for more than this part of the peak (choice): a noise-free curve would make everything exact.
pub(super) const FINEST_PART: f64 = 1e-3;
/// A component of an eigenvector above this takes part in what it says.
const TAKES_PART: f64 = 0.3;
/// A variable that lies so much in undetermined directions has no standard error (sum of squares).
const MOSTLY: f64 = 0.1;

/// How a fitted parameter stands.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Standing {
    /// Inside its bounds.
    Free,
    /// At its lower bound.
    AtLower,
    /// At its upper bound.
    AtUpper,
    /// The curve does not depend on it: it is as it was.
    Kept,
}

/// A fitted parameter.
#[derive(Clone, Debug, PartialEq)]
pub struct Estimate {
    /// Of which layer, from 0.
    pub layer: usize,
    /// Which of its parameters.
    pub quantity: Quantity,
    /// Its value, in SI.
    pub value: f64,
    /// Its standard error, in the same unit, where the curve determines it.
    pub standard_error: Option<f64>,
    /// Whether it is free or held.
    pub standing: Standing,
}

/// The covariance of the variables that the curve depends on, in their own sizes, and the directions that it does not cover. Those
/// at a bound are among them: a bound must not make certain what shares its effect with them.
struct Spread {
    /// Index of each among all.
    seen: Vec<usize>,
    size: Vec<f64>,
    covariance: DMatrix<f64>,
    /// Undetermined directions.
    blind: Vec<DVector<f64>>,
}

/// Every parameter of every layer.
pub(super) fn estimate(model: &Model<'_>, guess: &Guess) -> Vec<Estimate> {
    let values = Model::variables(&guess.spec);
    let standings = standings(model, guess, &values);
    let spread = spread(model, guess, &standings);
    let mut estimates = Vec::new();
    for (at, layer) in guess.spec.layers.iter().enumerate() {
        for (column, quantity) in VARIABLES.into_iter().enumerate() {
            let variable = at * VARIABLES.len() + column;
            let standard_error = spread.error(&[(variable, 1.0)]);
            let (value, standing) = (values[variable], standings[variable]);
            estimates.push(Estimate { layer: at, quantity, value, standard_error, standing });
        }
        estimates.push(threshold(model, guess, (at, layer), (&spread, Quantity::TipThreshold)));
        if guess.spec.tip_to_rim_m > 0.0 {
            estimates.push(threshold(model, guess, (at, layer), (&spread, Quantity::RimThreshold)));
        }
    }
    estimates
}

/// A threshold P = k w follows from k and the boundary's depth D, and its place is known to within a gap h of the curve:
/// δP = w δk − k δD, and k h/√12 for the place.
fn threshold(
    model: &Model<'_>,
    guess: &Guess,
    (at, layer): (usize, &Layer),
    (spread, quantity): (&Spread, Quantity),
) -> Estimate {
    let (place, value) = match quantity {
        Quantity::RimThreshold => (guess.places.rim[at], layer.rim_rupture_n),
        _ => (guess.places.tip[at], layer.tip_rupture_n),
    };
    let k = layer.stiffness_n_per_m;
    let mut weights = vec![(at * VARIABLES.len() + 1, value / k)];
    weights.extend((0..at).map(|above| (above * VARIABLES.len(), -k)));
    let standard_error = place.and_then(|gap| {
        let place_n = k * model.front.width_m(gap) / 12.0_f64.sqrt();
        spread.error(&weights).map(|fit_n| libm::hypot(fit_n, place_n))
    });
    let standing = if place.is_some() { Standing::Free } else { Standing::Kept };
    Estimate { layer: at, quantity, value, standard_error, standing }
}

/// How each variable stands.
pub(super) fn standings(model: &Model<'_>, guess: &Guess, values: &[f64]) -> Vec<Standing> {
    let jacobian = model.sensitivity(guess);
    let standing = |(variable, &value): (usize, &f64)| {
        let (lower, upper) = VARIABLES[variable % VARIABLES.len()].bounds();
        match jacobian.column(variable).amax() {
            0.0 => Standing::Kept,
            _ if value <= lower => Standing::AtLower,
            _ if value >= upper => Standing::AtUpper,
            _ => Standing::Free,
        }
    };
    values.iter().enumerate().map(standing).collect()
}

fn spread(model: &Model<'_>, guess: &Guess, standings: &[Standing]) -> Spread {
    let seen: Vec<usize> = (0..standings.len()).filter(|&at| standings[at] != Standing::Kept).collect();
    let values = Model::variables(&guess.spec);
    let size: Vec<f64> =
        seen.iter().map(|&at| values[at].abs().max(VARIABLES[at % VARIABLES.len()].least_size())).collect();
    let mut jacobian = model.sensitivity(guess).select_columns(&seen);
    for (mut column, size) in jacobian.column_iter_mut().zip(&size) {
        column *= *size;
    }
    let samples = model.curve.len();
    let squares = residual_rms_n(&guess.spec, model.curve).powi(2) * samples as f64;
    let variance = squares / samples.saturating_sub(seen.len()).max(1) as f64;
    let finest = FINEST_PART * model.curve.peak_n();
    let (mut covariance, mut blind) = (DMatrix::zeros(seen.len(), seen.len()), Vec::new());
    if !seen.is_empty() {
        let eigen = SymmetricEigen::new(jacobian.tr_mul(&jacobian));
        for (value, vector) in eigen.eigenvalues.iter().zip(eigen.eigenvectors.column_iter()) {
            if *value <= variance.max(finest * finest) {
                blind.push(vector.into_owned());
            } else {
                covariance += vector * vector.transpose() * (variance / value);
            }
        }
    }
    Spread { seen, size, covariance, blind }
}

impl Spread {
    /// The standard error of a weighted sum of variables; none where an undetermined direction moves it, or nothing in it is
    /// seen. A variable without effect adds no error.
    fn error(&self, weights: &[(usize, f64)]) -> Option<f64> {
        let mut sum = DVector::zeros(self.seen.len());
        for &(variable, weight) in weights {
            if let Ok(at) = self.seen.binary_search(&variable) {
                sum[at] = weight * self.size[at];
            }
        }
        let hidden: f64 = self.blind.iter().map(|direction| direction.dot(&sum).powi(2)).sum();
        let is_seen = sum.norm_squared() > 0.0 && hidden <= MOSTLY * sum.norm_squared();
        is_seen.then(|| (&self.covariance * &sum).dot(&sum).max(0.0).sqrt())
    }
}

/// The variables that take part in each direction that the curve does not determine.
pub(super) fn undetermined(model: &Model<'_>, guess: &Guess) -> Vec<Vec<usize>> {
    let values = Model::variables(&guess.spec);
    let spread = spread(model, guess, &standings(model, guess, &values));
    let taking_part = |direction: &DVector<f64>| {
        let parts = spread.seen.iter().zip(direction.iter()).filter(|(_, part)| part.abs() > TAKES_PART);
        parts.map(|(&variable, _)| variable).collect()
    };
    spread.blind.iter().map(taking_part).collect()
}
