//! The fitted variables, and what the law makes of them along a curve.
//!
//! A threshold is no variable: the force at a sample jumps when a threshold moves a rupture across it, and no derivative
//! knows of that. The data show directly between which samples a boundary gave way, so a rupture has a *place*, a gap of
//! the curve, and its threshold follows: P = k (x − D) for the tip, P = k (x − L − D) for the rim, x the middle of the
//! gap. With the places held, the residual is continuous in thickness, stiffness, friction and cutting.

use super::curve::Curve;
use super::descent::{Lowest, Problem, square};
use super::drops::Front;
use crate::axial::{self, AxialInput, AxialParams, AxialScratch, AxialSpec, AxialState, Layer};
use crate::closed_form::{self, PredictedRupture};

/// What is fitted of each layer, in the order of the variables.
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
    /// Force at which the tip opens the boundary, in N. It follows from the others and the place of the rupture.
    TipThreshold,
    /// Force at which the rim opens it, in N. It follows likewise.
    RimThreshold,
}

/// The variables of a layer.
pub(super) const VARIABLES: [Quantity; 4] =
    [Quantity::Thickness, Quantity::Stiffness, Quantity::Friction, Quantity::Cutting];

impl Quantity {
    /// Lowest and highest value, and the step of the finite differences. The steps are small beside anything measured
    /// and large beside round-off: the residual is nearly linear in each.
    fn range(self) -> (f64, f64, f64) {
        match self {
            Self::Thickness => (0.0, 0.5, 1e-7),
            Self::Stiffness => (1.0, 1e6, 1e-3),
            Self::Friction => (0.0, 1e4, 1e-3),
            Self::Cutting | Self::TipThreshold | Self::RimThreshold => (0.0, 50.0, 1e-5),
        }
    }

    pub(super) fn bounds(self) -> (f64, f64) {
        let (lower, upper, _) = self.range();
        (lower, upper)
    }

    /// A size below which it is as good as 0 (choice): 1 mm, 10 N/m, 1 N/m, 0.05 N.
    pub(super) fn least_size(self) -> f64 {
        match self {
            Self::Thickness => 1e-3,
            Self::Stiffness => 10.0,
            Self::Friction => 1.0,
            Self::Cutting | Self::TipThreshold | Self::RimThreshold => 0.05,
        }
    }

    /// A value on its lower bound if it is a thousandth of the least size from it, else as it is.
    pub(super) fn on_its_bound(self, value: f64) -> f64 {
        const NEXT_TO: f64 = 1e-3;
        let (lower, _) = self.bounds();
        if value - lower <= NEXT_TO * self.least_size() { lower } else { value }
    }

    fn get(self, layer: &Layer) -> f64 {
        match self {
            Self::Thickness => layer.thickness_m,
            Self::Stiffness => layer.stiffness_n_per_m,
            Self::Friction => layer.friction_n_per_m,
            Self::Cutting => layer.cutting_n,
            Self::TipThreshold => layer.tip_rupture_n,
            Self::RimThreshold => layer.rim_rupture_n,
        }
    }

    fn set(self, layer: &mut Layer, value: f64) {
        match self {
            Self::Thickness => layer.thickness_m = value,
            Self::Stiffness => layer.stiffness_n_per_m = value,
            Self::Friction => layer.friction_n_per_m = value,
            Self::Cutting => layer.cutting_n = value,
            Self::TipThreshold => layer.tip_rupture_n = value,
            Self::RimThreshold => layer.rim_rupture_n = value,
        }
    }
}

/// In which gap of the front each boundary gives way to the tip and to the rim. Where there is none (the rupture is beyond
/// the curve, or hidden in another's cascade) the threshold stays as it is.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Places {
    pub tip: Vec<Option<usize>>,
    pub rim: Vec<Option<usize>>,
}

/// Layers with the places of their ruptures.
#[derive(Clone, Debug)]
pub(super) struct Guess {
    pub spec: AxialSpec,
    pub places: Places,
}

/// A curve with what never changes during its fit.
pub(super) struct Model<'c> {
    pub curve: &'c Curve,
    pub front: Front,
}

/// How strongly an unsound rupture counts: a newton too much counts like ten newtons at every sample.
const UNSOUND_WEIGHT: f64 = 10.0;
/// A rupture must leave this part of force and energy less than it found, so that rounding the result leaves it sound.
const SOUND_MARGIN: f64 = 2e-3;

impl<'c> Model<'c> {
    pub fn new(curve: &'c Curve) -> Self {
        Self { curve, front: Front::new(curve) }
    }

    /// The variables of a specification.
    pub fn variables(spec: &AxialSpec) -> Vec<f64> {
        spec.layers.iter().flat_map(|layer| VARIABLES.map(|quantity| quantity.get(layer))).collect()
    }

    /// The specification that variables stand for, its thresholds put where the places want them.
    pub fn spec(&self, guess: &Guess, variables: &[f64]) -> AxialSpec {
        let mut spec = guess.spec.clone();
        let mut depth_m = 0.0;
        for (at, (layer, values)) in spec.layers.iter_mut().zip(variables.chunks(VARIABLES.len())).enumerate() {
            for (quantity, &value) in VARIABLES.iter().zip(values) {
                quantity.set(layer, value);
            }
            let threshold = |gap: usize, lag_m: f64| {
                layer.stiffness_n_per_m * (self.front.middle_m(gap) - lag_m - depth_m).max(0.0)
            };
            let (tip, rim) = (guess.places.tip[at], guess.places.rim[at]);
            let tip_n = tip.map_or(layer.tip_rupture_n, |gap| threshold(gap, 0.0));
            let rim_n = rim.map_or(layer.rim_rupture_n, |gap| threshold(gap, guess.spec.tip_to_rim_m));
            (layer.tip_rupture_n, layer.rim_rupture_n) = (tip_n, rim_n);
            depth_m += layer.thickness_m;
        }
        spec
    }

    /// The law's force at every sample of the curve.
    pub fn forces(&self, spec: &AxialSpec) -> Vec<f64> {
        forces(spec, self.curve)
    }

    /// Law less data at every sample, in N.
    pub fn misfit(&self, guess: &Guess, variables: &[f64]) -> Vec<f64> {
        let forces = self.forces(&self.spec(guess, variables));
        forces.iter().zip(&self.curve.force_n).map(|(law, data)| law - data).collect()
    }

    /// Goes down from a guess with its places held. Unsound ruptures count as misfit where `sound` is asked for.
    pub fn descend(&self, guess: &Guess, sound: bool, most: u32) -> Lowest {
        let residuals = |variables: &[f64]| self.residuals(guess, variables, sound);
        let (lower, upper, step) = ranges(guess.spec.layers.len());
        let enough = self.as_good_as_none();
        let problem = Problem { residuals: &residuals, lower: &lower, upper: &upper, step: &step, enough };
        problem.descend(&Self::variables(&guess.spec), most)
    }

    /// The sum of squares that a guess has as it stands.
    pub fn cost(&self, guess: &Guess, sound: bool) -> f64 {
        square(&self.residuals(guess, &Self::variables(&guess.spec), sound))
    }

    /// The sum of squares of a millionth of the peak at every sample.
    pub fn as_good_as_none(&self) -> f64 {
        const PART: f64 = 1e-6;
        (PART * self.curve.peak_n()).powi(2) * self.curve.len() as f64
    }

    fn residuals(&self, guess: &Guess, variables: &[f64], sound: bool) -> Vec<f64> {
        let mut residuals = self.misfit(guess, variables);
        if sound {
            let weight = UNSOUND_WEIGHT * (self.curve.len() as f64).sqrt();
            let spec = self.spec(guess, variables);
            residuals.extend(closed_form::ruptures(&spec).iter().map(|rupture| weight * excess_n(rupture)));
        }
        residuals
    }

    /// ∂(law)/∂(variables) at a specification, in N per unit of each.
    pub fn sensitivity(&self, guess: &Guess) -> nalgebra::DMatrix<f64> {
        let residuals = |variables: &[f64]| self.misfit(guess, variables);
        let (lower, upper, step) = ranges(guess.spec.layers.len());
        let problem = Problem { residuals: &residuals, lower: &lower, upper: &upper, step: &step, enough: 0.0 };
        problem.jacobian(&Self::variables(&guess.spec))
    }
}

fn ranges(layers: usize) -> (Vec<f64>, Vec<f64>, Vec<f64>) {
    let all = || (0..layers).flat_map(|_| VARIABLES.map(Quantity::range));
    (all().map(|r| r.0).collect(), all().map(|r| r.1).collect(), all().map(|r| r.2).collect())
}

/// By how much a rupture leaves too much force or energy, in N; energy as the force that would hold it.
fn excess_n(rupture: &PredictedRupture) -> f64 {
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

/// The law along a curve, slowly: one second a sample and no viscosity. Forces in N; 0 where the law refuses the layers.
pub(super) fn forces(spec: &AxialSpec, curve: &Curve) -> Vec<f64> {
    let mut slow = spec.clone();
    slow.rate = None;
    slow.layers.iter_mut().for_each(|layer| layer.damping_n_s_per_m2 = 0.0);
    let Ok(params) = AxialParams::new(slow) else { return vec![0.0; curve.len()] };
    let (mut state, mut scratch) = (AxialState::new(&params), AxialScratch::new(&params));
    let force_n = |(tick, &x_m): (usize, &f64)| {
        let input = AxialInput { t_s: tick as f64, x_m, path_factor: 1.0 };
        axial::step(&params, &mut state, &mut scratch, &input).total_n()
    };
    curve.depth_m.iter().enumerate().map(force_n).collect()
}

/// Root mean square of law less data, in N.
#[must_use]
pub fn residual_rms_n(spec: &AxialSpec, curve: &Curve) -> f64 {
    let forces = forces(spec, curve);
    let squares: f64 = forces.iter().zip(&curve.force_n).map(|(law, data)| (law - data) * (law - data)).sum();
    (squares / curve.len() as f64).sqrt()
}
