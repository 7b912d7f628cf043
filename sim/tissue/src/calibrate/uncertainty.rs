//! Confidence in the fitted parameters: 95 % intervals by profile likelihood.
//!
//! A parameter's interval contains every value that the curve does not reject: the parameter is
//! held there, all others are fitted again, and the sum of squares must not rise by more than t²
//! s², s² being the residual variance and t the quantile of a 95 % interval (Venzon & Moolgavkar,
//! "A method for computing profile-likelihood-based confidence intervals", Appl. Stat. 37, 1988).
//! Bounds and bends of the law shape the interval, which a covariance would ignore. Other minima
//! that the curve does not reject widen it. A parameter that is not determined to within its own
//! size has no interval.

use law::operator::Draw;
use nalgebra::DVector;

use super::model::{CurveModel, Guess, OWN, QUANTITIES, Quantity, step_sizes};
use super::peaks::is_another_reading;
use super::profile::{FitStatistics, Likelihood, Profiled};

/// Variances above the fit up to which another interpretation of the curve's drops is not rejected
/// (choice): four deviations. The fit is the lowest of many interpretations, and fits the noise the
/// better for it.
const LIKELY: f64 = 16.0;
/// A threshold lower by this factor is a different one; number of bisections between 0 and it in
/// search of the lowest.
const BELOW: f64 = 0.999;
const HALVINGS: u32 = 10;

/// Width, in deviations, from which other starts are drawn.
const DRAWN_DEVIATIONS: f64 = 2.5;

/// Status of a fitted parameter.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ParameterStanding {
    /// Inside its bounds.
    Free,
    /// At its lower bound.
    AtLower,
    /// At its upper bound.
    AtUpper,
    /// The curve does not depend on it: it keeps its starting value.
    Kept,
}

/// A 95 % interval, in SI units.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Interval {
    /// Lower end.
    pub low: f64,
    /// Upper end.
    pub high: f64,
}

/// A fitted parameter.
#[derive(Clone, Debug, PartialEq)]
pub struct ParameterEstimate {
    /// Index of the layer, from 0.
    pub layer: usize,
    /// The parameter.
    pub quantity: Quantity,
    /// Value, in SI units.
    pub value: f64,
    /// The 95 % confidence interval, if the curve determines the parameter and the law describes
    /// the curve.
    pub interval: Option<Interval>,
    /// Whether it is free, at a bound, or kept.
    pub standing: ParameterStanding,
}

impl Interval {
    /// Whether a value lies in the interval.
    #[must_use]
    pub fn holds(&self, value: f64) -> bool {
        (self.low..=self.high).contains(&value)
    }
}

/// A fit around which parameters are held.
pub(super) struct Profile<'m> {
    model: &'m CurveModel<'m>,
    guess: &'m Guess,
    likelihood: Likelihood<PlacedGuess<'m>>,
}

/// A guess whose places are held.
struct PlacedGuess<'m> {
    model: &'m CurveModel<'m>,
    guess: &'m Guess,
}

impl Profiled for PlacedGuess<'_> {
    fn residuals(&self, variables: &[f64]) -> Vec<f64> {
        self.model.residuals(self.guess, variables, true)
    }

    fn bounds(&self) -> (Vec<f64>, Vec<f64>) {
        self.model.bounds(self.guess)
    }

    fn steps(&self) -> Vec<f64> {
        step_sizes(self.guess)
    }

    fn number(&self, variables: &[f64], which: usize) -> f64 {
        self.model.number(self.guess, variables, which)
    }

    fn quantity(&self, which: usize) -> Quantity {
        QUANTITIES[which % QUANTITIES.len()]
    }

    fn is_place(&self, which: usize) -> bool {
        which % QUANTITIES.len() >= OWN
    }
}

/// Another minimum, with the fraction of the fit's own intervals that applies to it.
pub(super) struct Rival {
    guess: Guess,
    part: f64,
}

impl<'m> Profile<'m> {
    pub fn new(model: &'m CurveModel<'m>, guess: &'m Guess) -> Self {
        let jacobian = model.sensitivity(guess);
        let statistics =
            FitStatistics { jacobian: &jacobian, samples: model.curve.len(), peak_n: model.curve.peak_n() };
        let likelihood = Likelihood::new(PlacedGuess { model, guess }, model.variables(guess), &statistics);
        Self { model, guess, likelihood }
    }

    /// The interval of a parameter; `None` if the curve does not determine it to within its size.
    ///
    /// # Errors
    /// Variables better than the fit, if the search finds them.
    pub fn interval(&self, which: usize) -> Result<Option<Interval>, Vec<f64>> {
        Ok(self
            .likelihood
            .interval(which)
            .map_err(|better| better.at)?
            .map(|interval| self.over_cascade(which, interval)))
    }

    /// Extends a threshold's interval down to the lowest value that the curve does not reject while
    /// all others stay: a boundary that opens in the cascade of another also opens with any lower
    /// threshold, down to the load it bears before.
    fn over_cascade(&self, which: usize, interval: Interval) -> Interval {
        if which % QUANTITIES.len() < OWN {
            return interval;
        }
        let Likelihood { at, cost, variance, quantile, .. } = &self.likelihood;
        let mut spec = self.model.spec(self.guess, at);
        let mut is_refused = |threshold_n: f64| {
            let layer = &mut spec.layers[which / QUANTITIES.len()];
            QUANTITIES[which % QUANTITIES.len()].set(layer, threshold_n);
            (self.model.cost_of(&spec) - cost) / variance > quantile.powi(2)
        };
        if is_refused(BELOW * interval.low) {
            return interval;
        }
        let (mut refused, mut low) = (0.0, BELOW * interval.low);
        for _ in 0..HALVINGS {
            let middle = 0.5 * (refused + low);
            *if is_refused(middle) { &mut refused } else { &mut low } = middle;
        }
        Interval { low, ..interval }
    }

    /// Another minimum that the curve does not reject; `None` if it rejects it.
    pub fn rival(&self, guess: Guess, cost: f64) -> Option<Rival> {
        let rise = (cost - self.likelihood.cost) / self.likelihood.variance;
        let part = (1.0 - rise / self.likelihood.quantile.powi(2)).min(1.0);
        let part = if self.is_another(&guess, cost) { 1.0 } else { part.max(0.0).sqrt() };
        (part > 0.0).then_some(Rival { guess, part })
    }

    /// Whether a guess with this sum of squares interprets the curve differently from the fit, and
    /// is not rejected.
    pub fn is_another(&self, guess: &Guess, cost: f64) -> bool {
        let is_like = guess.spec.layers.len() == self.guess.spec.layers.len();
        let is_likely = is_like && (cost - self.likelihood.cost) / self.likelihood.variance <= LIKELY;
        is_likely && is_another_reading(self.model, self.guess, guess)
    }

    /// A fit's interval, extended by those of other minima that the curve does not reject; `None`
    /// if their union is wider than the parameter.
    pub fn widen(&self, which: usize, interval: Interval, rivals: &[Rival]) -> Option<Interval> {
        let here = self.likelihood.number(&self.likelihood.at, which);
        let (lower, upper) = QUANTITIES[which % QUANTITIES.len()].bounds();
        let mut wide = interval;
        for Rival { guess, part } in rivals {
            let there = number(self.model, guess, which);
            wide.low = wide.low.min(there - part * (here - interval.low)).max(lower);
            wide.high = wide.high.max(there + part * (interval.high - here)).min(upper);
        }
        self.likelihood.is_determined(which, wide).then_some(wide)
    }

    /// Draws variables from the covariance, none farther away than its size: other starts along the
    /// valley of the fit.
    pub fn draw(&self, draw: &mut Draw) -> Vec<f64> {
        let (lower, upper) = self.model.bounds(self.guess);
        let Likelihood { at, covariance, .. } = &self.likelihood;
        let Some(factor) = covariance.clone().cholesky() else { return at.clone() };
        let normal = DVector::from_fn(at.len(), |_, _| draw.normal(DRAWN_DEVIATIONS));
        let moved = |(which, by): (usize, &f64)| {
            let most =
                if which % QUANTITIES.len() < OWN { self.likelihood.size(which, at[which]) } else { f64::INFINITY };
            (at[which] + by.max(-most).min(most)).max(lower[which]).min(upper[which])
        };
        (factor.l() * normal).iter().enumerate().map(moved).collect()
    }
}

/// A parameter of a guess.
fn number(model: &CurveModel<'_>, guess: &Guess, which: usize) -> f64 {
    model.number(guess, &model.variables(guess), which)
}

/// Every parameter of every layer, without an interval if `interval` returns none.
///
/// # Errors
/// The error of `interval`.
pub(super) fn estimate_parameters<E>(
    model: &CurveModel<'_>,
    guess: &Guess,
    interval: &mut dyn FnMut(usize) -> Result<Option<Interval>, E>,
) -> Result<Vec<ParameterEstimate>, E> {
    let standings = find_standings(model, guess);
    let mut estimates = Vec::with_capacity(standings.len());
    for (which, &standing) in standings.iter().enumerate() {
        let (layer, quantity) = (which / QUANTITIES.len(), QUANTITIES[which % QUANTITIES.len()]);
        if quantity == Quantity::RimThreshold && guess.spec.tip_to_rim_m <= 0.0 {
            continue;
        }
        let interval = if standing == ParameterStanding::Kept { None } else { interval(which)? };
        estimates.push(ParameterEstimate { layer, quantity, value: number(model, guess, which), interval, standing });
    }
    Ok(estimates)
}

/// The status of each parameter.
pub(super) fn find_standings(model: &CurveModel<'_>, guess: &Guess) -> Vec<ParameterStanding> {
    let jacobian = model.sensitivity(guess);
    let variables = model.variables(guess);
    let standing = |(which, &value): (usize, &f64)| {
        let quantity = QUANTITIES[which % QUANTITIES.len()];
        let (lower, upper) = quantity.bounds();
        if which % QUANTITIES.len() >= OWN {
            let placed = guess.places.place_of(which / QUANTITIES.len(), quantity);
            return placed.map_or(ParameterStanding::Kept, |_| ParameterStanding::Free);
        }
        match jacobian.column(which).amax() {
            0.0 => ParameterStanding::Kept,
            _ if value <= lower => ParameterStanding::AtLower,
            _ if value >= upper => ParameterStanding::AtUpper,
            _ => ParameterStanding::Free,
        }
    };
    variables.iter().enumerate().map(standing).collect()
}
