//! The complete fit: guess, descend from several starts, try neighbouring places, make sound, report.

use law::axial::{AxialParams, AxialSpec, Contactor, ForceLaw};
use law::operator::Draw;
use law::soundness::{self, Unsound};

use super::curve::Curve;
use super::descent::Lowest;
use super::guess::{Fresh, guess_afresh, laid_over};
use super::model::{CurveModel, Guess, OWN, Places, QUANTITIES, Quantity, residual_rms_n};
use super::orders::in_every_order;
use super::peaks::{Peak, find_lone_drops, find_peaks, find_unexplained, find_unseen, is_another_reading};
use super::profile::FINEST_PART;
use super::starts::other_starts;
use super::uncertainty::{ParameterEstimate, ParameterStanding, Profile, Rival, estimate_parameters, find_standings};
use super::verdict::{Misfit, find_misfit};
use super::words::in_words;
use super::{CalibrateError, needs_times};

/// Iterations of a full descent, and of one that only tests a neighbouring place.
const DESCENT: u32 = 40;
const TRIAL: u32 = 3;
/// Moves of a place in one try, in gaps.
const STRIDES: [isize; 6] = [1, -1, 4, -4, 16, -16];
/// Maximum number of rounds over all places. A round without gain ends the refinement.
const ROUNDS: u32 = 12;
/// Required gain for a move of a place, as a fraction of the sum of squares.
const WORTH: f64 = 1e-5;
/// A moved place is descended from only if it initially raises the sum of squares by no more than this factor.
const HOPELESS: f64 = 2.0;
/// Number of the smallest drops that may not be ruptures but the end of a cut, where the next boundary is met.
const DOUBTFUL: usize = 2;
/// Iterations from another start that show whether it is promising, and from a promising one, to within this factor of the best sum of
/// squares; rounds of other starts.
const GLANCE: u32 = 4;
const SCATTER: u32 = 12;
const PROMISING: f64 = 5.0;
const SCATTERINGS: u32 = 3;
/// Number of starts drawn around a fit, and their seed.
const DRAWS: u32 = 24;
const DRAWS_SEED: u64 = 1;
/// Number of a scene's rupture orders that are descended from again after a short descent, and number of these that are descended from
/// fully.
const LIKELY_ORDERS: usize = 40;
const ORDERS: usize = 8;
/// Maximum distance from the fit, in variances, of other interpretations that are descended from fully, and their maximum number.
const NEAR: f64 = 150.0;
const READINGS: usize = 12;
/// Maximum number of descents to better minima found by a profile.
const SETTLINGS: u32 = 4;
/// Maximum number of rounds that lower unsound thresholds: each round settles at least the shallowest.
const LOWERINGS: usize = 2 * law::axial::MAX_LAYERS;

/// The start of a fit.
#[derive(Clone, Copy, Debug)]
pub enum Start<'s> {
    /// The curve alone.
    Fresh(Fresh),
    /// A scene's law; its layers and needle are kept.
    Scene(&'s AxialSpec),
}

/// A fit of the data alone, without the soundness constraint.
#[derive(Clone, Debug, PartialEq)]
pub struct AskedFit {
    /// Root mean square residual, in N.
    pub rms_n: f64,
    /// Its ruptures that would create force or energy.
    pub unsound: Vec<Unsound>,
}

/// A fitted law and the confidence in it.
#[derive(Clone, Debug)]
pub struct Fit {
    /// The law: sound, with the damping and rate dependence of the start.
    pub spec: AxialSpec,
    /// Root mean square residual, in N.
    pub rms_n: f64,
    /// The curve's maximum force, in N.
    pub peak_n: f64,
    /// Noise of the curve, in N, from its second differences.
    pub noise_n: f64,
    /// Iterations of all descents.
    pub iterations: u32,
    /// Whether the last descent ended because no lower point was near, and left only noise.
    pub converged: bool,
    /// The structure of the residual beyond the curve's noise, if any.
    pub misfit: Option<Misfit>,
    /// Number of other interpretations of the curve's drops that it does not reject: ruptures in another order or at other positions. The
    /// intervals cover them.
    pub readings: usize,
    /// Ruptures within the curve.
    pub peaks: Vec<Peak>,
    /// Boundaries, from 0, that the law opens within the curve and none of whose ruptures is one of its drops. The curve then does not
    /// determine which boundary ruptured at which drop, and no parameter has an interval.
    pub unseen: Vec<usize>,
    /// Drops of the curve that no rupture explains: depth in m, fall in N.
    pub unexplained: Vec<(f64, f64)>,
    /// Every fitted parameter.
    pub estimates: Vec<ParameterEstimate>,
    /// Descriptions of the parameters that the curve cannot determine.
    pub undetermined: Vec<String>,
    /// The fit of the data alone, if it is unsound.
    pub asked: Option<AskedFit>,
}

/// A guess and the end of its descent.
#[derive(Clone)]
struct Candidate {
    guess: Guess,
    lowest: Lowest,
}

/// The search, with its results so far.
struct Search<'m, 'w> {
    model: &'m CurveModel<'m>,
    iterations: u32,
    /// The ends of other descents.
    rivals: Vec<Candidate>,
    watch: &'w mut dyn FnMut(u32),
}

/// Fits the law to a curve. `watch` receives the number of iterations so far.
///
/// # Errors
/// If the curve has too few drops, or the start does not fit the curve or the law.
pub fn fit(curve: &Curve, start: Start<'_>, watch: &mut dyn FnMut(u32)) -> Result<Fit, CalibrateError> {
    let model = CurveModel::new(curve);
    let mut search = Search { model: &model, iterations: 0, rivals: Vec::new(), watch };
    let mut best = match start {
        Start::Fresh(asked) => search.by_drops(&asked)?,
        Start::Scene(spec) => {
            AxialParams::new(spec.clone())?;
            if spec.law == ForceLaw::Version1 {
                return Err(CalibrateError::OldLaw);
            }
            if needs_times(spec) {
                return Err(CalibrateError::LawOfOptions);
            }
            search.over_scene(spec)?
        }
    };
    let is_fresh = matches!(start, Start::Fresh(_));
    // A fit with a layer that may be a single outlier is rejected, however low its cost.
    if !is_fresh || find_lone_drops(&model, &best.guess).is_empty() {
        best = search.scatter(best);
        best = search.draw(best);
        best = search.settle(best);
    }
    let unsound = soundness::find_unsound_ruptures(&best.guess.spec);
    let rms_n = residual_rms_n(&best.guess.spec, curve);
    let asked = (!unsound.is_empty()).then_some(AskedFit { rms_n, unsound });
    best = search.descend(&best.guess, true, DESCENT);
    if asked.is_some() {
        best = search.refine(best, true);
    }
    let first = match start {
        Start::Scene(spec) => Some(spec),
        Start::Fresh(_) => None,
    };
    best = tidy(&model, best, first);
    best.guess.spec = sound(best.guess.spec);
    if let Some(spec) = first {
        best = keep_if_better(&model, best, spec);
    }
    Ok(search.report(best, asked, is_fresh))
}

impl Search<'_, '_> {
    /// Fits the requested number of layers. Without a request, a drop that may be noise, or that the law makes without a rupture, where a
    /// cut ends, becomes a layer only if it pays for itself on the curve.
    fn by_drops(&mut self, asked: &Fresh) -> Result<Candidate, CalibrateError> {
        let mut best = self.best_of(guess_afresh(&self.model.front, self.model.curve, asked)?);
        for _ in 0..DOUBTFUL {
            let fewer = best.guess.spec.layers.len() - 1;
            if asked.layers.is_some() || fewer == 0 {
                break;
            }
            let asked = Fresh { layers: Some(fewer), ..*asked };
            let simpler = self.best_of(guess_afresh(&self.model.front, self.model.curve, &asked)?);
            if self.worth(&simpler) > self.worth(&best) || !find_unexplained(self.model, &simpler.guess).is_empty() {
                break;
            }
            best = simpler;
        }
        Ok(best)
    }

    /// The lowest minimum reached from a scene, laid over the curve with its ruptures in any order.
    fn over_scene(&mut self, spec: &AxialSpec) -> Result<Candidate, CalibrateError> {
        let over = self.descend(&laid_over(&self.model.front, spec)?, false, DESCENT);
        let mut best = self.refine(over, false);
        let others = in_every_order(&self.model.front, spec);
        let glanced = others.iter().map(|guess| self.descend(guess, false, GLANCE)).collect();
        let (likely, _) = self.lowest_of(glanced, LIKELY_ORDERS);
        let (orders, rest) = self.lowest_of(likely, ORDERS);
        self.rivals.extend(rest);
        for order in orders {
            let order = self.refine(order, false);
            best = self.lower(best, order);
        }
        Ok(best)
    }

    /// Descends again from the `count` lowest candidates; returns these and the rest.
    fn lowest_of(&mut self, mut all: Vec<Candidate>, count: usize) -> (Vec<Candidate>, Vec<Candidate>) {
        all.sort_by(|a, b| a.lowest.cost.total_cmp(&b.lowest.cost));
        let rest = all.split_off(count.min(all.len()));
        (all.iter().map(|candidate| self.descend(&candidate.guess, false, SCATTER)).collect(), rest)
    }

    /// Descends fully from other interpretations of the curve close to the fit: the curve may not reject them.
    fn settle(&mut self, mut best: Candidate) -> Candidate {
        for _ in 0..SCATTERINGS {
            let variance = self.variance(&best);
            let is_near = |rival: &&Candidate| {
                rival.lowest.cost - best.lowest.cost <= NEAR * variance
                    && rival.guess.spec.layers.len() == best.guess.spec.layers.len()
                    && is_another_reading(self.model, &best.guess, &rival.guess)
            };
            let mut near: Vec<Candidate> = self.rivals.iter().filter(is_near).cloned().collect();
            near.sort_by(|a, b| a.lowest.cost.total_cmp(&b.lowest.cost));
            near.dedup_by(|a, b| a.guess.places == b.guess.places);
            near.truncate(READINGS);
            let before = best.lowest.cost;
            for rival in near {
                let settled = self.descend(&rival.guess, false, DESCENT);
                best = self.lower(best, settled);
            }
            if before - best.lowest.cost <= WORTH * before {
                break;
            }
            best = self.refine(best, false);
        }
        best
    }

    /// Variance of a candidate's residual, in N².
    fn variance(&self, candidate: &Candidate) -> f64 {
        let finest_n = FINEST_PART * self.model.curve.peak_n();
        (candidate.lowest.cost / self.model.curve.len() as f64).max(finest_n * finest_n)
    }

    /// The lower of two candidates; the other becomes a rival.
    fn lower(&mut self, best: Candidate, tried: Candidate) -> Candidate {
        let is_lower = tried.lowest.cost < best.lowest.cost;
        let (lower, higher) = if is_lower { (tried, best) } else { (best, tried) };
        self.rivals.push(higher);
        lower
    }

    /// The lowest minimum reached from any of the guesses.
    fn best_of(&mut self, guesses: [Guess; 3]) -> Candidate {
        let [first, second, third] = guesses.map(|guess| self.descend(&guess, false, DESCENT));
        let lower = |a: Candidate, b: Candidate| if b.lowest.cost < a.lowest.cost { b } else { a };
        self.refine(lower(lower(first, second), third), false)
    }

    /// The Bayesian information criterion, n ln(cost/n) + p ln n: the lower, the better the layers pay for themselves (Schwarz,
    /// "Estimating the dimension of a model", Ann. Stat. 6, 1978). The variance is bounded below by [`FINEST_PART`] of the peak.
    fn worth(&self, candidate: &Candidate) -> f64 {
        let samples = self.model.curve.len() as f64;
        let finest = (FINEST_PART * self.model.curve.peak_n()).powi(2);
        let variance = (candidate.lowest.cost / samples).max(finest);
        let variables = (OWN + 1) * candidate.guess.spec.layers.len();
        samples * libm::log(variance) + variables as f64 * libm::log(samples)
    }

    fn descend(&mut self, guess: &Guess, sound: bool, most: u32) -> Candidate {
        let lowest = self.model.descend(guess, sound, most);
        self.iterations += lowest.iterations;
        (self.watch)(self.iterations);
        let spec = self.model.spec(guess, &lowest.at);
        Candidate { guess: Guess { spec, places: guess.places.clone() }, lowest }
    }

    /// Descends again with one boundary after the other moved, or one rupture moved within its gap, and keeps improvements: between two
    /// ruptures the bend at which the next boundary is met may be mistaken for another.
    fn scatter(&mut self, mut best: Candidate) -> Candidate {
        for _ in 0..SCATTERINGS {
            let before = best.lowest.cost;
            for guess in other_starts(self.model, &best.guess) {
                let mut tried = self.descend(&guess, false, GLANCE);
                if tried.lowest.cost <= PROMISING * best.lowest.cost {
                    tried = self.descend(&tried.guess, false, SCATTER);
                }
                let is_lower = tried.lowest.cost < best.lowest.cost * (1.0 - WORTH);
                let (lower, higher) = if is_lower { (tried, best) } else { (best, tried) };
                self.rivals.push(higher);
                best = lower;
            }
            if before - best.lowest.cost <= WORTH * before {
                break;
            }
            best = self.descend(&best.guess, false, DESCENT);
        }
        best
    }

    /// Descends again from starts drawn around the fit, along its valley: the bends of the law make steps in the valley's floor.
    fn draw(&mut self, mut best: Candidate) -> Candidate {
        let mut draw = Draw::new(DRAWS_SEED);
        for _ in 0..SCATTERINGS {
            let (before, from) = (best.lowest.cost, best.guess.clone());
            let profile = Profile::new(self.model, &from);
            for _ in 0..DRAWS {
                let spec = self.model.spec(&from, &profile.draw(&mut draw));
                let tried = self.descend(&Guess { spec, places: from.places.clone() }, false, SCATTER);
                best = self.lower(best, tried);
            }
            if before - best.lowest.cost <= WORTH * before {
                break;
            }
        }
        best
    }

    /// Moves each place to a neighbouring gap while that lowers the sum of squares.
    fn refine(&mut self, mut best: Candidate, sound: bool) -> Candidate {
        for _ in 0..ROUNDS {
            let before = best.lowest.cost;
            for which in 0..2 * best.guess.spec.layers.len() {
                for stride in STRIDES {
                    best = self.try_place(best, which, stride, sound);
                }
            }
            if before - best.lowest.cost <= WORTH * before {
                break;
            }
        }
        let last = self.descend(&best.guess, sound, DESCENT);
        if last.lowest.cost <= best.lowest.cost { last } else { best }
    }

    fn try_place(&mut self, best: Candidate, which: usize, stride: isize, sound: bool) -> Candidate {
        let gaps = self.model.front.gaps();
        let Some(places) = moved(&best.guess.places, which, stride, gaps) else { return best };
        let guess = Guess { spec: best.guess.spec.clone(), places };
        if self.model.cost(&guess, sound) > HOPELESS * best.lowest.cost {
            return best;
        }
        let tried = self.descend(&guess, sound, TRIAL);
        let is_lower = tried.lowest.cost < best.lowest.cost * (1.0 - WORTH);
        let (lower, higher) = if is_lower { (tried, best) } else { (best, tried) };
        self.rivals.push(higher);
        lower
    }

    /// The report of the fit. Descends first to any better minimum that an interval finds.
    fn report(mut self, mut best: Candidate, asked: Option<AskedFit>, is_fresh: bool) -> Fit {
        let mut settlings = SETTLINGS;
        loop {
            let lone_m = if is_fresh { find_lone_drops(self.model, &best.guess) } else { Vec::new() };
            let misfit = find_misfit(self.model, &best.guess, lone_m);
            let is_told = misfit.is_none() && find_unseen(self.model, &best.guess).is_empty();
            match self.estimates(&best, is_told) {
                Err(variables) if settlings > 0 => {
                    settlings -= 1;
                    let spec = self.model.spec(&best.guess, &variables);
                    best = self.descend(&Guess { spec, ..best.guess }, true, DESCENT);
                    best.guess.spec = sound(best.guess.spec);
                }
                estimates => return self.summary(best, estimates.unwrap_or_default(), misfit, asked),
            }
        }
    }

    /// All parameters, with intervals if requested.
    fn estimates(&self, best: &Candidate, with_intervals: bool) -> Result<Vec<ParameterEstimate>, Vec<f64>> {
        let profile = Profile::new(self.model, &best.guess);
        let like = |rival: &&Candidate| rival.guess.spec.layers.len() == best.guess.spec.layers.len();
        let of = |rival: &Candidate| profile.rival(rival.guess.clone(), rival.lowest.cost);
        let rivals: Vec<Rival> = self.rivals.iter().filter(like).filter_map(of).collect();
        estimate_parameters(self.model, &best.guess, &mut |which| {
            let interval = if with_intervals { profile.interval(which)? } else { None };
            Ok(interval.and_then(|interval| profile.widen(which, interval, &rivals)))
        })
    }

    /// Number of other interpretations of the curve's drops that it does not reject.
    fn readings(&self, best: &Candidate) -> usize {
        let profile = Profile::new(self.model, &best.guess);
        let mut places: Vec<&Places> = Vec::new();
        for Candidate { guess, lowest } in &self.rivals {
            if profile.is_another(guess, lowest.cost) && !places.contains(&&guess.places) {
                places.push(&guess.places);
            }
        }
        places.len()
    }

    fn summary(
        &self,
        best: Candidate,
        estimates: Vec<ParameterEstimate>,
        misfit: Option<Misfit>,
        asked: Option<AskedFit>,
    ) -> Fit {
        let readings = self.readings(&best);
        let (model, Candidate { guess, lowest }) = (self.model, best);
        let (peaks, unseen) = (find_peaks(model, &guess), find_unseen(model, &guess));
        Fit {
            rms_n: residual_rms_n(&guess.spec, model.curve),
            peak_n: model.curve.peak_n(),
            noise_n: model.curve.noise_n(),
            iterations: self.iterations,
            converged: lowest.converged && misfit.is_none(),
            misfit,
            unexplained: find_unexplained(model, &guess),
            undetermined: in_words(model, &guess, &estimates, readings, &unseen),
            unseen,
            readings,
            estimates,
            peaks,
            asked,
            spec: guess.spec,
        }
    }
}

/// The places with one of them moved, if it stays within the curve and in order. Tips come first, then rims.
fn moved(places: &Places, which: usize, stride: isize, gaps: usize) -> Option<Places> {
    let layers = places.tip.len();
    let mut trial = places.clone();
    let row = if which < layers { &mut trial.tip } else { &mut trial.rim };
    let place = row.get_mut(which % layers)?;
    *place = Some((*place)?.checked_add_signed(stride).filter(|&gap| gap < gaps)?);
    row.iter().flatten().is_sorted().then_some(trial)
}

/// Moves variables next to a bound onto it, and restores the starting value of every variable without effect on the curve: the descent
/// may have changed it. The far side of a layer keeps its depth, not its distance from the near side.
fn tidy(model: &CurveModel<'_>, fitted: Candidate, start: Option<&AxialSpec>) -> Candidate {
    let mut variables = model.variables(&fitted.guess);
    let standings = find_standings(model, &fitted.guess);
    let first = start.map_or_else(
        || without_cutting(&variables),
        |spec| model.variables(&Guess { spec: spec.clone(), places: fitted.guess.places.clone() }),
    );
    let last_thickness = variables.len() - QUANTITIES.len();
    let (mut depth_m, mut start_m) = (0.0, 0.0);
    for (at, &began) in first.iter().enumerate() {
        let quantity = QUANTITIES[at % QUANTITIES.len()];
        let is_thickness = quantity == Quantity::Thickness;
        start_m += if is_thickness { began } else { 0.0 };
        if at % QUANTITIES.len() >= OWN {
            continue;
        } else if standings[at] == ParameterStanding::Kept {
            let keeps_depth = is_thickness && at < last_thickness;
            variables[at] = if keeps_depth { (start_m - depth_m).max(0.0) } else { began };
        } else {
            variables[at] = quantity.on_its_bound(variables[at]);
        }
        depth_m += if is_thickness { variables[at] } else { 0.0 };
    }
    let spec = model.spec(&fitted.guess, &variables);
    let tidied = Candidate { guess: Guess { spec, ..fitted.guess.clone() }, lowest: fitted.lowest.clone() };
    let rms_n = |candidate: &Candidate| residual_rms_n(&candidate.guess.spec, model.curve);
    let as_good_n = (model.as_good_as_none() / model.curve.len() as f64).sqrt();
    if rms_n(&tidied) <= rms_n(&fitted) * (1.0 + WORTH) + as_good_n { tidied } else { fitted }
}

/// The starting values of a fit without a start: cutting that no curve shows is 0.
fn without_cutting(variables: &[f64]) -> Vec<f64> {
    let or_none = |(at, &value): (usize, &f64)| match QUANTITIES[at % QUANTITIES.len()] {
        Quantity::Cutting => 0.0,
        _ => value,
    };
    variables.iter().enumerate().map(or_none).collect()
}

/// Lowers thresholds that are still unsound to the largest sound values; after a fit under the constraint, by next to nothing.
pub(super) fn sound(mut spec: AxialSpec) -> AxialSpec {
    const BELOW: f64 = 1.0 - 1e-4;
    for _ in 0..LOWERINGS {
        let Some(first) = soundness::find_unsound_ruptures(&spec).into_iter().next() else { break };
        if let Some(layer) = spec.layers.get_mut(first.boundary) {
            match first.contactor {
                Contactor::Tip => layer.tip_rupture_n = first.largest_sound_n * BELOW,
                Contactor::Rim => layer.rim_rupture_n = first.largest_sound_n * BELOW,
            }
        }
    }
    spec
}

/// Returns the start itself if it is sound and the fit found nothing better.
fn keep_if_better(model: &CurveModel<'_>, fitted: Candidate, start: &AxialSpec) -> Candidate {
    let is_sound = soundness::find_unsound_ruptures(start).is_empty();
    if is_sound && residual_rms_n(start, model.curve) <= residual_rms_n(&fitted.guess.spec, model.curve) {
        return Candidate { guess: Guess { spec: start.clone(), ..fitted.guess }, ..fitted };
    }
    fitted
}
