//! Sound scenes: no rupture of a monotonic insertion may raise the elastic energy or the force.

use crate::axial::{AxialSpec, Contactor};
use crate::closed_form::{PredictedRupture, predict_held_ruptures};

/// A threshold too high for its stiffness: its rupture would create energy or force.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("boundary {boundary} ({layer}): the {} rupture at {threshold_n} N raises the force by {force_rise_n} N and the elastic energy by {energy_rise_mj} mJ; the largest sound threshold is {largest_sound_n} N", match .contactor { Contactor::Tip => "tip", Contactor::Rim => "rim" })]
pub struct Unsound {
    /// Which boundary, from 0.
    pub boundary: usize,
    /// Its layer's name.
    pub layer: String,
    /// Which contactor's threshold.
    pub contactor: Contactor,
    /// The threshold, in N.
    pub threshold_n: f64,
    /// Rise of the force over the whole cascade, in N (0 when it falls).
    pub force_rise_n: f64,
    /// Rise of the elastic energy over the whole cascade, in mJ (0 when it falls).
    pub energy_rise_mj: f64,
    /// The largest threshold of this contactor and boundary that would be sound, others unchanged, in N.
    pub largest_sound_n: f64,
}

/// A rise below this part of the larger value is round-off: two equal boundaries at one depth hand over without a rise.
const ROUND_OFF: f64 = 1e-9;
/// How finely smaller thresholds are tried before the edge is bisected. The sound ones need not be an interval (a threshold
/// high enough may open the next boundary in the same cascade), so a bisection alone could miss the largest.
const TRIES: u32 = 1000;
/// Halvings of one try: brings the edge to round-off.
const HALVINGS: u32 = 45;

/// How finely the speeds of a scene that relaxes are tried, from infinitely slow to infinitely fast: in so many steps of the force that its
/// branches still have when a boundary gives way.
const SPEEDS: u32 = 16;

/// How much of the branches' force is there at the speeds that a scene is judged at: one that does not relax gives way alike at all.
fn held_parts(spec: &AxialSpec) -> impl Iterator<Item = f64> + use<> {
    let most = if spec.relaxes() { SPEEDS } else { 0 };
    (0..=most).map(|part| f64::from(part) / f64::from(SPEEDS))
}

/// How many ways the edge is turned for a scene with sheets of fibres, over half a turn.
const EDGES: u32 = 12;

/// The tissue under the edges that a scene is judged with, all round: one that has no sheets is alike under all.
pub fn turned_specs(spec: &AxialSpec) -> impl Iterator<Item = AxialSpec> + '_ {
    let edges = if spec.has_sheets() { EDGES } else { 1 };
    (0..edges).map(|turn| {
        let angle_rad = f64::from(turn) * core::f64::consts::PI / f64::from(EDGES);
        spec.under_edge([libm::cos(angle_rad), libm::sin(angle_rad)])
    })
}

/// Every unsound rupture of a scene, each once, in the order met at the slowest speed that shows it; empty for a sound scene.
///
/// A cascade is judged as a whole and named by the rupture that sets it off. Where boundaries relax, a needle opens them the sooner the faster
/// it is, so that one may find a cascade where another does not: each is judged, and at speeds between them; and so is each turn of the edge
/// where there are sheets of fibres. Forces and energies are those of the first turn that shows it, thresholds those across the fibres.
#[must_use]
pub fn find_unsound_ruptures(spec: &AxialSpec) -> Vec<Unsound> {
    let mut found: Vec<Unsound> = Vec::new();
    for turned in turned_specs(spec) {
        for held in held_parts(spec) {
            let predicted = predict_held_ruptures(&turned, held);
            let cascades = predicted.chunk_by(|a, b| a.x_m.total_cmp(&b.x_m).is_eq());
            for trigger in cascades.filter_map(|cascade| cascade.first()).filter(|trigger| !is_rupture_sound(trigger)) {
                let is_same =
                    |known: &Unsound| (known.boundary, known.contactor) == (trigger.boundary, trigger.contactor);
                if !found.iter().any(is_same) {
                    found.push(describe_unsound(spec, trigger));
                }
            }
        }
    }
    found
}

fn relative_rise(before: f64, after: f64) -> f64 {
    let rise = after - before;
    if rise > ROUND_OFF * before.max(after) { rise } else { 0.0 }
}

fn is_rupture_sound(rupture: &PredictedRupture) -> bool {
    relative_rise(rupture.force_before_n, rupture.force_after_n) <= 0.0
        && relative_rise(rupture.energy_before_j, rupture.energy_after_j) <= 0.0
}

fn describe_unsound(spec: &AxialSpec, trigger: &PredictedRupture) -> Unsound {
    let threshold_n = rupture_threshold(spec, trigger.contactor, trigger.boundary);
    Unsound {
        boundary: trigger.boundary,
        layer: spec.layers.get(trigger.boundary).map_or_else(String::new, |layer| layer.name.clone()),
        contactor: trigger.contactor,
        threshold_n,
        force_rise_n: relative_rise(trigger.force_before_n, trigger.force_after_n),
        energy_rise_mj: relative_rise(trigger.energy_before_j, trigger.energy_after_j) * 1e3,
        largest_sound_n: largest_sound_n(spec, trigger, threshold_n),
    }
}

fn rupture_threshold(spec: &AxialSpec, contactor: Contactor, boundary: usize) -> f64 {
    spec.layers.get(boundary).map_or(0.0, |layer| match contactor {
        Contactor::Tip => layer.tip_rupture_n,
        Contactor::Rim => layer.rim_rupture_n,
    })
}

/// The largest threshold below the stated one at which this rupture, in whatever cascade it then falls, is sound; 0 if none is.
fn largest_sound_n(spec: &AxialSpec, trigger: &PredictedRupture, stated_n: f64) -> f64 {
    let mut trial = spec.clone();
    let mut sound_at = |threshold_n: f64| {
        if let Some(layer) = trial.layers.get_mut(trigger.boundary) {
            match trigger.contactor {
                Contactor::Tip => layer.tip_rupture_n = threshold_n,
                Contactor::Rim => layer.rim_rupture_n = threshold_n,
            }
        }
        turned_specs(&trial).all(|turned| held_parts(spec).all(|held| is_sound_at(&turned, held, trigger)))
    };
    let step_n = stated_n / f64::from(TRIES);
    let Some(low) = (0..TRIES).rev().map(|n| f64::from(n) * step_n).find(|&n| sound_at(n)) else { return 0.0 };
    let (mut sound_n, mut unsound_n) = (low, low + step_n);
    for _ in 0..HALVINGS {
        let middle = 0.5 * (sound_n + unsound_n);
        if sound_at(middle) {
            sound_n = middle;
        } else {
            unsound_n = middle;
        }
    }
    sound_n
}

/// Whether the same rupture is sound in a tissue with so much of the branches' force.
fn is_sound_at(spec: &AxialSpec, held: f64, trigger: &PredictedRupture) -> bool {
    let predicted = predict_held_ruptures(spec, held);
    let same =
        |rupture: &&PredictedRupture| rupture.contactor == trigger.contactor && rupture.boundary == trigger.boundary;
    predicted.iter().find(same).is_none_or(is_rupture_sound)
}
