//! Time-domain passivity: an energy observer at the handle, and a damper that takes back what was given too much.
//!
//! After Hannaford and Ryu (2002). The force sent in one tick acts until the next, so the handle's work on the device over a tick
//! is exactly −F·Δx with the force that acted. Two accounts are kept of it.
//!
//! *Sampling.* A law drawn with a straight line between its samples would have taken −½(F₀ + F₁)·Δx. What was taken less than that
//! is energy that sampling, delay and the links behind this one made up: for a wall of stiffness K it is ½ K Δx² a tick, the
//! −K T/2 of [`super::wall`]. Nothing is saved up here, so it is taken back at once, however much the tissue dissipated before.
//!
//! *Port.* What was given in all must not exceed what was taken. It holds for any law, but what the tissue dissipated would count
//! as credit; so the credit is capped by what a body that pushes with F can have stored, F²/2k, k the softest stiffness.

use nalgebra::Vector3;

/// Damping that is reported, in N: a fifth of the friction of a haptic arm.
pub const FELT_N: f64 = 0.05;
/// Most ticks that a force may take to act, beyond the period it is held for.
const MAX_DELAY: usize = 7;

/// What is known of device and scene.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Params {
    /// Tick period, in s.
    pub period_s: f64,
    /// Ticks that pass between sending a force and its acting; at most 7.
    pub delay_ticks: usize,
    /// Strongest damping, in N·s/m.
    pub max_damping_n_s_per_m: f64,
    /// Least stiffness that the scene shows on this device, in N/m.
    pub softest_n_per_m: f64,
    /// Largest force of the device, in N.
    pub max_force_n: f64,
}

impl Params {
    /// Our choice: one tick of delay is taken for granted, since drivers have it and it costs 5 mN at 10 mm/s in muscle; the
    /// damping stays far below the m/T = 45 N·s/m at which a handle of 45 g would oscillate.
    #[must_use]
    pub fn new(period_s: f64, softest_n_per_m: f64, max_force_n: f64) -> Self {
        let softest_n_per_m = softest_n_per_m.max(1.0);
        Self { period_s, delay_ticks: 1, max_damping_n_s_per_m: 5.0, softest_n_per_m, max_force_n }
    }

    /// Energy that a body pushing with a force can have stored, in J.
    fn stored_j(&self, force_n: f64) -> f64 {
        force_n * force_n / (2.0 * self.softest_n_per_m)
    }
}

/// What the observer remembers.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct State {
    last_position_m: Option<Vector3<f64>>,
    /// Forces sent, the latest first, in N.
    sent_n: [Vector3<f64>; MAX_DELAY + 1],
    /// The law's force at the last tick, in N.
    last_wanted_n: Vector3<f64>,
    /// Both accounts, in J: negative is energy given too much.
    sampling_j: f64,
    port_j: f64,
}

impl State {
    /// Notes the force that was sent in the end, in N.
    pub fn sent(&mut self, force_n: Vector3<f64>) {
        self.sent_n.rotate_right(1);
        self.sent_n[0] = force_n;
    }

    /// Concludes nothing from where the handle was.
    pub fn forget_position(&mut self) {
        self.last_position_m = None;
    }

    /// Books a tick's motion, with the law's force at its end.
    fn observe(&mut self, params: &Params, way_m: &Vector3<f64>, wanted_n: &Vector3<f64>) {
        let acted_n = self.sent_n[params.delay_ticks.min(MAX_DELAY)];
        let taken_j = -acted_n.dot(way_m);
        let due_j = -0.5 * (self.last_wanted_n + wanted_n).dot(way_m);
        let floor_j = -params.stored_j(params.max_force_n);
        self.sampling_j = (self.sampling_j + taken_j - due_j).clamp(floor_j, 0.0);
        self.port_j = (self.port_j + taken_j).clamp(floor_j, params.stored_j(wanted_n.norm()));
    }

    fn deficit_j(&self) -> f64 {
        -self.sampling_j.min(self.port_j).min(0.0)
    }
}

/// The force with the damping that the observer asks for, in N, and whether that can be felt.
///
/// The damping is that which would pay the whole debt over a tick of the same motion: α = E T/Δx².
pub fn step(
    params: &Params,
    state: &mut State,
    position_m: &Vector3<f64>,
    wanted_n: &Vector3<f64>,
) -> (Vector3<f64>, bool) {
    // The clamp behind this link is as conservative as the law: it belongs to what is due.
    let due_n = super::clamp::norm(wanted_n, params.max_force_n).0;
    let way_m = state.last_position_m.map_or_else(Vector3::zeros, |last_m| position_m - last_m);
    state.observe(params, &way_m, &due_n);
    state.last_position_m = Some(*position_m);
    state.last_wanted_n = due_n;
    let (deficit_j, way_squared) = (state.deficit_j(), way_m.norm_squared());
    if deficit_j <= 0.0 || way_squared <= 0.0 {
        return (*wanted_n, false);
    }
    let damping_n_s_per_m = (deficit_j * params.period_s / way_squared).min(params.max_damping_n_s_per_m);
    let damping_n = way_m * (damping_n_s_per_m / params.period_s);
    (wanted_n - damping_n, damping_n.norm() > FELT_N)
}
