//! How far the fitted numbers can be trusted: 95 % intervals by profile likelihood.
//!
//! A number's interval holds every value that the curve does not refuse: the number is held there, everything else is fitted
//! again, and the sum of squares must not rise by more than t² s², s² being the residual variance and t the quantile of a 95 %
//! interval (Venzon & Moolgavkar, "A method for computing profile-likelihood-based confidence intervals", Appl. Stat. 37, 1988).
//! Bounds and bends of the law shape it as they are, where a covariance would be blind to them. Other minima that the curve does not
//! refuse either widen it. A number that is not held to within its own size is not determined and has no interval.

use law::operator::Draw;
use nalgebra::{DMatrix, DVector};

use super::descent::{LeastSquares, Lowest, square};
use super::model::{CurveModel, Guess, OWN, QUANTITIES, Quantity, step_sizes};
use super::peaks::is_another_reading;

/// A residual never speaks for more than this part of the peak (choice): a noise-free curve would make everything exact.
pub(super) const FINEST_PART: f64 = 1e-4;
/// Two-sided 95 % quantile of the normal distribution, and what Student's adds to it for n degrees of freedom, times n.
const NORMAL_95: f64 = 1.96;
const STUDENT: f64 = 2.4;
/// Iterations of a descent with a number held.
const HELD_DESCENT: u32 = 16;
/// How often an edge is tried before the farther side counts.
const EDGE_TRIES: u32 = 7;
/// How close to the quantile an edge is, as a part of it.
const EDGE_PART: f64 = 0.06;
/// A fall of the sum of squares by this many variances with a number held is a better minimum.
const BETTER: f64 = 0.5;
/// How stiffly a number is held: this many deviations of the residual for one of its own.
const HOLD: f64 = 100.0;
/// A variable that the curve does not see spreads this many of its sizes, as far as the first step of a search knows.
const UNSEEN_SIZES: f64 = 10.0;

/// Another reading of the curve's drops is not refused up to this many variances above the fit (choice): four deviations. The fit is
/// the lowest of many readings, and fits the noise the better for it.
const LIKELY: f64 = 16.0;
/// A threshold so much lower is another, and how often the way from 0 to it is halved in search of the least.
const BELOW: f64 = 0.999;
const HALVINGS: u32 = 10;

/// How many deviations wide other starts are drawn.
const DRAWN_DEVIATIONS: f64 = 2.5;

/// How a fitted parameter stands.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ParameterStanding {
    /// Inside its bounds.
    Free,
    /// At its lower bound.
    AtLower,
    /// At its upper bound.
    AtUpper,
    /// The curve does not depend on it: it is as it was.
    Kept,
}

/// A 95 % interval, in SI.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Interval {
    /// Its lower end.
    pub low: f64,
    /// Its upper end.
    pub high: f64,
}

/// A fitted parameter.
#[derive(Clone, Debug, PartialEq)]
pub struct ParameterEstimate {
    /// Of which layer, from 0.
    pub layer: usize,
    /// Which of its parameters.
    pub quantity: Quantity,
    /// Its value, in SI.
    pub value: f64,
    /// Where it lies with 95 % confidence, where the curve determines it and the law describes the curve.
    pub interval: Option<Interval>,
    /// Whether it is free or held.
    pub standing: ParameterStanding,
}

impl Interval {
    /// Whether a value is in it.
    #[must_use]
    pub fn holds(&self, value: f64) -> bool {
        (self.low..=self.high).contains(&value)
    }
}

/// A fit around which numbers are held.
pub(super) struct Profile<'m> {
    model: &'m CurveModel<'m>,
    guess: &'m Guess,
    at: Vec<f64>,
    cost: f64,
    /// Of the residual, in N².
    variance: f64,
    /// Of the variables, as far as they are linear.
    covariance: DMatrix<f64>,
    quantile: f64,
}

/// Another minimum, with the part of the fit's own intervals that is left to it.
pub(super) struct Rival {
    guess: Guess,
    part: f64,
}

/// A distance that was tried, and how far the cost has risen there, as a deviation.
#[derive(Clone, Copy)]
struct Tried {
    way: f64,
    risen: f64,
}

/// What holding a number elsewhere led to.
enum Held {
    /// By how many deviations the sum of squares rose.
    Risen(f64, Vec<f64>),
    /// It fell: these variables are better than the fit.
    Better(Vec<f64>),
}

impl<'m> Profile<'m> {
    pub fn new(model: &'m CurveModel<'m>, guess: &'m Guess) -> Self {
        let at = model.variables(guess);
        let cost = square(&model.residuals(guess, &at, true));
        let jacobian = model.sensitivity(guess);
        let seen = jacobian.column_iter().filter(|column| column.amax() > 0.0).count();
        let freedom = model.curve.len().saturating_sub(seen).max(1) as f64;
        let finest_n = FINEST_PART * model.curve.peak_n();
        let variance = (cost / freedom).max(finest_n * finest_n);
        let covariance = spread(model, guess, &jacobian, variance);
        Self { model, guess, at, cost, variance, covariance, quantile: NORMAL_95 + STUDENT / freedom }
    }

    /// The interval of a number, none where the curve does not hold it to within its size.
    ///
    /// # Errors
    /// Variables that are better than the fit, if the search comes upon them.
    pub fn interval(&self, which: usize) -> Result<Option<Interval>, Vec<f64>> {
        let high = self.edge(which, 1.0)?;
        let low = if high.is_some() { self.edge(which, -1.0)? } else { None };
        Ok(low.zip(high).map(|(low, high)| self.over_cascade(which, self.over_gap(which, Interval { low, high }))))
    }

    /// A threshold's interval down to the least that the curve does not refuse while all else stays: a boundary that opens because
    /// another does opens with it by any lower threshold, down to what it carries before.
    fn over_cascade(&self, which: usize, interval: Interval) -> Interval {
        if which % QUANTITIES.len() < OWN {
            return interval;
        }
        let mut spec = self.model.spec(self.guess, &self.at);
        let mut is_refused = |threshold_n: f64| {
            let layer = &mut spec.layers[which / QUANTITIES.len()];
            QUANTITIES[which % QUANTITIES.len()].set(layer, threshold_n);
            (self.model.cost_of(&spec) - self.cost) / self.variance > self.quantile.powi(2)
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

    /// A threshold's interval over the whole gap that its boundary gives way in. What little tells where in it, the way in which friction
    /// and cutting set in behind, has more than one reading.
    fn over_gap(&self, which: usize, interval: Interval) -> Interval {
        if which % QUANTITIES.len() < OWN {
            return interval;
        }
        let (lower, upper) = self.model.bounds(self.guess);
        let at_end = |end_m: f64| {
            let mut point = self.at.clone();
            point[which] = end_m;
            self.number(&point, which)
        };
        Interval { low: interval.low.min(at_end(lower[which])), high: interval.high.max(at_end(upper[which])) }
    }

    /// A minimum that the curve does not refuse beside the fit; none where it does.
    pub fn rival(&self, guess: Guess, cost: f64) -> Option<Rival> {
        let rise = (cost - self.cost) / self.variance;
        let part = (1.0 - rise / self.quantile.powi(2)).min(1.0);
        let part = if self.is_another(&guess, cost) { 1.0 } else { part.max(0.0).sqrt() };
        (part > 0.0).then_some(Rival { guess, part })
    }

    /// Whether a guess of a sum of squares reads the curve otherwise than the fit, and is not refused.
    pub fn is_another(&self, guess: &Guess, cost: f64) -> bool {
        let is_like = guess.spec.layers.len() == self.guess.spec.layers.len();
        let is_likely = is_like && (cost - self.cost) / self.variance <= LIKELY;
        is_likely && is_another_reading(self.model, self.guess, guess)
    }

    /// A fit's interval with those of other minima that the curve does not refuse; none where all of them together are wider than
    /// the number.
    pub fn widen(&self, which: usize, interval: Interval, rivals: &[Rival]) -> Option<Interval> {
        let here = self.number(&self.at, which);
        let (lower, upper) = QUANTITIES[which % QUANTITIES.len()].bounds();
        let mut wide = interval;
        for Rival { guess, part } in rivals {
            let there = number(self.model, guess, which);
            wide.low = wide.low.min(there - part * (here - interval.low)).max(lower);
            wide.high = wide.high.max(there + part * (interval.high - here)).min(upper);
        }
        (wide.high - wide.low <= 2.0 * size(which, here)).then_some(wide)
    }

    /// Variables drawn from the covariance, none farther away than its size: other starts along the valley that the fit lies in.
    pub fn draw(&self, draw: &mut Draw) -> Vec<f64> {
        let (lower, upper) = self.model.bounds(self.guess);
        let Some(factor) = self.covariance.clone().cholesky() else { return self.at.clone() };
        let normal = DVector::from_fn(self.at.len(), |_, _| draw.normal(DRAWN_DEVIATIONS));
        let moved = |(which, by): (usize, &f64)| {
            let most = if which % QUANTITIES.len() < OWN { size(which, self.at[which]) } else { f64::INFINITY };
            (self.at[which] + by.max(-most).min(most)).max(lower[which]).min(upper[which])
        };
        (factor.l() * normal).iter().enumerate().map(moved).collect()
    }

    /// How far up or down a number may go.
    fn edge(&self, which: usize, sign: f64) -> Result<Option<f64>, Vec<f64>> {
        let here = self.number(&self.at, which);
        let (lower, upper) = QUANTITIES[which % QUANTITIES.len()].bounds();
        let room = if sign > 0.0 { upper - here } else { here - lower };
        let reach = room.min(size(which, here));
        let slope = self.slope(which);
        let deviation = self.deviation(&slope);
        let (mut near, mut far) = (Tried { way: 0.0, risen: 0.0 }, None);
        let mut way = (self.quantile * deviation).max(1e-9 * size(which, here));
        let mut from = self.at.clone();
        for _ in 0..EDGE_TRIES {
            way = way.min(reach);
            let risen = match self.hold(which, here + sign * way, &slope, &from) {
                Held::Risen(risen, point) => {
                    from = point;
                    risen
                }
                Held::Better(variables) => return Err(variables),
            };
            if risen < self.quantile {
                if way >= reach {
                    return Ok((reach >= room).then_some(here + sign * room));
                }
                near = Tried { way, risen };
            } else {
                far = Some(Tried { way, risen });
            }
            if (risen - self.quantile).abs() <= EDGE_PART * self.quantile {
                break;
            }
            way = self.next_way(near, far);
        }
        // Not found in so many tries: the farther side counts.
        let settled = far.map_or(near.way, |far| {
            if far.risen <= self.quantile * (1.0 + EDGE_PART) { self.next_way(near, Some(far)) } else { far.way }
        });
        Ok(Some(here + sign * settled))
    }

    /// Standard deviation of a number with this slope.
    fn deviation(&self, slope: &DVector<f64>) -> f64 {
        (&self.covariance * slope).dot(slope).max(0.0).sqrt()
    }

    /// Between a point that is not refused and one that is; farther out while there is none.
    fn next_way(&self, near: Tried, far: Option<Tried>) -> f64 {
        match far {
            None => near.way * (1.05 * self.quantile / near.risen.max(1e-9)).clamp(1.3, 4.0),
            Some(far) => {
                let part = (self.quantile - near.risen) / (far.risen - near.risen).max(1e-9);
                near.way + (far.way - near.way) * part.clamp(0.1, 0.9)
            }
        }
    }

    /// Fits everything again with a number held at a target, starting where the covariance says from a point of before.
    fn hold(&self, which: usize, target: f64, slope: &DVector<f64>, from: &[f64]) -> Held {
        let deviation = self.deviation(slope);
        let along = &self.covariance * slope / deviation.powi(2).max(f64::MIN_POSITIVE);
        let by = target - self.number(from, which);
        let start: Vec<f64> = from.iter().zip(along.iter()).map(|(value, along)| value + by * along).collect();
        let weight = HOLD * self.variance.sqrt() / deviation.max(1e-12);
        let residuals = |variables: &[f64]| {
            let mut residuals = self.model.residuals(self.guess, variables, true);
            residuals.push(weight * (self.number(variables, which) - target));
            residuals
        };
        let ((lower, upper), step) = (self.model.bounds(self.guess), step_sizes(self.guess));
        let problem = LeastSquares { residuals: &residuals, lower: &lower, upper: &upper, step: &step, enough: 0.0 };
        let held = |start: &[f64]| {
            // With what holds the number: where the rest cannot follow it is not held, and that must cost.
            let Lowest { at, cost, .. } = problem.descend(start, HELD_DESCENT);
            ((cost - self.cost) / self.variance, at)
        };
        let (mut rise, mut at) = held(&start);
        if rise > self.quantile.powi(2) {
            // A bend behind a rupture may hold it back: from the middle of the gaps it may get by.
            let (again, there) = held(&self.in_the_middle(&start));
            (rise, at) = if again < rise { (again, there) } else { (rise, at) };
        }
        if rise < -BETTER { Held::Better(at) } else { Held::Risen(rise.max(0.0).sqrt(), at) }
    }

    /// The same variables with every rupture in the middle of its gap.
    fn in_the_middle(&self, variables: &[f64]) -> Vec<f64> {
        let (lower, upper) = self.model.bounds(self.guess);
        let middle = |(which, &value): (usize, &f64)| match which % QUANTITIES.len() < OWN {
            true => value,
            false => 0.5 * (lower[which] + upper[which]),
        };
        variables.iter().enumerate().map(middle).collect()
    }

    fn number(&self, variables: &[f64], which: usize) -> f64 {
        self.model.number(self.guess, variables, which)
    }

    /// ∂(number)/∂(variables).
    fn slope(&self, which: usize) -> DVector<f64> {
        let here = self.number(&self.at, which);
        let of = |(variable, step): (usize, &f64)| {
            let mut point = self.at.clone();
            point[variable] += step;
            (self.number(&point, which) - here) / (point[variable] - self.at[variable])
        };
        DVector::from_iterator(self.at.len(), step_sizes(self.guess).iter().enumerate().map(of))
    }
}

/// s² (JᵀJ)⁻¹ of the variables with an effect; each is also known to within some of its sizes, a place to within its gap.
fn spread(model: &CurveModel<'_>, guess: &Guess, jacobian: &DMatrix<f64>, variance: f64) -> DMatrix<f64> {
    let (lower, upper) = model.bounds(guess);
    let at = model.variables(guess);
    let known = |which: usize| match which % QUANTITIES.len() < OWN {
        true => UNSEEN_SIZES * size(which, at[which]),
        false => ((upper[which] - lower[which]) / 12.0_f64.sqrt()).max(1e-12),
    };
    let sizes = DVector::from_iterator(at.len(), (0..at.len()).map(known));
    let mut scaled = jacobian.clone();
    for (mut column, size) in scaled.column_iter_mut().zip(sizes.iter()) {
        column *= *size;
    }
    let normal = scaled.tr_mul(&scaled) + DMatrix::identity(at.len(), at.len()) * variance;
    let inverse = normal.cholesky().map_or_else(|| DMatrix::identity(at.len(), at.len()), |factor| factor.inverse());
    let diagonal = DMatrix::from_diagonal(&sizes);
    &diagonal * inverse * &diagonal * variance
}

/// The size that a number is judged by.
fn size(which: usize, value: f64) -> f64 {
    value.abs().max(QUANTITIES[which % QUANTITIES.len()].least_size())
}

/// A number of a guess.
fn number(model: &CurveModel<'_>, guess: &Guess, which: usize) -> f64 {
    model.number(guess, &model.variables(guess), which)
}

/// Every parameter of every layer, without an interval where `interval` gives none.
///
/// # Errors
/// What `interval` fails with.
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

/// How each number stands.
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
