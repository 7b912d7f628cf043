//! The fit to a timed curve: options of version 3 of the law, which a curve without times does not
//! determine.
//!
//! Relaxation shows in a hold, damping where the needle stops, friction in a withdrawal, and
//! cutting, separated from friction, in a second insertion into the same track, which cuts nothing
//! (Azar & Hayward, "Estimation of the fracture toughness of soft tissue from needle insertion",
//! ISBMS 2008). The start defines the options; the confidence in each parameter is determined as
//! without times.

mod curve;
mod model;
mod sliding;

use law::axial::{AxialParams, AxialSpec, Contactor, ForceLaw};
use law::operator::Draw;
use law::soundness;

pub use curve::{TimedCurve, TimedSample};
pub use model::timed_residual_rms_n;

use self::model::{TimedModel, TimedSlot, find_slots};
use super::CalibrateError;
use super::descent::Lowest;
use super::drops::Front;
use super::fit::{AskedFit, Fit, sound};
use super::guess::laid_over;
use super::model::Quantity;
use super::peaks::{Peak, is_near};
use super::profile::{Better, FitStatistics, Likelihood, Profiled};
use super::uncertainty::{Interval, ParameterEstimate, ParameterStanding};
use super::verdict::{FitResidual, Misfit, judge_residual};
use super::words::timed_in_words;

/// Iterations of a full descent, of a short one from a drawn start, and of one that tests a
/// neighbouring place.
const DESCENT: u32 = 200;
const GLANCE: u32 = 6;
const TRIAL: u32 = 4;
/// Number of starts drawn around the first, their spread on a logarithmic scale, their seed, and
/// the number that are descended from fully.
const DRAWS: u32 = 12;
const DRAWN: f64 = 0.5;
const DRAWS_SEED: u64 = 1;
const FOLLOWED: usize = 3;
/// Moves of a place in one try, in gaps, and the required gain, as a fraction of the sum of
/// squares.
const STRIDES: [isize; 4] = [1, -1, 2, -2];
const WORTH: f64 = 1e-3;
/// Maximum number of descents to better minima found by a profile.
const SETTLINGS: u32 = 4;

/// A search, with its iteration count.
struct TimedSearch<'c, 'w> {
    model: TimedModel<'c>,
    iterations: u32,
    watch: &'w mut dyn FnMut(u32),
}

/// Fits the law with the options of a start to a timed curve. `watch` receives the number of
/// iterations so far.
///
/// # Errors
/// If the start is older than version 3, has a rim or fibres, or does not fit the curve.
pub fn fit_timed(curve: &TimedCurve, start: &AxialSpec, watch: &mut dyn FnMut(u32)) -> Result<Fit, CalibrateError> {
    AxialParams::new(start.clone())?;
    if start.law < ForceLaw::Version3 {
        return Err(CalibrateError::TimedLaw);
    }
    if start.tip_to_rim_m > 0.0 {
        return Err(CalibrateError::TimedRim { tip_to_rim_mm: start.tip_to_rim_m * 1e3 });
    }
    if start.has_sheets() {
        return Err(CalibrateError::TimedFibres);
    }
    let front = Front::new(&curve.insertion);
    let laid = laid_over(&front, start)?;
    let places = laid.places.tip;
    let opening = places.iter().flatten().count();
    if let Some(boundary) = places[..opening].iter().position(Option::is_none) {
        return Err(CalibrateError::TimedCascade { layer: start.layers[boundary].name.clone() });
    }
    let slots = find_slots(start, &places);
    let slid_m = start.breakaway.map(|breakaway| breakaway.slid_m);
    let model = TimedModel { curve, front: &front, start, slots: &slots, places, slid_m };
    let first = model.variables(&laid.spec);
    let mut search = TimedSearch { model, iterations: 0, watch };
    let lowest = search.lowest(&first);
    let lowest = search.slide(lowest);
    let lowest = search.refine(lowest);
    let lowest = search.slide(lowest);
    let lowest = search.restore(lowest, &first);
    Ok(search.report(lowest))
}

impl<'c> TimedSearch<'c, '_> {
    fn descend(&mut self, from: &[f64], most: u32) -> Lowest {
        let lowest = self.model.descend(from, most);
        self.iterations += lowest.iterations;
        (self.watch)(self.iterations);
        lowest
    }

    /// The lowest minimum reached from the start or one drawn around it.
    #[expect(clippy::expect_used, reason = "the start is one of those that are followed")]
    fn lowest(&mut self, first: &[f64]) -> Lowest {
        let mut draw = Draw::new(DRAWS_SEED);
        let mut glanced = vec![self.descend(first, GLANCE)];
        for _ in 0..DRAWS {
            let drawn: Vec<f64> = (0..first.len())
                .map(|which| match self.model.is_place(which) {
                    true => first[which],
                    false => first[which] * libm::exp(draw.normal(DRAWN)),
                })
                .collect();
            glanced.push(self.descend(&drawn, GLANCE));
        }
        glanced.sort_by(|a, b| a.cost.total_cmp(&b.cost));
        glanced.truncate(FOLLOWED);
        let followed: Vec<Lowest> = glanced.iter().map(|from| self.descend(&from.at, DESCENT)).collect();
        let lower = |a: Lowest, b: Lowest| if b.cost < a.cost { b } else { a };
        followed.into_iter().reduce(lower).expect("the start is one of them")
    }

    /// Moves each place to a neighbouring gap while that lowers the sum of squares.
    fn refine(&mut self, mut best: Lowest) -> Lowest {
        for boundary in 0..self.model.places.len() {
            for stride in STRIDES {
                let Some(moved) = self.moved(boundary, stride) else { continue };
                let kept = std::mem::replace(&mut self.model.places, moved);
                let tried = self.descend(&best.at, TRIAL);
                if tried.cost < best.cost * (1.0 - WORTH) {
                    best = self.descend(&tried.at, DESCENT);
                } else {
                    self.model.places = kept;
                }
            }
        }
        best
    }

    /// Restores the starting value of every variable without effect on the curve: a drawn start may
    /// have changed it.
    fn restore(&self, mut lowest: Lowest, first: &[f64]) -> Lowest {
        let jacobian = self.model.sensitivity(&lowest.at);
        for (which, column) in jacobian.column_iter().enumerate() {
            if column.amax() == 0.0 && !self.model.is_place(which) {
                lowest.at[which] = first[which];
            }
        }
        lowest
    }

    fn moved(&self, boundary: usize, stride: isize) -> Option<Vec<Option<usize>>> {
        let mut places = self.model.places.clone();
        let gap = places[boundary]?.checked_add_signed(stride).filter(|&gap| gap < self.model.front.gaps())?;
        places[boundary] = Some(gap);
        places.iter().flatten().is_sorted().then_some(places)
    }

    /// The report of the fit. Descends first to any better minimum that an interval finds.
    fn report(mut self, mut lowest: Lowest) -> Fit {
        for _ in 0..SETTLINGS {
            match self.estimates(&lowest.at) {
                Err(better) => {
                    if let Some(model) = better.problem {
                        self.model = model;
                    }
                    lowest = self.descend(&better.at, DESCENT);
                }
                Ok(estimates) => return self.summary(lowest, estimates),
            }
        }
        self.summary(lowest, Vec::new())
    }

    fn misfit(&self, at: &[f64]) -> Option<Misfit> {
        let (residuals, curve) = (self.model.misfit(at), self.model.curve);
        let depth_m: Vec<f64> = curve.samples.iter().map(|sample| sample.depth_m).collect();
        let (peak_n, noise_n) = (curve.peak_n(), curve.noise_n());
        judge_residual(&FitResidual { residuals: &residuals, depth_m: &depth_m, peak_n, noise_n }, Vec::new())
    }

    /// Boundaries that rupture where the curve shows no drop.
    fn unseen(&self) -> Vec<usize> {
        let drops = self.model.front.drops();
        let is_shown = |gap: usize| drops.iter().any(|drop| is_near(drop.gap, gap));
        let places = self.model.places.iter().enumerate();
        places.filter_map(|(at, gap)| gap.filter(|&gap| !is_shown(gap)).map(|_| at)).collect()
    }

    /// All parameters, with an interval if the curve determines it and the fit describes the curve.
    fn estimates(&self, at: &[f64]) -> Result<Vec<ParameterEstimate>, Better<TimedModel<'c>>> {
        let jacobian = self.model.sensitivity(at);
        let statistics =
            FitStatistics { jacobian: &jacobian, samples: self.model.curve.len(), peak_n: self.model.curve.peak_n() };
        let profile = Likelihood::new(self.model.clone(), at.to_vec(), &statistics);
        // An unsound fit is replaced by the nearest sound scene, whose parameters are not those of
        // the curve.
        let is_sound = soundness::find_unsound_ruptures(&self.model.spec(at)).is_empty();
        let is_told = is_sound && self.misfit(at).is_none() && self.unseen().is_empty();
        let mut estimates = Vec::with_capacity(at.len());
        for (which, &TimedSlot { layer, quantity }) in self.model.slots.iter().enumerate() {
            let standing = self.standing(which, at[which], jacobian.column(which).amax());
            let is_kept = standing == ParameterStanding::Kept;
            let interval = if is_told && !is_kept { profile.interval(which)? } else { None };
            let interval = interval.filter(|interval: &Interval| profile.is_determined(which, *interval));
            estimates.push(ParameterEstimate { layer, quantity, value: profile.number(at, which), interval, standing });
        }
        estimates.extend(self.slid(&profile, is_told));
        let shut = self.model.places.iter().enumerate().filter(|(_, place)| place.is_none());
        estimates.extend(shut.map(|(layer, _)| ParameterEstimate {
            layer,
            quantity: Quantity::TipThreshold,
            value: self.model.start.layers[layer].tip_rupture_n,
            interval: None,
            standing: ParameterStanding::Kept,
        }));
        Ok(estimates)
    }

    fn standing(&self, which: usize, value: f64, effect: f64) -> ParameterStanding {
        let (lower, upper) = self.model.quantity(which).bounds();
        match effect {
            // The position within the gap may have no effect: the gap, and the force held there,
            // are known.
            _ if self.model.is_place(which) => ParameterStanding::Free,
            0.0 => ParameterStanding::Kept,
            _ if value <= lower => ParameterStanding::AtLower,
            _ if value >= upper => ParameterStanding::AtUpper,
            _ => ParameterStanding::Free,
        }
    }

    fn peaks(&self, at: &[f64]) -> Vec<Peak> {
        let (walked, front) = (self.model.walk(at), self.model.front);
        let drops = front.drops();
        let slots = self.model.slots.iter().zip(at).filter(|(slot, _)| slot.quantity == Quantity::TipThreshold);
        let peak = |(slot, &depth_m): (&TimedSlot, &f64)| {
            let gap = self.model.places[slot.layer]?;
            let drop = drops.iter().find(|drop| is_near(drop.gap, gap));
            Some(Peak {
                contactor: Contactor::Tip,
                boundary: slot.layer,
                depth_m,
                force_n: walked.before_n[slot.layer],
                measured: drop.map(|drop| (front.middle_m(drop.gap), front.force_n[drop.gap])),
            })
        };
        slots.filter_map(peak).collect()
    }

    fn summary(&self, lowest: Lowest, estimates: Vec<ParameterEstimate>) -> Fit {
        let (model, curve) = (&self.model, self.model.curve);
        let misfit = self.misfit(&lowest.at);
        let spec = model.spec(&lowest.at);
        let rms_n = (model.misfit(&lowest.at).iter().map(|r| r * r).sum::<f64>() / curve.len() as f64).sqrt();
        let unsound = soundness::find_unsound_ruptures(&spec);
        Fit {
            rms_n,
            peak_n: curve.peak_n(),
            noise_n: curve.noise_n(),
            iterations: self.iterations,
            converged: lowest.converged && misfit.is_none(),
            undetermined: timed_in_words(curve, &spec, &estimates, &self.unseen()),
            misfit,
            readings: 0,
            peaks: self.peaks(&lowest.at),
            unseen: self.unseen(),
            unexplained: Vec::new(),
            estimates,
            asked: (!unsound.is_empty()).then_some(AskedFit { rms_n, unsound }),
            spec: sound(spec),
        }
    }
}
