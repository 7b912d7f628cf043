//! One step of the law.

use super::book::{Tick, book};
use super::params::{AxialParams, RateDependence};
use super::path::{Open, Path, lay_boundaries};
use super::state::{AxialInput, AxialOutput, AxialScratch, AxialState, Contactor, LastSample, Rupture, Standing};

/// A displacement beyond this, in m, is a broken device, not a needle.
const MAX_DISPLACEMENT_M: f64 = 1e3;
/// Largest path factor, 1/cos θ.
const MAX_PATH_FACTOR: f64 = 1e3;

/// Backward differences of an accepted sample.
struct Motion {
    dx_m: f64,
    v_m_per_s: f64,
}

/// Where a tick stands once its ruptures are resolved.
struct Moment {
    open: Open,
    x_m: f64,
    motion: Motion,
}

/// One step of the axial law. A bad input changes nothing: the last output comes back, marked as held.
pub fn step(
    params: &AxialParams,
    state: &mut AxialState,
    scratch: &mut AxialScratch,
    input: &AxialInput,
) -> AxialOutput {
    scratch.ruptures.clear();
    let Some(motion) = accept(state, input) else {
        return AxialOutput { held: true, ..state.last_output() };
    };
    scratch.path_factor = input.path_factor;
    let AxialScratch { ruptures, boundaries_m, .. } = scratch;
    let AxialInput { t_s, x_m, path_factor } = *input;
    let spec = params.spec();
    lay_boundaries(&spec.layers, path_factor, boundaries_m);
    let path = Path::new(spec, boundaries_m, path_factor);

    let elastic_work_j = path.energy_j(state.open(), x_m) - state.ledger.elastic_j();
    let thresholds = Thresholds { rate: spec.rate, speed_m_per_s: motion.v_m_per_s.abs() };
    let mut open = state.open();
    // Withdrawal ruptures nothing. Without rate dependence this changes no bit: what a lesser tent could open is open.
    if motion.dx_m >= 0.0 {
        open = resolve(&path, open, &thresholds, x_m, ruptures);
    }
    let at = Moment { open, x_m, motion };
    let output = forces(params, &path, state, &at);

    let tick = Tick {
        open,
        x_m,
        dx_m: at.motion.dx_m,
        elastic_work_j,
        before: state.last_output(),
        after: output,
        presliding_n_per_m: spec.presliding_stiffness_n_per_m,
    };
    book(&mut state.ledger, &path, &tick, ruptures);
    state.tip_open = open.tip;
    state.rim_open = open.rim;
    state.deepest_m = state.deepest_m.max(output.depth_m);
    state.last = Some(LastSample { t_s, x_m, output });
    output
}

/// What the law would say `dt_s` after the last good sample if the needle kept its velocity; changes nothing.
///
/// For whoever sees the law's samples at a lower rate: boundaries that would give way in between do so in the answer.
/// `scratch` is that of the last step. The ruptures foreseen are left in it.
#[must_use]
pub fn ahead(params: &AxialParams, state: &AxialState, scratch: &mut AxialScratch, dt_s: f64) -> Standing {
    let now = state.standing();
    scratch.ruptures.clear();
    let v_m_per_s = now.output.v_m_per_s;
    let (Some(last), true) = (&state.last, dt_s > 0.0 && dt_s.is_finite()) else { return now };
    let AxialScratch { ruptures, boundaries_m, path_factor } = scratch;
    let path = Path::new(params.spec(), boundaries_m, *path_factor);
    let motion = Motion { dx_m: v_m_per_s * dt_s, v_m_per_s };
    let x_m = last.x_m + motion.dx_m;
    let thresholds = Thresholds { rate: params.spec().rate, speed_m_per_s: v_m_per_s.abs() };
    let mut open = state.open();
    if motion.dx_m >= 0.0 {
        open = resolve(&path, open, &thresholds, x_m, ruptures);
    }
    let output = forces(params, &path, state, &Moment { open, x_m, motion });
    Standing { tip_open: open.tip, rim_open: open.rim, output }
}

/// The motion since the last good sample, or none when this one is not to be believed. Both differences are 0 on the first.
fn accept(state: &AxialState, input: &AxialInput) -> Option<Motion> {
    let believable = state.is_later(input.t_s)
        && input.x_m.abs() <= MAX_DISPLACEMENT_M
        && input.path_factor > 0.0
        && input.path_factor <= MAX_PATH_FACTOR;
    believable.then(|| {
        state.last.as_ref().map_or(Motion { dx_m: 0.0, v_m_per_s: 0.0 }, |last| {
            let dx_m = input.x_m - last.x_m;
            Motion { dx_m, v_m_per_s: dx_m / (input.t_s - last.t_s) }
        })
    })
}

/// Rupture thresholds at the speed of this tick.
struct Thresholds {
    rate: Option<RateDependence>,
    speed_m_per_s: f64,
}

impl Thresholds {
    /// P(v) = P∞ + (P0 − P∞)/(1 + |v|/v0); exactly P0 without rate dependence.
    fn speed_threshold_n(&self, slow_n: f64) -> f64 {
        self.rate.map_or(slow_n, |rate| {
            rate.p_infinity_n + (slow_n - rate.p_infinity_n) / (1.0 + self.speed_m_per_s / rate.v0_m_per_s)
        })
    }
}

/// Opens every boundary whose threshold is reached: tips in boundary order, then rims. Each pass of the inner loop
/// opens one boundary, so it is bounded by the number of layers.
fn resolve(path: &Path<'_>, mut open: Open, at: &Thresholds, x_m: f64, ruptures: &mut Vec<Rupture>) -> Open {
    for contactor in [Contactor::Tip, Contactor::Rim] {
        while let Some((rupture, next)) = next_rupture(path, open, at, (contactor, x_m)) {
            ruptures.push(rupture);
            open = next;
        }
    }
    open
}

/// The rupture that a contactor causes at x, if any, and what is open after it.
fn next_rupture(
    path: &Path<'_>,
    open: Open,
    at: &Thresholds,
    (contactor, x_m): (Contactor, f64),
) -> Option<(Rupture, Open)> {
    let (boundary, tent) = match contactor {
        Contactor::Tip => (open.tip, path.tip(open, x_m)),
        Contactor::Rim => (open.rim, path.rim(open, x_m)),
    };
    let layer = path.layers.get(boundary)?;
    let (slow_n, next) = match contactor {
        Contactor::Tip => (layer.tip_rupture_n, Open { tip: boundary + 1, ..open }),
        Contactor::Rim => (layer.rim_rupture_n, Open { rim: boundary + 1, ..open }),
    };
    (tent.deflection_m > 0.0 && tent.force_n >= at.speed_threshold_n(slow_n)).then(|| {
        let dissipated_j = path.energy_j(open, x_m) - path.energy_j(next, x_m);
        (Rupture { contactor, boundary, force_n: tent.force_n, x_m, dissipated_j }, next)
    })
}

/// The forces with the state after the ruptures.
fn forces(params: &AxialParams, path: &Path<'_>, state: &AxialState, at: &Moment) -> AxialOutput {
    let depth_m = path.depth_m(at.open, at.x_m);
    let (mut damping, mut cap_n) = (0.0, 0.0);
    for (layer, inserted_m) in path.inserted(depth_m) {
        damping += layer.damping_n_s_per_m2 * inserted_m;
        cap_n += layer.friction_n_per_m * inserted_m;
    }
    let tip = path.tip(at.open, at.x_m);
    let trial_n = state.last_output().friction_n + params.spec().presliding_stiffness_n_per_m * at.motion.dx_m;
    let cuts = at.motion.dx_m > 0.0 && depth_m > state.deepest_m && tip.deflection_m <= 0.0;
    let cut = if cuts { path.layer_at(depth_m).and_then(|layer| path.layers.get(layer)) } else { None };
    AxialOutput {
        v_m_per_s: at.motion.v_m_per_s,
        tip_n: tip.force_n,
        rim_n: path.rim(at.open, at.x_m).force_n,
        viscous_n: at.motion.v_m_per_s * damping,
        friction_n: trial_n.max(-cap_n).min(cap_n),
        cutting_n: cut.map_or(0.0, |layer| layer.cutting_n),
        depth_m,
        held: false,
    }
}
