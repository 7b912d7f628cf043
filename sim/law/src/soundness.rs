//! Sound scenes: no rupture of a monotonic insertion may raise the elastic energy or the force.

use crate::axial::{AxialSpec, Contactor};
use crate::closed_form::{PredictedRupture, predict_held_ruptures};

/// A threshold that is too high for its stiffness: its rupture would create energy or force.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("boundary {boundary} ({layer}): the {} rupture at {threshold_n} N raises the force by {force_rise_n} N and the elastic energy by {energy_rise_mj} mJ; the largest sound threshold is {largest_sound_n} N", match .contactor { Contactor::Tip => "tip", Contactor::Rim => "rim" })]
pub struct Unsound {
    /// Index of the boundary, from 0.
    pub boundary: usize,
    /// Name of its layer.
    pub layer: String,
    /// The contactor of the threshold.
    pub contactor: Contactor,
    /// The threshold, in N.
    pub threshold_n: f64,
    /// Rise of the force over the whole cascade, in N (0 when it falls).
    pub force_rise_n: f64,
    /// Rise of the elastic energy over the whole cascade, in mJ (0 when it falls).
    pub energy_rise_mj: f64,
    /// The largest threshold of this contactor and boundary that would be sound, others unchanged,
    /// in N.
    pub largest_sound_n: f64,
}

/// A rise below this fraction of the larger value is round-off: two equal boundaries at one depth
/// hand over without a rise.
const ROUND_OFF: f64 = 1e-9;
/// Number of smaller thresholds that are tried before the edge is bisected. The sound ones need not
/// form an interval (a sufficiently high threshold may open the next boundary in the same cascade),
/// so a bisection alone could miss the largest.
const TRIES: u32 = 1000;
/// Number of halvings of one try: reduces the interval to round-off.
const HALVINGS: u32 = 45;

/// Number of speeds tried for a scene that relaxes, from infinitely slow to infinitely fast, as
/// fractions of the branches' force that remain at a rupture.
const SPEEDS: u32 = 16;

/// Fractions of the branches' force at the speeds for which a scene is checked: ruptures of a scene
/// that does not relax do not depend on speed.
fn held_parts(spec: &AxialSpec) -> impl Iterator<Item = f64> + use<> {
    let most = if spec.relaxes() { SPEEDS } else { 0 };
    (0..=most).map(|part| f64::from(part) / f64::from(SPEEDS))
}

/// Number of rotations of the edge over half a turn, for a scene with sheets of fibres.
const EDGES: u32 = 12;

/// The tissue under the edges for which a scene is checked, over half a turn: one without sheets
/// does not depend on the edge.
pub fn turned_specs(spec: &AxialSpec) -> impl Iterator<Item = AxialSpec> + '_ {
    let edges = if spec.has_sheets() { EDGES } else { 1 };
    (0..edges).map(|turn| {
        let angle_rad = f64::from(turn) * core::f64::consts::PI / f64::from(EDGES);
        spec.under_edge([libm::cos(angle_rad), libm::sin(angle_rad)])
    })
}

/// Finds every unsound rupture of a scene, each once, in the order met at the slowest speed that
/// shows it; empty for a sound scene.
///
/// A cascade is checked as a whole and identified by the rupture that triggers it. If boundaries
/// relax, a faster needle opens them sooner, so that cascades depend on speed: the extremes and
/// speeds between them are checked; and so is each rotation of the edge if there are sheets of
/// fibres. Forces and energies are those of the first rotation that shows it, thresholds those
/// across the fibres.
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

/// The largest threshold below the stated one at which this rupture, in whichever cascade contains
/// it, is sound; 0 if no threshold is.
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

/// Whether the same rupture is sound with the fraction `held` of the branches' force.
fn is_sound_at(spec: &AxialSpec, held: f64, trigger: &PredictedRupture) -> bool {
    let predicted = predict_held_ruptures(spec, held);
    let same =
        |rupture: &&PredictedRupture| rupture.contactor == trigger.contactor && rupture.boundary == trigger.boundary;
    predicted.iter().find(same).is_none_or(is_rupture_sound)
}
