//! The length at which static friction gives way.
//!
//! At breakaway of the shaft the force falls between two samples; the curve only shows which two.
//! So lengths are tried one after the other with all other variables fitted again, and the interval
//! extends to the nearest length that the curve rejects.

use super::model::TimedModel;
use super::{DESCENT, TRIAL, TimedSearch, WORTH};
use crate::calibrate::descent::Lowest;
use crate::calibrate::model::Quantity;
use crate::calibrate::profile::Likelihood;
use crate::calibrate::uncertainty::{Interval, ParameterEstimate, ParameterStanding};

/// Number and spacing of neighbouring lengths, in parts of the distance between two samples.
const CLOSE: i32 = 6;
const CLOSE_PART: f64 = 0.25;
/// Maximum number of moves to a neighbouring length.
const MOVES: u32 = 6;
/// Iterations with a length held, for an interval.
const HELD: u32 = 16;
/// Ratio of successive lengths (choice): an interval is no narrower.
const FINER: f64 = 1.1;

impl TimedModel<'_> {
    /// Lengths to try, in m, ascending, including the present one: up to the first that exceeds the
    /// needle's whole insertion, at which it never breaks away. Empty if the start has no breakaway
    /// length.
    fn lengths_m(&self) -> Vec<f64> {
        let (shortest_m, _) = Quantity::Breakaway.bounds();
        let deepest_m = self.curve.samples.iter().fold(0.0_f64, |deepest, sample| deepest.max(sample.depth_m));
        let Some(slid_m) = self.slid_m else { return Vec::new() };
        let steps = |to_m: f64| (libm::log(to_m / slid_m) / libm::log(FINER)) as i32;
        let longest_m = deepest_m.max(slid_m);
        (steps(shortest_m.min(slid_m))..=steps(longest_m) + 1)
            .map(|n| slid_m * libm::pow(FINER, f64::from(n)))
            .collect()
    }

    /// The same model with each neighbouring length; empty if the start has no breakaway length.
    pub(super) fn with_close_lengths(&self) -> Vec<Self> {
        let (shortest_m, longest_m) = Quantity::Breakaway.bounds();
        let Some(slid_m) = self.slid_m else { return Vec::new() };
        let part_m = CLOSE_PART * self.curve.stride_m();
        let lengths_m = (-CLOSE..=CLOSE).filter(|n| *n != 0).map(|n| slid_m + f64::from(n) * part_m);
        lengths_m.filter(|m| (shortest_m..=longest_m).contains(m)).map(|slid_m| self.sliding(slid_m)).collect()
    }

    fn sliding(&self, slid_m: f64) -> Self {
        Self { slid_m: Some(slid_m), ..self.clone() }
    }
}

impl TimedSearch<'_, '_> {
    /// Sets the breakaway length to the one with the lowest cost.
    pub(super) fn slide(&mut self, best: Lowest) -> Lowest {
        let lengths_m = self.model.lengths_m();
        let tried = lengths_m.into_iter().map(|slid_m| (slid_m, self.model.sliding(slid_m).descend(&best.at, TRIAL)));
        let Some((slid_m, tried)) = tried.min_by(|a, b| a.1.cost.total_cmp(&b.1.cost)) else { return best };
        if tried.cost >= best.cost * (1.0 - WORTH) {
            return self.slide_on(best);
        }
        self.model.slid_m = Some(slid_m);
        let slid = self.descend(&tried.at, DESCENT);
        self.slide_on(slid)
    }

    /// Moves to a neighbouring length while that lowers the sum of squares.
    fn slide_on(&mut self, mut best: Lowest) -> Lowest {
        for _ in 0..MOVES {
            let close = self.model.with_close_lengths();
            let tried = close.into_iter().map(|close| (close.descend(&best.at, TRIAL), close));
            let Some((tried, close)) = tried.min_by(|a, b| a.0.cost.total_cmp(&b.0.cost)) else { return best };
            if tried.cost >= best.cost * (1.0 - WORTH) {
                return best;
            }
            self.model = close;
            best = self.descend(&tried.at, DESCENT);
        }
        best
    }

    /// The estimate of the length; `None` if the start has no breakaway length.
    pub(super) fn slid(&self, profile: &Likelihood<TimedModel<'_>>, is_told: bool) -> Option<ParameterEstimate> {
        let value = self.model.slid_m?;
        let lengths_m = self.model.lengths_m();
        let misfit = self.model.misfit(&profile.at);
        let matters = lengths_m.iter().any(|&slid_m| self.model.sliding(slid_m).misfit(&profile.at) != misfit);
        let interval = if is_told && matters { self.slid_interval(profile, &lengths_m) } else { None };
        let least_m = 2.0 * value.max(Quantity::Breakaway.least_size());
        Some(ParameterEstimate {
            layer: self.model.start.layers.len(),
            quantity: Quantity::Breakaway,
            value,
            interval: interval.filter(|interval| interval.high - interval.low <= least_m),
            standing: if matters { ParameterStanding::Free } else { ParameterStanding::Kept },
        })
    }

    /// From the last rejected length below to the first above; `None` if there is no such length.
    /// The best of many lengths fits noise better than a single one would, so the rise needed to
    /// reject a length is larger.
    fn slid_interval(&self, profile: &Likelihood<TimedModel<'_>>, lengths_m: &[f64]) -> Option<Interval> {
        let allowed = profile.quantile.powi(2) + 2.0 * libm::log(lengths_m.len() as f64);
        let is_taken = |slid_m: &f64| {
            let tried = self.model.sliding(*slid_m).descend(&profile.at, HELD);
            tried.cost - profile.cost <= allowed * profile.variance
        };
        let taken: Vec<bool> = lengths_m.iter().map(is_taken).collect();
        let first = taken.iter().position(|&taken| taken)?;
        let last = taken.iter().rposition(|&taken| taken)?;
        Some(Interval { low: *lengths_m.get(first.checked_sub(1)?)?, high: *lengths_m.get(last + 1)? })
    }
}
