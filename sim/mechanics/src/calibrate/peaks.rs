//! The ruptures of a fitted law beside the drops of the curve.

use super::model::{Guess, Model, Places};
use crate::axial::Contactor;
use crate::closed_form;

/// A place this many gaps from a drop of the curve explains it.
const NEAR_GAPS: usize = 2;

/// A rupture of the fitted law beside the curve.
#[derive(Clone, Debug, PartialEq)]
pub struct Peak {
    /// Which contactor.
    pub contactor: Contactor,
    /// Which boundary, from 0.
    pub boundary: usize,
    /// Where the law opens it, in m.
    pub depth_m: f64,
    /// The law's force at the last sample before, in N.
    pub force_n: f64,
    /// The curve's drop there, if it has one: the middle of its gap in m, and the force at the last sample before in N.
    pub measured: Option<(f64, f64)>,
}

/// Every placed rupture, in the order in which the law opens them.
pub(super) fn peaks(model: &Model<'_>, guess: &Guess) -> Vec<Peak> {
    let front = &model.front;
    let drops = front.drops();
    let forces = model.forces(&guess.spec);
    let along: Vec<f64> = model.curve.front().into_iter().map(|at| forces[at]).collect();
    let placed = closed_form::ruptures(&guess.spec).into_iter().filter_map(|rupture| {
        let row = match rupture.contactor {
            Contactor::Tip => &guess.places.tip,
            Contactor::Rim => &guess.places.rim,
        };
        let gap = row.get(rupture.boundary).copied().flatten()?;
        let drop = drops.iter().find(|drop| drop.gap.abs_diff(gap) <= NEAR_GAPS);
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

/// The drops of the curve that no rupture is near to: depth in m, fall in N.
pub(super) fn unexplained(model: &Model<'_>, places: &Places) -> Vec<(f64, f64)> {
    let is_placed =
        |gap: usize| places.tip.iter().chain(&places.rim).flatten().any(|place| place.abs_diff(gap) <= NEAR_GAPS);
    let drops = model.front.drops().into_iter().filter(|drop| !is_placed(drop.gap));
    drops.map(|drop| (model.front.middle_m(drop.gap), drop.fall_n)).collect()
}
