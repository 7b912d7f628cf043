//! Interval of a parameter by profile likelihood, for any least-squares fit: the parameter is held
//! and all others are fitted again.

use nalgebra::{DMatrix, DVector};

use super::descent::{LeastSquares, square};
use super::model::Quantity;
use super::uncertainty::Interval;

/// Lower bound of the residual's deviation, as a fraction of the peak (choice): a noise-free curve
/// would otherwise make every parameter exact.
pub(super) const FINEST_PART: f64 = 1e-4;
/// Two-sided 95 % quantile of the normal distribution, and the increase of Student's for n degrees
/// of freedom, times n.
const NORMAL_95: f64 = 1.96;
const STUDENT: f64 = 2.4;
/// Iterations of a descent with one parameter held.
const HELD_DESCENT: u32 = 40;
/// Attempts to find an edge before the farther bracket counts.
const EDGE_TRIES: u32 = 10;
/// A cost that has risen by this many quantiles is no basis for interpolation.
const STEEP: f64 = 3.0;
/// Tolerance of an edge, as a fraction of the quantile.
const EDGE_PART: f64 = 0.06;
/// Decrease of the sum of squares, in variances, that makes a point with a held parameter a better
/// minimum.
const BETTER: f64 = 0.5;
/// Weight of the held parameter: one deviation of it counts as this many deviations of the
/// residual.
const HOLD: f64 = 100.0;
/// Spread of a variable without effect on the curve, in its sizes, for the first step of a search.
const UNSEEN_SIZES: f64 = 10.0;

/// A fit whose parameters can be held.
pub(super) trait Profiled {
    /// Law minus data at every sample, in N, followed by the soundness residuals.
    fn residuals(&self, variables: &[f64]) -> Vec<f64>;
    /// Lowest and highest value of every variable.
    fn bounds(&self) -> (Vec<f64>, Vec<f64>);
    /// Steps of the finite differences.
    fn steps(&self) -> Vec<f64>;
    /// The value of a parameter for given variables: thresholds are not variables themselves.
    fn number(&self, variables: &[f64], which: usize) -> f64;
    /// The quantity of a parameter.
    fn quantity(&self, which: usize) -> Quantity;
    /// Whether the variable is a place, which is known to within its bounds before the fit.
    fn is_place(&self, which: usize) -> bool;

    /// The same fit with neighbouring values of its discrete parameters.
    fn close_by(&self) -> Vec<Self>
    where
        Self: Sized,
    {
        Vec::new()
    }
}

/// A point better than the fit, found during the search for an edge.
pub(super) struct Better<P> {
    /// `None` if it is the fit's own.
    pub problem: Option<P>,
    pub at: Vec<f64>,
}

/// Statistics of a fit that determine the confidence in it.
pub(super) struct FitStatistics<'j> {
    /// ∂(law)/∂(variables) at the fit.
    pub jacobian: &'j DMatrix<f64>,
    /// Number of samples of the fit.
    pub samples: usize,
    /// The curve's maximum force, in N.
    pub peak_n: f64,
}

/// A fit around which parameters are held.
pub(super) struct Likelihood<P> {
    pub problem: P,
    pub at: Vec<f64>,
    pub cost: f64,
    /// Variance of the residual, in N².
    pub variance: f64,
    /// Linearised covariance of the variables.
    pub covariance: DMatrix<f64>,
    pub quantile: f64,
}

/// A tried distance, and the rise of the cost there, as a deviation.
#[derive(Clone, Copy)]
struct Tried {
    way: f64,
    risen: f64,
}

/// End of a fit with a held parameter: its sum of squares minus that of the fit, in variances.
struct Held<P> {
    problem: Option<P>,
    rise: f64,
    at: Vec<f64>,
}

impl<P: Profiled> Likelihood<P> {
    pub fn new(problem: P, at: Vec<f64>, statistics: &FitStatistics<'_>) -> Self {
        let FitStatistics { jacobian, samples, peak_n } = *statistics;
        let cost = square(&problem.residuals(&at));
        let seen = jacobian.column_iter().filter(|column| column.amax() > 0.0).count();
        let freedom = samples.saturating_sub(seen).max(1) as f64;
        let finest_n = FINEST_PART * peak_n;
        let variance = (cost / freedom).max(finest_n * finest_n);
        let covariance = DMatrix::identity(at.len(), at.len());
        let blank = Self { problem, at, cost, variance, covariance, quantile: NORMAL_95 + STUDENT / freedom };
        Self { covariance: blank.spread(jacobian), ..blank }
    }

    /// The interval of a parameter; `None` if the curve does not determine it to within its size.
    /// The interval of a threshold covers its whole gap.
    ///
    /// # Errors
    /// A point better than the fit, if the search finds one.
    pub fn interval(&self, which: usize) -> Result<Option<Interval>, Better<P>> {
        let high = self.edge(which, 1.0)?;
        let low = if high.is_some() { self.edge(which, -1.0)? } else { None };
        Ok(low.zip(high).map(|(low, high)| self.over_gap(which, Interval { low, high })))
    }

    /// The size against which a parameter is judged.
    pub fn size(&self, which: usize, value: f64) -> f64 {
        value.abs().max(self.problem.quantity(which).least_size())
    }

    /// Whether an interval is no wider than the parameter, and excludes part of its allowed range.
    pub fn is_determined(&self, which: usize, interval: Interval) -> bool {
        let (lower, upper) = self.problem.quantity(which).bounds();
        let is_everything = interval.low <= lower && interval.high >= upper;
        !is_everything && interval.high - interval.low <= 2.0 * self.size(which, self.number(&self.at, which))
    }

    /// Extends a threshold's interval to the whole gap in which its boundary ruptures: the little
    /// evidence for the place within the gap, the onset of friction and cutting behind it, is
    /// ambiguous.
    fn over_gap(&self, which: usize, interval: Interval) -> Interval {
        if !self.problem.is_place(which) {
            return interval;
        }
        let (lower, upper) = self.problem.bounds();
        let at_end = |end_m: f64| {
            let mut point = self.at.clone();
            point[which] = end_m;
            self.number(&point, which)
        };
        Interval { low: interval.low.min(at_end(lower[which])), high: interval.high.max(at_end(upper[which])) }
    }

    /// The limit of a parameter in one direction.
    fn edge(&self, which: usize, sign: f64) -> Result<Option<f64>, Better<P>> {
        let here = self.number(&self.at, which);
        let (lower, upper) = self.problem.quantity(which).bounds();
        let room = if sign > 0.0 { upper - here } else { here - lower };
        let reach = room.min(self.size(which, here));
        let slope = self.slope(which);
        let deviation = self.deviation(&slope);
        let (mut near, mut far) = (Tried { way: 0.0, risen: 0.0 }, None);
        let mut way = (self.quantile * deviation).max(1e-9 * self.size(which, here));
        let mut from = self.at.clone();
        for _ in 0..EDGE_TRIES {
            way = way.min(reach);
            let held = self.hold(which, here + sign * way, &slope, &from);
            if held.rise < -BETTER {
                return Err(Better { problem: held.problem, at: held.at });
            }
            let risen = held.rise.max(0.0).sqrt();
            if risen < self.quantile {
                if way >= reach {
                    return Ok((reach >= room).then_some(here + sign * room));
                }
                near = Tried { way, risen };
                // Not from a rejected point: it may lie in another valley that no descent leaves.
                from = held.at;
            } else {
                far = Some(Tried { way, risen });
            }
            if (risen - self.quantile).abs() <= EDGE_PART * self.quantile {
                break;
            }
            way = self.next_way(near, far);
        }
        // Not found within the allowed number of tries: the farther bracket counts.
        let settled = far.map_or(near.way, |far| {
            if far.risen <= self.quantile * (1.0 + EDGE_PART) { self.next_way(near, Some(far)) } else { far.way }
        });
        Ok(Some(here + sign * settled))
    }

    /// Standard deviation of a parameter with this slope.
    fn deviation(&self, slope: &DVector<f64>) -> f64 {
        (&self.covariance * slope).dot(slope).max(0.0).sqrt()
    }

    /// The next distance to try: between an accepted and a rejected point, or farther out while
    /// none has been rejected.
    fn next_way(&self, near: Tried, far: Option<Tried>) -> f64 {
        match far {
            None => self.farther(near),
            // So steep a rise belongs to another valley, and is no basis for interpolation in this
            // one.
            Some(far) if far.risen > STEEP * self.quantile && self.farther(near) > 0.0 => {
                self.farther(near).min(0.5 * (near.way + far.way))
            }
            Some(far) => {
                let part = (self.quantile - near.risen) / (far.risen - near.risen).max(1e-9);
                near.way + (far.way - near.way) * part.clamp(0.1, 0.9)
            }
        }
    }

    /// The distance at which the quantile lies if the cost keeps rising as before.
    fn farther(&self, near: Tried) -> f64 {
        near.way * (1.05 * self.quantile / near.risen.max(1e-9)).clamp(1.3, 4.0)
    }

    /// Fits all other parameters with one held at a target, starting from a previous point moved
    /// along the covariance.
    fn hold(&self, which: usize, target: f64, slope: &DVector<f64>, from: &[f64]) -> Held<P> {
        let deviation = self.deviation(slope);
        let along = &self.covariance * slope / deviation.powi(2).max(f64::MIN_POSITIVE);
        let by = target - self.number(from, which);
        let start: Vec<f64> = from.iter().zip(along.iter()).map(|(value, along)| value + by * along).collect();
        let weight = HOLD * self.variance.sqrt() / deviation.max(1e-12);
        // Includes the residual of the held parameter: if the others cannot follow, the deviation
        // must cost.
        let residuals = |problem: &P, variables: &[f64]| {
            let mut residuals = problem.residuals(variables);
            residuals.push(weight * (problem.number(variables, which) - target));
            residuals
        };
        let held = |problem: &P, start: &[f64]| {
            let ((lower, upper), step) = (problem.bounds(), problem.steps());
            let residuals = |variables: &[f64]| residuals(problem, variables);
            let problem =
                LeastSquares { residuals: &residuals, lower: &lower, upper: &upper, step: &step, enough: 0.0 };
            problem.descend(start, HELD_DESCENT)
        };
        let mut lowest = held(&self.problem, &start);
        if lowest.cost - self.cost > self.quantile.powi(2) * self.variance {
            // A bend behind a rupture may block the descent: a start from the middle of the gaps
            // may pass it.
            let again = held(&self.problem, &self.in_the_middle(&start));
            lowest = if again.cost < lowest.cost { again } else { lowest };
        }
        let mut elsewhere = None;
        let close_by = self.problem.close_by().into_iter().map(|close| (square(&residuals(&close, &lowest.at)), close));
        if let Some((cost, close)) = close_by.min_by(|a, b| a.0.total_cmp(&b.0)).filter(|close| close.0 < lowest.cost) {
            let again = held(&close, &lowest.at);
            (lowest, elsewhere) = if again.cost <= cost { (again, Some(close)) } else { (lowest, None) };
        }
        Held { problem: elsewhere, rise: (lowest.cost - self.cost) / self.variance, at: lowest.at }
    }

    /// The same variables with every rupture in the middle of its gap.
    fn in_the_middle(&self, variables: &[f64]) -> Vec<f64> {
        let (lower, upper) = self.problem.bounds();
        let middle = |(which, &value): (usize, &f64)| match self.problem.is_place(which) {
            true => 0.5 * (lower[which] + upper[which]),
            false => value,
        };
        variables.iter().enumerate().map(middle).collect()
    }

    pub fn number(&self, variables: &[f64], which: usize) -> f64 {
        self.problem.number(variables, which)
    }

    /// ∂(number)/∂(variables).
    fn slope(&self, which: usize) -> DVector<f64> {
        let here = self.number(&self.at, which);
        let of = |(variable, step): (usize, &f64)| {
            let mut point = self.at.clone();
            point[variable] += step;
            (self.number(&point, which) - here) / (point[variable] - self.at[variable])
        };
        DVector::from_iterator(self.at.len(), self.problem.steps().iter().enumerate().map(of))
    }

    /// s² (JᵀJ)⁻¹ of the variables with an effect; each has a prior of some of its sizes, a place
    /// of its gap.
    fn spread(&self, jacobian: &DMatrix<f64>) -> DMatrix<f64> {
        let ((lower, upper), at, variance) = (self.problem.bounds(), &self.at, self.variance);
        let known = |which: usize| match self.problem.is_place(which) {
            true => ((upper[which] - lower[which]) / 12.0_f64.sqrt()).max(1e-12),
            false => UNSEEN_SIZES * self.size(which, at[which]),
        };
        let sizes = DVector::from_iterator(at.len(), (0..at.len()).map(known));
        let mut scaled = jacobian.clone();
        for (mut column, size) in scaled.column_iter_mut().zip(sizes.iter()) {
            column *= *size;
        }
        let normal = scaled.tr_mul(&scaled) + DMatrix::identity(at.len(), at.len()) * variance;
        let inverse =
            normal.cholesky().map_or_else(|| DMatrix::identity(at.len(), at.len()), |factor| factor.inverse());
        let diagonal = DMatrix::from_diagonal(&sizes);
        &diagonal * inverse * &diagonal * variance
    }
}
