//! Starting values, from the curve itself or from a scene laid over it.

use law::axial::{AxialSpec, Contactor, ForceLaw, Layer, LayerOptions};
use law::closed_form;

use super::CalibrateError;
use super::curve::Curve;
use super::drops::{Drop, Front};
use super::model::{Guess, Places};
use super::starts::{LEAST_STIFFNESS_N_PER_M, rise_n_per_m};

/// The request for a fit without a starting scene.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Fresh {
    /// Number of layers; if absent, as many as the curve has drops for.
    pub layers: Option<usize>,
    /// Distance from the tip to the cannula's rim, in m; 0 for a single contactor.
    pub tip_to_rim_m: f64,
}

/// Thickness of the last layer below the end of the curve, in m (choice): the curve does not show
/// its far side.
const BELOW_M: f64 = 0.02;

/// Guesses from the drops alone. Each drop is a rupture; those of a trocar alternate between tip
/// and rim. The force left after a drop may belong to the next boundary or to the cutting of new
/// tissue: only the law can decide, so both are tried.
pub(super) fn guess_afresh(front: &Front, curve: &Curve, asked: &Fresh) -> Result<[Guess; 3], CalibrateError> {
    let per_layer = if asked.tip_to_rim_m > 0.0 { 2 } else { 1 };
    let drops = front.drops();
    let most = drops.len() / per_layer;
    let layers = asked.layers.unwrap_or(most);
    if layers == 0 || layers > most {
        let (found, per_layer) = (drops.len(), per_layer);
        return Err(CalibrateError::TooFewDrops {
            found,
            asked: layers.max(1),
            per_layer,
            least_n: front.least_fall_n(),
        });
    }
    let drops = largest_drops(drops, layers * per_layer);
    let tips: Vec<usize> = drops.iter().step_by(per_layer).map(|drop| drop.gap).collect();
    let rims = drops.iter().skip(1).step_by(2).map(|drop| Some(drop.gap));
    let rim = if per_layer == 2 { rims.collect() } else { vec![None; layers] };
    let places = Places { tip: tips.iter().map(|&gap| Some(gap)).collect(), rim };
    let spec = |cut_part: f64| AxialSpec {
        law: ForceLaw::Version2,
        layers: stack(front, curve, &tips, cut_part),
        tip_to_rim_m: asked.tip_to_rim_m,
        presliding_stiffness_n_per_m: 2000.0,
        speed_window_s: 0.0,
        damping_time_s: 0.0,
        rate: None,
        breakaway: None,
    };
    Ok([0.0, 0.5, 0.9].map(|part| Guess { spec: spec(part), places: places.clone() }))
}

/// Layers whose boundaries rupture in these gaps; `cut_part` of the force left after a drop is
/// cutting, not a tent.
fn stack(front: &Front, curve: &Curve, tips: &[usize], cut_part: f64) -> Vec<Layer> {
    let mut depth_m = 0.0;
    let mut layers: Vec<Layer> = Vec::new();
    for (at, &gap) in tips.iter().enumerate() {
        let since = at.checked_sub(1).map_or(0, |before| tips[before] + 1);
        let left_n = if at == 0 { 0.0 } else { cut_part * front.force_n[since].max(0.0) };
        let x_m = front.middle_m(gap);
        let tent_n = (front.force_n[gap] - left_n).max(0.0);
        let middle = (since + gap) / 2;
        let half = if gap.saturating_sub(middle) >= 3 { middle } else { since };
        let mut stiffness = rise_n_per_m(front, half, gap).max(LEAST_STIFFNESS_N_PER_M);
        if at == 0 {
            stiffness = (tent_n / x_m.max(1e-6)).max(LEAST_STIFFNESS_N_PER_M);
        } else {
            let boundary_m = (x_m - tent_n / stiffness).max(depth_m).min(x_m);
            layers[at - 1].thickness_m = boundary_m - depth_m;
            layers[at - 1].cutting_n = left_n;
            depth_m = boundary_m;
        }
        layers.push(Layer {
            name: format!("layer {}", at + 1),
            thickness_m: curve.deepest_m() + BELOW_M - depth_m,
            stiffness_n_per_m: stiffness,
            damping_n_s_per_m2: 0.0,
            tip_rupture_n: tent_n,
            rim_rupture_n: tent_n,
            friction_n_per_m: 1.0,
            cutting_n: 0.01,
            options: LayerOptions::default(),
        });
    }
    layers
}

/// The `count` drops with the largest fall, in order of depth.
pub(super) fn largest_drops(mut drops: Vec<Drop>, count: usize) -> Vec<Drop> {
    drops.sort_by(|a, b| b.fall_n.total_cmp(&a.fall_n));
    drops.truncate(count);
    drops.sort_by_key(|drop| drop.gap);
    drops
}

/// A rupture of the starting scene that occurs alone or leads a cascade.
#[derive(Clone, Copy)]
pub(super) struct Leader {
    pub contactor: Contactor,
    pub boundary: usize,
    pub x_m: f64,
}

/// A guess from a scene: its ruptures are moved to the nearest drops, in order, and the others
/// between them are moved along.
pub(super) fn laid_over(front: &Front, start: &AxialSpec) -> Result<Guess, CalibrateError> {
    let leaders = find_leaders(front, start);
    if leaders.is_empty() {
        let deepest_mm = front.depth_m.last().map_or(0.0, |x| x * 1e3);
        return Err(CalibrateError::StartBeyondCurve { deepest_mm });
    }
    let drops = largest_drops(front.drops(), leaders.len());
    let pairs = pair(front, &leaders, &drops);
    Ok(move_place(front, start, leaders.iter().map(|leader| (*leader, moved_m(front, leader.x_m, &pairs)))))
}

/// A scene with its ruptures moved to these depths in m, in order.
pub(super) fn move_place(front: &Front, start: &AxialSpec, ruptures: impl Iterator<Item = (Leader, f64)>) -> Guess {
    let mut spec = start.clone();
    let count = spec.layers.len();
    let mut places = Places { tip: vec![None; count], rim: vec![None; count] };
    for (leader, to_m) in ruptures {
        let gap = front.nearest_gap(to_m);
        match leader.contactor {
            Contactor::Tip => {
                places.tip[leader.boundary] = Some(gap);
                move_boundary(&mut spec.layers, leader.boundary, to_m - leader.x_m);
            }
            Contactor::Rim => places.rim[leader.boundary] = Some(gap),
        }
    }
    Guess { spec, places }
}

pub(super) fn find_leaders(front: &Front, start: &AxialSpec) -> Vec<Leader> {
    let (first_m, last_m) = match (front.depth_m.first(), front.depth_m.last()) {
        (Some(first), Some(last)) => (*first, *last),
        _ => return Vec::new(),
    };
    let ruptures = closed_form::predict_ruptures(start);
    let cascades = ruptures.chunk_by(|a, b| a.x_m.total_cmp(&b.x_m).is_eq()).filter_map(|cascade| cascade.first());
    cascades
        .filter(|rupture| (first_m..last_m).contains(&rupture.x_m))
        .map(|rupture| Leader { contactor: rupture.contactor, boundary: rupture.boundary, x_m: rupture.x_m })
        .collect()
}

/// Pairs (rupture of the start, drop of the curve), both in m: the order-preserving assignment of
/// every drop to a rupture of its own with the smallest sum of distances, by dynamic programming
/// over both lists.
fn pair(front: &Front, leaders: &[Leader], drops: &[Drop]) -> Vec<(f64, f64)> {
    let distance = |l: usize, d: usize| (leaders[l].x_m - front.middle_m(drops[d].gap)).abs();
    // best[d][l]: the first d drops assigned among the first l ruptures.
    let mut best = vec![vec![f64::INFINITY; leaders.len() + 1]; drops.len() + 1];
    best[0].fill(0.0);
    for d in 1..=drops.len() {
        for l in d..=leaders.len() {
            best[d][l] = best[d][l - 1].min(best[d - 1][l - 1] + distance(l - 1, d - 1));
        }
    }
    let (mut d, mut l) = (drops.len(), leaders.len());
    let mut pairs = Vec::new();
    while d > 0 && l > 0 {
        if best[d][l] < best[d][l - 1] {
            pairs.push((leaders[l - 1].x_m, front.middle_m(drops[d - 1].gap)));
            d -= 1;
        }
        l -= 1;
    }
    pairs.reverse();
    pairs
}

/// New position of a rupture: interpolated linearly between the pairs on either side of it.
fn moved_m(front: &Front, x_m: f64, pairs: &[(f64, f64)]) -> f64 {
    let after = pairs.partition_point(|pair| pair.0 < x_m);
    let shift = |pair: &(f64, f64)| pair.1 - pair.0;
    let by_m = match (after.checked_sub(1).and_then(|at| pairs.get(at)), pairs.get(after)) {
        (Some(low), Some(high)) => {
            let part = (x_m - low.0) / (high.0 - low.0);
            shift(low) + part * (shift(high) - shift(low))
        }
        (Some(only), None) | (None, Some(only)) => shift(only),
        (None, None) => 0.0,
    };
    let (first_m, last_m) = (front.middle_m(0), front.middle_m(front.gaps() - 1));
    (x_m + by_m).max(first_m).min(last_m)
}

/// Moves a boundary below the first by `by_m`, as far as its neighbours leave room. The skin stays
/// at 0.
fn move_boundary(layers: &mut [Layer], boundary: usize, by_m: f64) {
    if let Some([above, layer]) = boundary.checked_sub(1).and_then(|at| layers.get_mut(at..=boundary)) {
        let by_m = by_m.max(-above.thickness_m).min(layer.thickness_m);
        above.thickness_m += by_m;
        layer.thickness_m -= by_m;
    }
}
