//! One step of the law.

use super::adhesion::{Adhesion, FrictionCaps, FrictionTick, Slid};
use super::book::{BookedTick, book_tick};
use super::damping::{Damped, DampingTick};
use super::options::RuptureCriterion;
use super::params::{AxialParams, AxialSpec, ForceLaw, RateDependence};
use super::path::{Open, Path, TentedBoundary, lay_boundaries};
use super::relaxation::{BranchedBoundary, Branches, HeldBranches, RelaxedTent, RelaxedTents, TentMotion};
use super::speed_window::TimedDisplacement;
use super::springs::{Cut, SpringTick, SpringWork, cut};
use super::state::{AxialInput, AxialOutput, AxialScratch, AxialStanding, AxialState, Contactor, LastSample, Rupture};

/// A displacement beyond this, in m, indicates a broken device.
const MAX_DISPLACEMENT_M: f64 = 1e3;
/// Maximum path factor, 1/cos θ.
const MAX_PATH_FACTOR: f64 = 1e3;

/// Motion of an accepted sample: since the last one, and over the scene's window of speed.
struct AxialMotion {
    dx_m: f64,
    /// Time since the last sample, in s.
    dt_s: f64,
    v_m_per_s: f64,
}

/// A tick with its ruptures resolved.
struct ResolvedTick {
    open: Open,
    x_m: f64,
    motion: AxialMotion,
    /// The remaining branches.
    held: HeldBranches,
}

/// One step of the axial law. An invalid input changes nothing: the last output is returned, marked
/// as held.
pub fn step(
    params: &AxialParams,
    state: &mut AxialState,
    scratch: &mut AxialScratch,
    input: &AxialInput,
) -> AxialOutput {
    scratch.ruptures.clear();
    let Some(motion) = accept_motion(params, state, input) else {
        return AxialOutput { held: true, ..state.last_output() };
    };
    scratch.incidence = input.incidence;
    let AxialScratch { ruptures, boundaries_m, .. } = scratch;
    let AxialInput { t_s, x_m, incidence } = *input;
    let spec = params.spec();
    lay_boundaries(&spec.layers, &incidence, boundaries_m);
    let path = Path::new(spec, boundaries_m, incidence).under_edge(state.edge);

    let mut relaxed = relax_tents(&path, state, x_m, &motion);
    let dented_j = path.energy_j(state.open(), x_m) + relaxed.stored_j();
    let elastic_work_j = dented_j - state.ledger.elastic_j() + relaxed.lost_j();
    let thresholds = Thresholds { rate: spec.rate, speed_m_per_s: motion.v_m_per_s.abs() };
    let mut open = state.open();
    // Withdrawal ruptures nothing. Without rate dependence this changes no bit: any boundary that a
    // smaller tent could open is open.
    if motion.dx_m >= 0.0 {
        open = open_reached_boundaries(&Tenting { path: &path, x_m, at: &thresholds }, open, &mut relaxed, ruptures);
    }
    let at = ResolvedTick { open, x_m, motion, held: relaxed.held };
    let Forces { output, front_m, damping_n_s_per_m, damped, friction, adhesion, cutting } =
        forces_after_ruptures(params, &path, state, &at);

    let tick = BookedTick {
        open,
        x_m,
        elastic_work_j,
        relaxed: &relaxed,
        before: state.last_output(),
        after: output,
        viscous: damped.work,
        friction,
        cutting,
        presliding_j: stored_energy_j(spec, &output) + damped.stored_j,
    };
    book_tick(&mut state.ledger, &path, &tick, ruptures);
    state.tip_open = open.tip;
    state.rim_open = open.rim;
    state.deepest_m = state.deepest_m.max(output.depth_m);
    state.front_m = front_m;
    state.held = relaxed.held;
    state.adhesion = adhesion;
    state.damping_n_s_per_m = damping_n_s_per_m;
    state.window.push(TimedDisplacement { t_s, x_m }, spec.speed_window_s);
    state.last = Some(LastSample { t_s, x_m, output });
    output
}

/// Energy stored by the presliding springs, in J. Version 1 has no cutting spring.
fn stored_energy_j(spec: &AxialSpec, output: &AxialOutput) -> f64 {
    let spring_j = |force_n| SpringTick::stored_j(spec.presliding_stiffness_n_per_m, force_n);
    match spec.law {
        ForceLaw::Version1 => spring_j(output.friction_n),
        ForceLaw::Version2 | ForceLaw::Version3 | ForceLaw::Version4 | ForceLaw::Version5 => {
            spring_j(output.friction_n) + spring_j(output.cutting_n)
        }
    }
}

/// Predicts the output `dt_s` after the last good sample if the needle kept its velocity; changes
/// no state.
///
/// For consumers that receive the law's samples at a lower rate: boundaries that would rupture in
/// between do so in the prediction. `scratch` is that of the last step. The predicted ruptures are
/// left in it.
#[must_use]
pub fn forecast_standing(
    params: &AxialParams,
    state: &AxialState,
    scratch: &mut AxialScratch,
    dt_s: f64,
) -> AxialStanding {
    let now = state.standing();
    scratch.ruptures.clear();
    let v_m_per_s = now.output.v_m_per_s;
    let (Some(last), true) = (&state.last, dt_s > 0.0 && dt_s.is_finite()) else { return now };
    let AxialScratch { ruptures, boundaries_m, incidence } = scratch;
    let path = Path::new(params.spec(), boundaries_m, *incidence).under_edge(state.edge);
    let motion = AxialMotion { dx_m: v_m_per_s * dt_s, dt_s, v_m_per_s };
    let x_m = last.x_m + motion.dx_m;
    let thresholds = Thresholds { rate: params.spec().rate, speed_m_per_s: v_m_per_s.abs() };
    let mut open = state.open();
    let mut relaxed = relax_tents(&path, state, x_m, &motion);
    if motion.dx_m >= 0.0 {
        open = open_reached_boundaries(&Tenting { path: &path, x_m, at: &thresholds }, open, &mut relaxed, ruptures);
    }
    let at = ResolvedTick { open, x_m, motion, held: relaxed.held };
    let output = forces_after_ruptures(params, &path, state, &at).output;
    AxialStanding { tip_open: open.tip, rim_open: open.rim, output }
}

/// The motion since the last good sample, or `None` for an implausible one. Both differences are 0
/// on the first.
fn accept_motion(params: &AxialParams, state: &AxialState, input: &AxialInput) -> Option<AxialMotion> {
    let believable = state.is_later(input.t_s)
        && input.x_m.abs() <= MAX_DISPLACEMENT_M
        && input.incidence.is_believable(MAX_PATH_FACTOR);
    believable.then(|| {
        state.last.as_ref().map_or(AxialMotion { dx_m: 0.0, dt_s: 0.0, v_m_per_s: 0.0 }, |last| {
            let latest = TimedDisplacement { t_s: last.t_s, x_m: last.x_m };
            let from = state.window.reference(input.t_s, params.spec().speed_window_s).unwrap_or(latest);
            AxialMotion {
                dx_m: input.x_m - last.x_m,
                dt_s: input.t_s - last.t_s,
                v_m_per_s: (input.x_m - from.x_m) / (input.t_s - from.t_s),
            }
        })
    })
}

/// Advances the branches of both tents to the end of a tick, before its ruptures. At the first
/// sample existing tents have relaxed.
fn relax_tents(path: &Path<'_>, state: &AxialState, x_m: f64, motion: &AxialMotion) -> RelaxedTents {
    let open = state.open();
    let mut relaxed = RelaxedTents { held: state.held, ..RelaxedTents::default() };
    let Some(last) = &state.last else { return relaxed };
    let relax = |branches: &mut Branches, boundary: usize, [from, to]: [TentedBoundary; 2]| {
        let Some(layer) = path.layers.get(boundary).filter(|layer| layer.options.relaxes()) else {
            *branches = Branches::default();
            return RelaxedTent::default();
        };
        let tent = TentMotion {
            from_m: from.deflection_m,
            to_m: to.deflection_m,
            dx_m: motion.dx_m,
            dt_s: motion.dt_s,
            spring_n: to.force_n,
        };
        let stiffness_n_per_m = path.stiffness_n_per_m(layer);
        let beside = BranchedBoundary { branches: &layer.options.branches, stiffness_n_per_m };
        let lost_j = branches.relax(&beside, &tent);
        RelaxedTent { boundary, stored_j: branches.stored_j(&beside), lost_j }
    };
    relaxed.tip = relax(&mut relaxed.held.tip, open.tip, [path.tip(open, last.x_m), path.tip(open, x_m)]);
    relaxed.rim = relax(&mut relaxed.held.rim, open.rim, [path.rim(open, last.x_m), path.rim(open, x_m)]);
    relaxed
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

/// Inputs of the rupture checks of a tick.
struct Tenting<'a> {
    path: &'a Path<'a>,
    x_m: f64,
    at: &'a Thresholds,
}

/// Opens every boundary whose threshold is reached: tips in boundary order, then rims. Each pass of
/// the inner loop opens one boundary, so it is bounded by the number of layers.
fn open_reached_boundaries(
    tenting: &Tenting<'_>,
    mut open: Open,
    relaxed: &mut RelaxedTents,
    ruptures: &mut Vec<Rupture>,
) -> Open {
    for contactor in [Contactor::Tip, Contactor::Rim] {
        while let Some((rupture, next)) = tenting.next_rupture(open, relaxed, contactor) {
            ruptures.push(rupture);
            relaxed.give_way(contactor);
            open = next;
        }
    }
    open
}

impl Tenting<'_> {
    /// The rupture that a contactor causes, if any, and the open boundaries after it.
    fn next_rupture(&self, open: Open, relaxed: &RelaxedTents, contactor: Contactor) -> Option<(Rupture, Open)> {
        let Self { path, x_m, at } = *self;
        let (boundary, tent, stored_j) = match contactor {
            Contactor::Tip => (open.tip, path.tip(open, x_m), relaxed.tip.stored_j),
            Contactor::Rim => (open.rim, path.rim(open, x_m), relaxed.rim.stored_j),
        };
        let layer = path.layers.get(boundary)?;
        let (slow_n, next) = match contactor {
            Contactor::Tip => (layer.tip_rupture_n, Open { tip: boundary + 1, ..open }),
            Contactor::Rim => (layer.rim_rupture_n, Open { rim: boundary + 1, ..open }),
        };
        let force_n = tent.force_n + relaxed.held.of(contactor).force_n();
        let judged_n = match layer.options.gives_way_at {
            RuptureCriterion::Force => force_n,
            RuptureCriterion::Dent => tent.force_n,
        };
        (tent.deflection_m > 0.0 && judged_n >= at.speed_threshold_n(path.threshold_n(layer, slow_n))).then(|| {
            let dissipated_j = path.energy_j(open, x_m) - path.energy_j(next, x_m) + stored_j;
            (Rupture { contactor, boundary, force_n, x_m, dissipated_j }, next)
        })
    }
}

/// The forces of a tick, and the work of its dashpots and presliding springs.
struct Forces {
    output: AxialOutput,
    /// The cutting front, in m.
    front_m: Option<f64>,
    /// Σ b_j l_j, in N·s/m.
    damping_n_s_per_m: f64,
    damped: Damped,
    friction: SpringWork,
    adhesion: Adhesion,
    cutting: SpringWork,
}

/// The forces with the state after the ruptures.
fn forces_after_ruptures(params: &AxialParams, path: &Path<'_>, state: &AxialState, at: &ResolvedTick) -> Forces {
    let depth_m = path.depth_m(at.open, at.x_m);
    let mut damping_n_s_per_m = 0.0;
    let mut caps = FrictionCaps { kinetic_n: 0.0, static_n: 0.0 };
    for (layer, inserted_m) in path.inserted(depth_m) {
        damping_n_s_per_m += layer.damping_n_s_per_m2 * inserted_m;
        caps.kinetic_n += layer.friction_n_per_m * inserted_m;
        caps.static_n += layer.static_friction_n_per_m() * inserted_m;
    }
    let Slid { force_n: friction_n, work: friction, adhesion } = friction_force(params, state, at, caps);
    let damped = damp(params, state, at, damping_n_s_per_m);
    let (Cut { force_n: cutting_n, front_m }, cutting) = cut_tissue(params, path, state, at);
    let output = AxialOutput {
        v_m_per_s: at.motion.v_m_per_s,
        // The pull of the branches has been removed up to round-off.
        tip_n: (path.tip(at.open, at.x_m).force_n + at.held.tip.force_n()).max(0.0),
        rim_n: (path.rim(at.open, at.x_m).force_n + at.held.rim.force_n()).max(0.0),
        viscous_n: damped.force_n,
        friction_n,
        cutting_n,
        depth_m,
        held: false,
    };
    Forces { output, front_m, damping_n_s_per_m, damped, friction, adhesion, cutting }
}

/// Damping of a shaft with Σ b_j l_j, by the version of the scene.
fn damp(params: &AxialParams, state: &AxialState, at: &ResolvedTick, damping_n_s_per_m: f64) -> Damped {
    let spec = params.spec();
    if spec.law < ForceLaw::Version5 {
        let force_n = at.motion.v_m_per_s * damping_n_s_per_m;
        let work_j = force_n * at.motion.dx_m;
        return Damped { force_n, stored_j: 0.0, work: SpringWork { work_j, lost_j: work_j } };
    }
    let tick = DampingTick {
        time_s: spec.damping_time_s,
        before_n: state.last_output().viscous_n,
        from_n_s_per_m: state.damping_n_s_per_m,
        to_n_s_per_m: damping_n_s_per_m,
        dx_m: at.motion.dx_m,
        dt_s: at.motion.dt_s,
    };
    tick.advance()
}

/// Friction, by the version of the scene: a presliding spring within a cap.
fn friction_force(params: &AxialParams, state: &AxialState, at: &ResolvedTick, caps: FrictionCaps) -> Slid {
    let spec = params.spec();
    let stiffness_n_per_m = spec.presliding_stiffness_n_per_m;
    let (before_n, dx_m) = (state.last_output().friction_n, at.motion.dx_m);
    if spec.law == ForceLaw::Version1 {
        let force_n = (before_n + stiffness_n_per_m * dx_m).max(-caps.kinetic_n).min(caps.kinetic_n);
        let stored_j = |force_n| SpringTick::stored_j(stiffness_n_per_m, force_n);
        let work_j = force_n * dx_m;
        let work = SpringWork { work_j, lost_j: (work_j - (stored_j(force_n) - stored_j(before_n))).max(0.0) };
        return Slid { force_n, work, adhesion: Adhesion::default() };
    }
    let tick = FrictionTick { stiffness_n_per_m, before_n, dx_m, dt_s: at.motion.dt_s, caps };
    spec.breakaway.as_ref().map_or_else(|| tick.slide(), |breakaway| tick.slide_with(breakaway, state.adhesion))
}

/// Cutting, by the version of the scene.
fn cut_tissue(params: &AxialParams, path: &Path<'_>, state: &AxialState, at: &ResolvedTick) -> (Cut, SpringWork) {
    let depth_m = path.depth_m(at.open, at.x_m);
    let cap_n = path.layer_at(depth_m).and_then(|layer| path.layers.get(layer)).map_or(0.0, |layer| layer.cutting_n);
    match params.spec().law {
        ForceLaw::Version1 => {
            let tents = path.tip(at.open, at.x_m).deflection_m > 0.0;
            let cuts = at.motion.dx_m > 0.0 && depth_m > state.deepest_m && !tents;
            let force_n = if cuts { cap_n } else { 0.0 };
            let work_j = force_n * at.motion.dx_m;
            (Cut { force_n, front_m: None }, SpringWork { work_j, lost_j: work_j })
        }
        ForceLaw::Version2 | ForceLaw::Version3 | ForceLaw::Version4 | ForceLaw::Version5 => {
            drag_front(params, state, at, cap_n)
        }
    }
}

/// The cutting spring from version 2 on. Its front starts at the needle's position in the tick that
/// opens the skin.
fn drag_front(params: &AxialParams, state: &AxialState, at: &ResolvedTick, cap_n: f64) -> (Cut, SpringWork) {
    let stiffness_n_per_m = params.spec().presliding_stiffness_n_per_m;
    let before_m = if state.tip_open == 0 && at.open.tip > 0 { Some(at.x_m) } else { state.front_m };
    let now = cut(before_m, at.x_m, stiffness_n_per_m, cap_n);
    let before_n = state.last_output().cutting_n;
    let dragged = now.front_m != before_m;
    let kept_n = if dragged { before_n.min(cap_n) } else { before_n };
    let slid_m = match (now.front_m, before_m) {
        (Some(now_m), Some(before_m)) if dragged => now_m - before_m - (before_n - kept_n) / stiffness_n_per_m,
        _ => 0.0,
    };
    (now, SpringTick { stiffness_n_per_m, before_n, kept_n, after_n: now.force_n, slid_m }.integrate())
}
