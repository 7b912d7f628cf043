//! Other starts: the same interpretation of the curve with a boundary, or a rupture within its gap,
//! moved.

use super::drops::Front;
use super::model::{CurveModel, Guess, Places, QUANTITIES};
use super::peaks::is_near;

/// Positions at which a boundary is tried: fractions of the distance from the boundary above to the
/// previous rupture, where the bend is hidden, and from there to its own rupture, where the curve
/// shows the bend.
const HIDDEN: [f64; 2] = [0.1, 0.7];
const SHOWN: [f64; 4] = [0.2, 0.5, 0.8, 0.93];
/// Positions within its gap at which a rupture is tried.
const IN_GAP: [f64; 2] = [0.1, 0.9];
/// Positions between its neighbours at which a rupture without a drop is tried.
const ALONG: [f64; 8] = [0.06, 0.18, 0.3, 0.42, 0.54, 0.66, 0.78, 0.9];
/// Columns of a layer's variables.
const THICKNESS: usize = 0;
const STIFFNESS: usize = 1;
const FRICTION: usize = 2;
const CUTTING: usize = 3;
const TIP: usize = 4;
/// Factors that are tried on a layer's friction.
const LESS: f64 = 0.3;
const MORE: f64 = 2.5;

/// All other starts.
pub(super) fn other_starts(model: &CurveModel<'_>, guess: &Guess) -> Vec<Guess> {
    let layers = guess.spec.layers.len();
    let boundaries = (1..layers).flat_map(|boundary| elsewhere(model, guess, boundary));
    let resistances = (0..layers).flat_map(|layer| shared_otherwise(model, guess, layer));
    let places = moved_in_gap(model, guess).into_iter().chain(hidden_elsewhere(model, guess));
    boundaries.chain(places).chain(exchanged(model, guess)).chain(resistances).collect()
}

/// Guesses with one rupture that shows no drop moved between its neighbours.
fn hidden_elsewhere(model: &CurveModel<'_>, guess: &Guess) -> Vec<Guess> {
    let (drops, last) = (model.front.drops(), model.front.gaps().saturating_sub(1));
    let Places { tip, rim } = &guess.places;
    let mut guesses = Vec::new();
    for (row, is_tip) in [(tip, true), (rim, false)] {
        for (layer, gap) in row.iter().enumerate() {
            let Some(gap) = gap.filter(|&gap| !drops.iter().any(|drop| is_near(drop.gap, gap))) else { continue };
            let before = row[..layer].iter().flatten().last().copied().unwrap_or(0);
            let from = if is_tip { before } else { before.max(tip[layer].unwrap_or(0)) };
            let to = row[layer + 1..].iter().flatten().next().copied().unwrap_or(last);
            for part in ALONG {
                let moved = from + (part * to.saturating_sub(from) as f64) as usize;
                let mut places = guess.places.clone();
                let row = if is_tip { &mut places.tip } else { &mut places.rim };
                row[layer] = Some(moved);
                if moved != gap {
                    guesses.push(Guess { spec: guess.spec.clone(), places });
                }
            }
        }
    }
    guesses
}

/// Guesses with one boundary moved: everything below stays, ruptures keep their places. Its
/// stiffness is the slope of the force from there, or the one at which it bears the same force.
fn elsewhere(model: &CurveModel<'_>, guess: &Guess, boundary: usize) -> Vec<Guess> {
    let columns = QUANTITIES.len();
    let (above, own) = ((boundary - 1) * columns, boundary * columns);
    let (Some(gap), Some(before)) = (guess.places.tip[boundary], guess.places.tip[boundary - 1]) else {
        return Vec::new();
    };
    let variables = model.variables(guess);
    let above_m: f64 = variables[..above].iter().step_by(columns).sum();
    let (depth_m, rupture_m) = (above_m + variables[above], variables[own + TIP]);
    let before_m = variables[above + TIP].max(above_m).min(rupture_m);
    let carried_n = variables[own + STIFFNESS] * (rupture_m - depth_m);
    let hidden = HIDDEN.map(|part| above_m + part * (before_m - above_m));
    let shown = SHOWN.map(|part| before_m + part * (rupture_m - before_m));
    let mut guesses = Vec::new();
    for moved_m in hidden.into_iter().chain(shown).filter(|moved_m| *moved_m < rupture_m) {
        let from = model.front.nearest_gap(moved_m).max(before + 1).min(gap.saturating_sub(1));
        let rise_n_per_m = rise_n_per_m(&model.front, from, gap);
        for stiffness in [rise_n_per_m, carried_n / (rupture_m - moved_m)] {
            let mut trial = variables.clone();
            trial[above + THICKNESS] = moved_m - above_m;
            trial[own + THICKNESS] = (variables[own + THICKNESS] - (moved_m - depth_m)).max(0.0);
            trial[own + STIFFNESS] = stiffness.max(LEAST_STIFFNESS_N_PER_M);
            guesses.push(Guess { spec: model.spec(guess, &trial), places: guess.places.clone() });
        }
    }
    guesses
}

/// Guesses with one rupture moved within its gap.
fn moved_in_gap(model: &CurveModel<'_>, guess: &Guess) -> Vec<Guess> {
    let (variables, (lower, upper)) = (model.variables(guess), model.bounds(guess));
    let mut guesses = Vec::new();
    for which in (0..variables.len()).filter(|which| which % QUANTITIES.len() >= TIP && lower[*which] < upper[*which]) {
        for part in IN_GAP {
            let mut trial = variables.clone();
            trial[which] = lower[which] + part * (upper[which] - lower[which]);
            guesses.push(Guess { spec: model.spec(guess, &trial), places: guess.places.clone() });
        }
    }
    guesses
}

/// Guesses with a layer's resistance divided differently between friction and cutting. Behind its
/// rupture both springs stretch, and the curve may not show which of the two reaches its cap first;
/// their sum there, and everything below the layer, stays.
fn shared_otherwise(model: &CurveModel<'_>, guess: &Guess, layer: usize) -> Vec<Guess> {
    let (columns, variables) = (QUANTITIES.len(), model.variables(guess));
    let own = layer * columns;
    let depth_m: f64 = variables[..own].iter().step_by(columns).sum();
    let length_m = variables[own + TIP] - depth_m;
    if guess.places.tip[layer].is_none() || length_m <= 0.0 {
        return Vec::new();
    }
    let (friction, cutting_n) = (variables[own + FRICTION], variables[own + CUTTING]);
    let shared = |friction_n_per_m: f64| {
        let more = friction_n_per_m - friction;
        let mut trial = variables.clone();
        trial[own + FRICTION] = friction_n_per_m;
        trial[own + CUTTING] = (cutting_n - more * length_m).max(0.0);
        for below in (own + columns..trial.len()).step_by(columns) {
            trial[below + CUTTING] = (trial[below + CUTTING] - more * variables[own + THICKNESS]).max(0.0);
        }
        Guess { spec: model.spec(guess, &trial), places: guess.places.clone() }
    };
    [cutting_n / length_m, LESS * friction, MORE * friction].map(shared).into()
}

/// Guesses with the ruptures of a rim and of the next boundary under the tip exchanged: no drop
/// shows which of the two comes first.
fn exchanged(model: &CurveModel<'_>, guess: &Guess) -> Vec<Guess> {
    let mut guesses = Vec::new();
    let pairs =
        (0..guess.spec.layers.len()).flat_map(|rim| (rim + 1..guess.spec.layers.len()).map(move |tip| (tip, rim)));
    for (tip, rim) in pairs {
        let (Some(tip_gap), Some(rim_gap)) = (guess.places.tip[tip], guess.places.rim[rim]) else { continue };
        let mut places = guess.places.clone();
        (places.tip[tip], places.rim[rim]) = (Some(rim_gap), Some(tip_gap));
        if places.tip.iter().flatten().is_sorted() && places.rim.iter().flatten().is_sorted() {
            let mut variables = model.variables(guess);
            variables.swap(tip * QUANTITIES.len() + TIP, rim * QUANTITIES.len() + TIP + 1);
            let exchanged = Guess { spec: guess.spec.clone(), places };
            guesses.push(Guess { spec: model.spec(&exchanged, &variables), ..exchanged });
        }
    }
    guesses
}

/// Minimum stiffness of a start, in N/m.
pub(super) const LEAST_STIFFNESS_N_PER_M: f64 = 5.0;

/// The slope of the force between two samples of the front, both included, in N/m.
pub(super) fn rise_n_per_m(front: &Front, from: usize, to: usize) -> f64 {
    let count = (from..=to).count().max(1) as f64;
    let mean = |values: &[f64]| values[from..=to].iter().sum::<f64>() / count;
    if from >= to {
        return 0.0;
    }
    let (mean_x, mean_f) = (mean(&front.depth_m), mean(&front.force_n));
    let (mut joint, mut spread) = (0.0, 0.0);
    for at in from..=to {
        let dx = front.depth_m[at] - mean_x;
        joint += dx * (front.force_n[at] - mean_f);
        spread += dx * dx;
    }
    if spread > 0.0 { joint / spread } else { 0.0 }
}
