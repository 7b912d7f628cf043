//! Comparison of the ruptures of a fitted law with the drops of the curve.

use law::axial::{AxialSpec, Contactor};
use law::closed_form;

use super::model::{CurveModel, Guess};

/// Maximum distance, in gaps, between a place and a drop of the curve that it explains.
const NEAR_GAPS: usize = 2;
/// A drop is certain if it falls this many times the minimum (choice): the range of noise over a
/// long flat stretch may reach the minimum.
const BEYOND_DOUBT: f64 = 2.0;
/// The law makes a drop if it falls there by this fraction of it (choice).
const MADE_PART: f64 = 0.5;

/// A rupture of the fitted law and the matching drop of the curve.
#[derive(Clone, Debug, PartialEq)]
pub struct Peak {
    /// The contactor.
    pub contactor: Contactor,
    /// Index of the boundary, from 0.
    pub boundary: usize,
    /// Depth at which the law opens it, in m.
    pub depth_m: f64,
    /// The law's force at the last sample before, in N.
    pub force_n: f64,
    /// The curve's drop there, if any: the middle of its gap in m, and the force at the last sample
    /// before in N.
    pub measured: Option<(f64, f64)>,
}

/// Every placed rupture, in the order in which the law opens them.
pub(super) fn find_peaks(model: &CurveModel<'_>, guess: &Guess) -> Vec<Peak> {
    let front = &model.front;
    let drops = front.drops();
    let along = along_front(model, &guess.spec);
    let placed = closed_form::predict_ruptures(&guess.spec).into_iter().filter_map(|rupture| {
        let row = match rupture.contactor {
            Contactor::Tip => &guess.places.tip,
            Contactor::Rim => &guess.places.rim,
        };
        let gap = row.get(rupture.boundary).copied().flatten()?;
        let drop = drops.iter().find(|drop| is_near(drop.gap, gap));
        Some(Peak {
            contactor: rupture.contactor,
            boundary: rupture.boundary,
            depth_m: rupture.x_m,
            force_n: along[gap],
            measured: drop.map(|drop| (front.middle_m(drop.gap), front.force_n[drop.gap])),
        })
    });
    placed.collect()
}

/// The boundaries that the law opens within the curve and none of whose ruptures is one of its
/// drops.
pub(super) fn find_unseen(model: &CurveModel<'_>, guess: &Guess) -> Vec<usize> {
    let (drops, last_m) = (model.front.drops(), model.front.depth_m.last().copied().unwrap_or(0.0));
    let is_seen = |boundary: usize| {
        let places = [guess.places.tip[boundary], guess.places.rim[boundary]];
        places.into_iter().flatten().any(|gap| drops.iter().any(|drop| is_near(drop.gap, gap)))
    };
    let opened = closed_form::predict_ruptures(&guess.spec).into_iter().filter(|rupture| rupture.x_m <= last_m);
    let mut boundaries: Vec<usize> =
        opened.map(|rupture| rupture.boundary).filter(|&boundary| !is_seen(boundary)).collect();
    boundaries.sort_unstable();
    boundaries.dedup();
    boundaries
}

/// The certain drops of the curve that the law does not make: no rupture is near, and the law does
/// not fall there by itself, where a cut ends. Depth in m, fall in N.
pub(super) fn find_unexplained(model: &CurveModel<'_>, guess: &Guess) -> Vec<(f64, f64)> {
    let Guess { spec, places } = guess;
    let (front, along) = (&model.front, along_front(model, spec));
    let is_placed = |gap: usize| places.tip.iter().chain(&places.rim).flatten().any(|&place| is_near(gap, place));
    let falls = |force_n: &[f64], gap: usize| force_n[gap] - force_n[gap + 1];
    let is_made = |gap: usize| {
        let near = gap.saturating_sub(NEAR_GAPS)..=(gap + NEAR_GAPS).min(front.gaps() - 1);
        near.into_iter().any(|at| falls(&along, at) >= MADE_PART * falls(&front.force_n, gap))
    };
    let least_n = BEYOND_DOUBT * front.least_fall_n();
    let drops = front.drops().into_iter().filter(|drop| drop.fall_n >= least_n);
    let unmade = drops.filter(|drop| !is_placed(drop.gap) && !is_made(drop.gap));
    unmade.map(|drop| (front.middle_m(drop.gap), drop.fall_n)).collect()
}

/// Whether two guesses interpret the curve's drops differently: ruptures in another order, at other
/// positions, or outside the curve.
pub(super) fn is_another_reading(model: &CurveModel<'_>, guess: &Guess, other: &Guess) -> bool {
    let last_m = model.front.depth_m.last().copied().unwrap_or(0.0);
    let within = |guess: &Guess| {
        let ruptures = closed_form::predict_ruptures(&guess.spec).into_iter().filter(|rupture| rupture.x_m <= last_m);
        ruptures.map(|rupture| (rupture.contactor, rupture.boundary, rupture.x_m)).collect::<Vec<_>>()
    };
    let (here, there) = (within(guess), within(other));
    let is_like = |(here, there): (&(Contactor, usize, f64), &(Contactor, usize, f64))| {
        let [here_gap, there_gap] = [here.2, there.2].map(|x_m| model.front.nearest_gap(x_m));
        (here.0, here.1) == (there.0, there.1) && is_near(here_gap, there_gap)
    };
    here.len() != there.len() || !here.iter().zip(&there).all(is_like)
}

/// The drops interpreted as ruptures that may be single outliers, in m.
pub(super) fn find_lone_drops(model: &CurveModel<'_>, guess: &Guess) -> Vec<f64> {
    let (front, places) = (&model.front, &guess.places);
    let is_placed = |gap: usize| places.tip.iter().chain(&places.rim).flatten().any(|&place| is_near(gap, place));
    let lone = front.drops().into_iter().filter(|drop| front.is_lone(drop) && is_placed(drop.gap));
    lone.map(|drop| front.middle_m(drop.gap)).collect()
}

/// The law's force at every sample of the front, in N.
fn along_front(model: &CurveModel<'_>, spec: &AxialSpec) -> Vec<f64> {
    let forces = model.forces(spec);
    model.curve.front().into_iter().map(|at| forces[at]).collect()
}

/// Whether a gap and a place are close enough for one to explain the other.
pub(super) fn is_near(gap: usize, place: usize) -> bool {
    gap.abs_diff(place) <= NEAR_GAPS
}
