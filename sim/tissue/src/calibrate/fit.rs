//! The fit as a whole: guess, descend from several starts, try neighbouring places, make sound, say how well it went.

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

/// Iterations of a whole descent, and of one that only tells whether a neighbouring place is better.
const DESCENT: u32 = 40;
const TRIAL: u32 = 3;
/// How far a place is moved in one try, in gaps.
const STRIDES: [isize; 6] = [1, -1, 4, -4, 16, -16];
/// Rounds over all places. A round without gain ends it.
const ROUNDS: u32 = 12;
/// A place is moved only for this gain, as a part of the sum of squares.
const WORTH: f64 = 1e-5;
/// A moved place is descended from only if it does not raise the sum of squares beyond this factor at once.
const HOPELESS: f64 = 2.0;
/// How many of the least drops may be something else than a rupture: the end of a cut, where the next boundary is met.
const DOUBTFUL: usize = 2;
/// Iterations from another start that show whether it leads anywhere, and from one that does, to within
/// this factor of the best sum of squares; rounds of other starts.
const GLANCE: u32 = 4;
const SCATTER: u32 = 12;
const PROMISING: f64 = 5.0;
const SCATTERINGS: u32 = 3;
/// Starts drawn around a fit, and from which seed.
const DRAWS: u32 = 24;
const DRAWS_SEED: u64 = 1;
/// How many of a scene's orders of ruptures are gone down from again after a glance, and how many of these to the end.
const LIKELY_ORDERS: usize = 40;
const ORDERS: usize = 8;
/// Other readings of the curve are gone down to the end from at most so many variances above the fit, and so many of them.
const NEAR: f64 = 150.0;
const READINGS: usize = 12;
/// How often a better minimum that a profile comes upon is gone down to.
const SETTLINGS: u32 = 4;
/// How often unsound thresholds are lowered: each round settles at least the shallowest.
const LOWERINGS: usize = 2 * law::axial::MAX_LAYERS;

/// Where a fit starts from.
#[derive(Clone, Copy, Debug)]
pub enum Start<'s> {
    /// The curve alone.
    Fresh(Fresh),
    /// A scene's law, whose layers and needle are kept.
    Scene(&'s AxialSpec),
}

/// A scene that the data alone would ask for.
#[derive(Clone, Debug, PartialEq)]
pub struct AskedFit {
    /// Its root mean square residual, in N.
    pub rms_n: f64,
    /// Its ruptures that would create force or energy.
    pub unsound: Vec<Unsound>,
}

/// A fitted law and how far it can be trusted.
#[derive(Clone, Debug)]
pub struct Fit {
    /// The law: sound, with the damping and rate dependence of the start.
    pub spec: AxialSpec,
    /// Root mean square residual, in N.
    pub rms_n: f64,
    /// The curve's largest force, in N.
    pub peak_n: f64,
    /// Noise of the curve, in N, from its second differences.
    pub noise_n: f64,
    /// Iterations of all descents.
    pub iterations: u32,
    /// Whether the last descent ended because nothing lower was near, and left nothing but noise.
    pub converged: bool,
    /// What the residual has besides the curve's noise, if it has.
    pub misfit: Option<Misfit>,
    /// How many other readings of the curve's drops were found that it does not refuse: ruptures in another order or elsewhere. The
    /// intervals cover them.
    pub readings: usize,
    /// Ruptures within the curve.
    pub peaks: Vec<Peak>,
    /// Boundaries, from 0, that the law opens within the curve and none of whose ruptures is a drop of it. Which boundary gave way with
    /// which drop the curve does not tell then, and no number has an interval.
    pub unseen: Vec<usize>,
    /// Drops of the curve that no rupture explains: depth in m, fall in N.
    pub unexplained: Vec<(f64, f64)>,
    /// Every fitted parameter.
    pub estimates: Vec<ParameterEstimate>,
    /// What the curve cannot determine, in words.
    pub undetermined: Vec<String>,
    /// What the data alone would ask for, where that is unsound.
    pub asked: Option<AskedFit>,
}

/// A guess that was descended from.
#[derive(Clone)]
struct Candidate {
    guess: Guess,
    lowest: Lowest,
}

/// The search, with what it has done so far.
struct Search<'m, 'w> {
    model: &'m CurveModel<'m>,
    iterations: u32,
    /// Where other descents ended.
    rivals: Vec<Candidate>,
    watch: &'w mut dyn FnMut(u32),
}

/// Fits the law to a curve. `watch` is told the iterations done so far.
///
/// # Errors
/// A curve without enough drops, or a start that does not fit the curve or the law.
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
    // With a layer that may be a lone sample the fit is refused, however low it gets.
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
    /// Fits as many layers as asked for. Not asked, a drop that may be noise, or that the law makes without a rupture, where a
    /// cut ends, is a layer only if the curve is worth one.
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

    /// The lowest place that a scene leads to, laid over the curve with its ruptures in any order.
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

    /// So many of the lowest, gone down from again, and the others.
    fn lowest_of(&mut self, mut all: Vec<Candidate>, count: usize) -> (Vec<Candidate>, Vec<Candidate>) {
        all.sort_by(|a, b| a.lowest.cost.total_cmp(&b.lowest.cost));
        let rest = all.split_off(count.min(all.len()));
        (all.iter().map(|candidate| self.descend(&candidate.guess, false, SCATTER)).collect(), rest)
    }

    /// Goes down to the end from other readings of the curve that are not far above the fit: the curve may refuse none of them.
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

    /// The lower of two; the other is a rival.
    fn lower(&mut self, best: Candidate, tried: Candidate) -> Candidate {
        let is_lower = tried.lowest.cost < best.lowest.cost;
        let (lower, higher) = if is_lower { (tried, best) } else { (best, tried) };
        self.rivals.push(higher);
        lower
    }

    /// The lowest place that any of the guesses leads to.
    fn best_of(&mut self, guesses: [Guess; 3]) -> Candidate {
        let [first, second, third] = guesses.map(|guess| self.descend(&guess, false, DESCENT));
        let lower = |a: Candidate, b: Candidate| if b.lowest.cost < a.lowest.cost { b } else { a };
        self.refine(lower(lower(first, second), third), false)
    }

    /// The Bayesian information criterion, n ln(cost/n) + p ln n: the lower, the better the layers pay for themselves (Schwarz,
    /// "Estimating the dimension of a model", Ann. Stat. 6, 1978). A residual below a thousandth of the peak is none.
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

    /// Goes down again with one boundary after the other elsewhere, or one rupture elsewhere in its gap, and keeps what is lower: between two ruptures the bend where the
    /// next boundary is met may be taken for another.
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

    /// Goes down again from starts drawn around the fit, along the valley that it lies in: the bends of the law make steps in its floor.
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

    /// What is said of the fit. A better minimum that an interval comes upon is gone down to first.
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

    /// Every parameter, with intervals if asked for.
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

    /// Other readings of the curve's drops that it does not refuse.
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

/// Puts on its bound what ended next to it, and gives back its starting value to every variable that the curve does not depend
/// on: the way down may have moved it. The far side of a layer keeps its depth, not its distance to the near side.
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

/// What a fit without a start has instead of its start: a cut that no curve shows is none.
fn without_cutting(variables: &[f64]) -> Vec<f64> {
    let or_none = |(at, &value): (usize, &f64)| match QUANTITIES[at % QUANTITIES.len()] {
        Quantity::Cutting => 0.0,
        _ => value,
    };
    variables.iter().enumerate().map(or_none).collect()
}

/// Lowers what thresholds are still unsound to the largest sound ones; after a fit under the constraint, by next to nothing.
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

/// The start itself, where it is sound and the fit found nothing better.
fn keep_if_better(model: &CurveModel<'_>, fitted: Candidate, start: &AxialSpec) -> Candidate {
    let is_sound = soundness::find_unsound_ruptures(start).is_empty();
    if is_sound && residual_rms_n(start, model.curve) <= residual_rms_n(&fitted.guess.spec, model.curve) {
        return Candidate { guess: Guess { spec: start.clone(), ..fitted.guess }, ..fitted };
    }
    fitted
}
