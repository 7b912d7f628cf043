//! The fitted variables, and the law's force for them along a curve.
//!
//! A threshold is not a variable: the force at a sample jumps when a threshold moves a rupture
//! across it, and no derivative represents that. The data show directly between which samples a
//! boundary ruptured, so a rupture has a *place*, a gap of the curve, and its position x within the
//! gap is the variable; the threshold follows: P = k (x − D) for the tip, P = k (x − L − D) for the
//! rim. With the places held, the residual is continuous in every variable, and no finite
//! difference straddles a drop.

use law::axial::{AxialSpec, Layer};
use law::closed_form::{self, PredictedRupture};
use law::quasistatic::quasistatic_forces_n;
use nalgebra::DMatrix;

use super::curve::Curve;
use super::descent::{LeastSquares, Lowest, square};
use super::drops::Front;

/// The fitted quantities of each layer, in the order of the variables.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Quantity {
    /// Thickness, in m.
    Thickness,
    /// Stiffness of the layer's boundary, in N/m.
    Stiffness,
    /// Friction cap per inserted length, in N/m.
    Friction,
    /// Cutting force, in N.
    Cutting,
    /// Force at which the tip opens the boundary, in N. Follows from the other quantities and the
    /// position of the rupture.
    TipThreshold,
    /// Force at which the rim opens it, in N. Follows in the same way.
    RimThreshold,
    /// κ of a tent that stiffens, in N/m². This and the following quantities are only fitted to
    /// timed curves.
    Stiffening,
    /// Friction cap per inserted length before breakaway of the shaft, in N/m.
    StaticFriction,
    /// Stiffness of a branch, numbered from 0, as a share of the boundary's.
    BranchShare(usize),
    /// Time constant of a branch, numbered from 0, in s.
    BranchTime(usize),
    /// Damping per inserted length, in N·s/m²: visible when a needle slows or stops.
    Damping,
    /// Presliding stiffness of the needle, in N/m; belongs to no layer.
    Presliding,
    /// Slid length at which static friction gives way, in m; belongs to no layer.
    Breakaway,
}

/// A layer's quantities in the order of its variables. The variables of the thresholds are the
/// positions of the ruptures, in m.
pub const QUANTITIES: [Quantity; 6] = [
    Quantity::Thickness,
    Quantity::Stiffness,
    Quantity::Friction,
    Quantity::Cutting,
    Quantity::TipThreshold,
    Quantity::RimThreshold,
];
/// Number of quantities that are variables themselves.
pub(super) const OWN: usize = 4;
/// Minimum distance of a rupture from a sample, in gaps: the place decides on which side of the
/// sample it lies.
pub(super) const EDGE: f64 = 0.05;

impl Quantity {
    /// Lowest and highest value, and the step of the finite differences. The steps are small
    /// compared with any measured value and large compared with round-off: the residual is nearly
    /// linear in each.
    fn range(self) -> (f64, f64, f64) {
        match self {
            Self::Thickness => (0.0, 0.5, 1e-8),
            Self::Stiffness => (1.0, 1e6, 1e-4),
            Self::Friction => (0.0, 2e3, 1e-4),
            Self::Cutting => (0.0, 50.0, 1e-6),
            Self::TipThreshold | Self::RimThreshold => (0.0, 50.0, 1e-8),
            Self::Stiffening => (0.0, 1e8, 1e-2),
            Self::StaticFriction => (0.0, 4e3, 1e-4),
            Self::BranchShare(_) => (1e-3, 1e2, 1e-7),
            Self::BranchTime(_) => (1e-3, 1e3, 1e-7),
            Self::Damping => (0.0, 1e6, 1e-2),
            Self::Breakaway => (1e-5, 0.1, 1e-8),
            Self::Presliding => (1.0, 1e6, 1e-4),
        }
    }

    /// Step of the finite differences.
    pub(super) fn step(self) -> f64 {
        self.range().2
    }

    pub(super) fn bounds(self) -> (f64, f64) {
        let (lower, upper, _) = self.range();
        (lower, upper)
    }

    /// A size below which it counts as 0 (choice): 1 mm, 10 N/m, 1 N/m, 0.05 N; 100 N/m², a
    /// twentieth, 50 ms; 100 N·s/m², 0.1 mm of sliding.
    pub(super) fn least_size(self) -> f64 {
        match self {
            Self::Thickness => 1e-3,
            Self::Stiffness | Self::Presliding => 10.0,
            Self::Friction | Self::StaticFriction => 1.0,
            Self::Stiffening | Self::Damping => 100.0,
            Self::Breakaway => 1e-4,
            Self::BranchShare(_) | Self::BranchTime(_) => 0.05,
            Self::Cutting | Self::TipThreshold | Self::RimThreshold => 0.05,
        }
    }

    /// Returns the lower bound for a value within a thousandth of the least size from it, otherwise
    /// the value.
    pub(super) fn on_its_bound(self, value: f64) -> f64 {
        const NEXT_TO: f64 = 1e-3;
        let (lower, _) = self.bounds();
        if value - lower <= NEXT_TO * self.least_size() { lower } else { value }
    }

    /// Its value in a layer, in SI units; 0 if the layer has none.
    #[must_use]
    pub fn get(self, layer: &Layer) -> f64 {
        match self {
            Self::Thickness => layer.thickness_m,
            Self::Stiffness => layer.stiffness_n_per_m,
            Self::Friction => layer.friction_n_per_m,
            Self::Cutting => layer.cutting_n,
            Self::TipThreshold => layer.tip_rupture_n,
            Self::RimThreshold => layer.rim_rupture_n,
            Self::Stiffening => layer.options.stiffening_n_per_m2,
            Self::StaticFriction => layer.static_friction_n_per_m(),
            Self::BranchShare(at) => layer.options.branches.get(at).map_or(0.0, |branch| branch.share),
            Self::BranchTime(at) => layer.options.branches.get(at).map_or(0.0, |branch| branch.time_s),
            Self::Damping => layer.damping_n_s_per_m2,
            Self::Presliding | Self::Breakaway => 0.0,
        }
    }

    pub(super) fn set(self, layer: &mut Layer, value: f64) {
        match self {
            Self::Thickness => layer.thickness_m = value,
            Self::Stiffness => layer.stiffness_n_per_m = value,
            Self::Friction => layer.friction_n_per_m = value,
            Self::Cutting => layer.cutting_n = value,
            Self::TipThreshold => layer.tip_rupture_n = value,
            Self::RimThreshold => layer.rim_rupture_n = value,
            Self::Stiffening => layer.options.stiffening_n_per_m2 = value,
            Self::StaticFriction => layer.options.static_friction_n_per_m = Some(value),
            Self::BranchShare(at) => {
                if let Some(branch) = layer.options.branches.get_mut(at) {
                    branch.share = value;
                }
            }
            Self::BranchTime(at) => {
                if let Some(branch) = layer.options.branches.get_mut(at) {
                    branch.time_s = value;
                }
            }
            Self::Damping => layer.damping_n_s_per_m2 = value,
            Self::Presliding | Self::Breakaway => {}
        }
    }

    /// Distance behind the tip of the contactor whose rupture the threshold belongs to, in m.
    fn lag_m(self, spec: &AxialSpec) -> Option<f64> {
        match self {
            Self::TipThreshold => Some(0.0),
            Self::RimThreshold => Some(spec.tip_to_rim_m),
            _ => None,
        }
    }
}

/// The gap of the front in which each boundary ruptures under the tip and under the rim. `None`
/// (the rupture lies beyond the curve, or is hidden in the cascade of another) keeps the threshold.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Places {
    pub tip: Vec<Option<usize>>,
    pub rim: Vec<Option<usize>>,
}

impl Places {
    /// The place that determines a threshold.
    pub fn place_of(&self, layer: usize, quantity: Quantity) -> Option<usize> {
        match quantity {
            Quantity::TipThreshold => self.tip.get(layer).copied().flatten(),
            Quantity::RimThreshold => self.rim.get(layer).copied().flatten(),
            _ => None,
        }
    }
}

/// Layers with the places of their ruptures.
#[derive(Clone, Debug)]
pub(super) struct Guess {
    pub spec: AxialSpec,
    pub places: Places,
}

/// A curve with its data that are constant during the fit.
pub(super) struct CurveModel<'c> {
    pub curve: &'c Curve,
    pub front: Front,
}

/// Weight of an unsound rupture: an excess of one newton counts like ten newtons at every sample.
pub(super) const UNSOUND_WEIGHT: f64 = 10.0;
/// Fraction of force and energy that a rupture must remove, so that rounding the result leaves it
/// sound.
const SOUND_MARGIN: f64 = 2e-3;

impl<'c> CurveModel<'c> {
    pub fn new(curve: &'c Curve) -> Self {
        Self { curve, front: Front::new(curve) }
    }

    /// The variables of a guess, layer by layer.
    pub fn variables(&self, guess: &Guess) -> Vec<f64> {
        let mut depth_m = 0.0;
        let mut variables = Vec::with_capacity(guess.spec.layers.len() * QUANTITIES.len());
        for (at, layer) in guess.spec.layers.iter().enumerate() {
            for quantity in QUANTITIES {
                let value = quantity.get(layer);
                variables.push(match (quantity.lag_m(&guess.spec), guess.places.place_of(at, quantity)) {
                    (None, _) => value,
                    (Some(_), None) => 0.0,
                    (Some(lag_m), Some(gap)) => {
                        let (low_m, high_m) = self.within(gap);
                        (lag_m + depth_m + value / layer.stiffness_n_per_m).max(low_m).min(high_m)
                    }
                });
            }
            depth_m += layer.thickness_m;
        }
        variables
    }

    /// The specification for given variables, with the thresholds that the places determine.
    pub fn spec(&self, guess: &Guess, variables: &[f64]) -> AxialSpec {
        let mut spec = guess.spec.clone();
        let mut depth_m = 0.0;
        for (at, values) in variables.chunks(QUANTITIES.len()).enumerate() {
            for (quantity, &value) in QUANTITIES.iter().zip(values) {
                let threshold_n = quantity.lag_m(&spec).map(|lag_m| values[1] * (value - lag_m - depth_m).max(0.0));
                let number = threshold_n.map_or(Some(value), |n| guess.places.place_of(at, *quantity).map(|_| n));
                if let (Some(layer), Some(number)) = (spec.layers.get_mut(at), number) {
                    quantity.set(layer, number);
                }
            }
            depth_m += values[0];
        }
        spec
    }

    /// The value of a parameter for given variables: thresholds are not variables themselves.
    pub fn number(&self, guess: &Guess, variables: &[f64], which: usize) -> f64 {
        let (at, quantity) = (which / QUANTITIES.len(), QUANTITIES[which % QUANTITIES.len()]);
        let values = &variables[at * QUANTITIES.len()..];
        let depth_m = || variables[..at * QUANTITIES.len()].iter().step_by(QUANTITIES.len()).sum::<f64>();
        match (quantity.lag_m(&guess.spec), guess.places.place_of(at, quantity)) {
            (None, _) => variables[which],
            (Some(_), None) => quantity.get(&guess.spec.layers[at]),
            (Some(lag_m), Some(_)) => values[1] * (variables[which] - lag_m - depth_m()).max(0.0),
        }
    }

    /// The law's force at every sample of the curve.
    pub fn forces(&self, spec: &AxialSpec) -> Vec<f64> {
        quasistatic_forces_n(spec, &self.curve.depth_m)
    }

    /// Law minus data at every sample, in N.
    pub fn misfit(&self, guess: &Guess, variables: &[f64]) -> Vec<f64> {
        let forces = self.forces(&self.spec(guess, variables));
        forces.iter().zip(&self.curve.force_n).map(|(law, data)| law - data).collect()
    }

    /// Descends from a guess with its places held. Unsound ruptures count as misfit if `sound` is
    /// set.
    pub fn descend(&self, guess: &Guess, sound: bool, most: u32) -> Lowest {
        let residuals = |variables: &[f64]| self.residuals(guess, variables, sound);
        let (lower, upper) = self.bounds(guess);
        let step = step_sizes(guess);
        let enough = self.as_good_as_none();
        let problem = LeastSquares { residuals: &residuals, lower: &lower, upper: &upper, step: &step, enough };
        problem.descend(&self.variables(guess), most)
    }

    /// The sum of squares of a guess, without fitting it.
    pub fn cost(&self, guess: &Guess, sound: bool) -> f64 {
        square(&self.residuals(guess, &self.variables(guess), sound))
    }

    /// The sum of squares of a specification.
    pub fn cost_of(&self, spec: &AxialSpec) -> f64 {
        self.forces(spec).iter().zip(&self.curve.force_n).map(|(law, data)| (law - data) * (law - data)).sum()
    }

    /// The sum of squares of a millionth of the peak at every sample.
    pub fn as_good_as_none(&self) -> f64 {
        const PART: f64 = 1e-6;
        (PART * self.curve.peak_n()).powi(2) * self.curve.len() as f64
    }

    /// Law minus data at every sample, in N, followed by the soundness residuals if `sound` is set.
    pub fn residuals(&self, guess: &Guess, variables: &[f64], sound: bool) -> Vec<f64> {
        let mut residuals = self.misfit(guess, variables);
        if sound {
            let weight = UNSOUND_WEIGHT * (self.curve.len() as f64).sqrt();
            let spec = self.spec(guess, variables);
            residuals.extend(closed_form::predict_ruptures(&spec).iter().map(|rupture| weight * excess_n(rupture)));
        }
        residuals
    }

    /// ∂(law)/∂(variables) at a specification, in N per unit of each.
    pub fn sensitivity(&self, guess: &Guess) -> DMatrix<f64> {
        let residuals = |variables: &[f64]| self.misfit(guess, variables);
        let ((lower, upper), step) = (self.bounds(guess), step_sizes(guess));
        let problem = LeastSquares { residuals: &residuals, lower: &lower, upper: &upper, step: &step, enough: 0.0 };
        let at = self.variables(guess);
        problem.jacobian(&at, &residuals(&at))
    }

    /// Lowest and highest value of every variable. Both are 0 for an entry that is not a variable
    /// here.
    pub fn bounds(&self, guess: &Guess) -> (Vec<f64>, Vec<f64>) {
        let range = |which: usize| {
            let quantity = QUANTITIES[which % QUANTITIES.len()];
            match (quantity.lag_m(&guess.spec), guess.places.place_of(which / QUANTITIES.len(), quantity)) {
                (None, _) => quantity.bounds(),
                (Some(_), None) => (0.0, 0.0),
                (Some(_), Some(gap)) => self.within(gap),
            }
        };
        (0..guess.spec.layers.len() * QUANTITIES.len()).map(range).unzip()
    }

    /// Bounds of a rupture with this place, in m.
    fn within(&self, gap: usize) -> (f64, f64) {
        let edge_m = EDGE * self.front.width_m(gap);
        (self.front.depth_m[gap] + edge_m, self.front.depth_m[gap + 1] - edge_m)
    }
}

/// Steps of the finite differences.
pub(super) fn step_sizes(guess: &Guess) -> Vec<f64> {
    guess.spec.layers.iter().flat_map(|_| QUANTITIES.map(|quantity| quantity.range().2)).collect()
}

/// Excess of force or energy after a rupture, in N; energy as the force that would hold it.
pub(super) fn excess_n(rupture: &PredictedRupture) -> f64 {
    let allowed = 1.0 - SOUND_MARGIN;
    let force_n = rupture.force_after_n - allowed * rupture.force_before_n;
    let energy_n = match rupture.energy_before_j > 0.0 {
        true => {
            let root = (rupture.energy_after_j / rupture.energy_before_j).sqrt();
            rupture.force_before_n * (root - allowed)
        }
        false => rupture.force_after_n,
    };
    force_n.max(energy_n).max(0.0)
}

/// Root mean square of law minus data, in N.
#[must_use]
pub fn residual_rms_n(spec: &AxialSpec, curve: &Curve) -> f64 {
    let forces = quasistatic_forces_n(spec, &curve.depth_m);
    let squares: f64 = forces.iter().zip(&curve.force_n).map(|(law, data)| (law - data) * (law - data)).sum();
    (squares / curve.len() as f64).sqrt()
}
