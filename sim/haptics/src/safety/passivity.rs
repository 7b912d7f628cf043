//! Time-domain passivity: an energy observer at the handle, and a damper that takes back what was given too much.
//!
//! After Hannaford and Ryu (2002). The force sent in one tick acts until the next, so the handle's work on the device over a tick
//! is exactly −F·Δx with the force that acted. Two accounts are kept of it.
//! The handle's motion is that of [`super::follower`], since an encoder's step is none.
//!
//! *Sampling.* A law drawn with a straight line between its samples would have taken −½(F₀ + F₁)·Δx. What was taken less than that
//! is energy that sampling, delay and the links behind this one made up: for a wall of stiffness K it is ½ K Δx² a tick, the
//! −K T/2 of [`super::wall`]. Nothing is saved up here, so it is taken back at once, however much the tissue dissipated before.
//!
//! *Port.* What was given in all must not exceed what was taken. It holds for any law, but what the tissue dissipated would count
//! as credit; so the credit is capped by what a body that pushes with F can have stored, F²/2k, k the softest stiffness. F is what
//! the law wants, not what is let through: what the hand has paid before its force was cut it may have back when the force comes
//! back, and no more ([`PassivityState::account`]).

use nalgebra::Vector3;

use super::follower::{Followed, Follower};
use super::gate::Account;

/// Damping that is reported, in N: a fifth of the friction of a haptic arm.
pub const FELT_N: f64 = 0.05;
/// What may be given too much while force comes back, in J: a tremor of a twentieth of a millimetre under 1 N.
const OVERDRAFT_J: f64 = 5e-5;
/// Most ticks that a force may take to act, beyond the period it is held for.
const MAX_DELAY: usize = 7;

/// What is known of device and scene.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PassivityParams {
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

impl PassivityParams {
    /// Our choice: one tick of delay is taken for granted, since drivers have it and it costs 5 mN at 10 mm/s in muscle; the
    /// damping stays far below the m/T = 45 N·s/m at which a handle of 45 g would oscillate. With 5 N·s/m it could not pay what presliding springs
    /// and damping deep in a body make up behind a millisecond of delay.
    #[must_use]
    pub fn new(period_s: f64, softest_n_per_m: f64, max_force_n: f64) -> Self {
        let softest_n_per_m = softest_n_per_m.max(1.0);
        Self { period_s, delay_ticks: 1, max_damping_n_s_per_m: 10.0, softest_n_per_m, max_force_n }
    }

    /// Energy that a body pushing with a force can have stored, in J.
    fn stored_j(&self, force_n: f64) -> f64 {
        force_n * force_n / (2.0 * self.softest_n_per_m)
    }
}

/// What the observer remembers.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PassivityState {
    follower: Follower,
    /// Forces sent, the latest first, in N.
    sent_n: [Vector3<f64>; MAX_DELAY + 1],
    /// Damping that went with them, in N·s/m.
    damping_n_s_per_m: [f64; MAX_DELAY + 1],
    /// The law's force at the last tick, in N.
    last_wanted_n: Vector3<f64>,
    /// Both accounts, in J: negative is energy given too much.
    sampling_j: f64,
    port_j: f64,
}

impl PassivityState {
    /// Notes the force that was sent in the end, in N.
    pub fn sent(&mut self, force_n: Vector3<f64>) {
        self.sent_n.rotate_right(1);
        self.sent_n[0] = force_n;
    }

    /// How the account at the port stands, with a force in N owed to the hand.
    #[must_use]
    pub fn account(&self, params: &PassivityParams, owed_n: &Vector3<f64>) -> Account {
        let credit_j = params.stored_j(owed_n.norm());
        match self.port_j {
            port_j if port_j < -OVERDRAFT_J => Account::Overdrawn,
            port_j if port_j >= credit_j || owed_n.norm() <= FELT_N => Account::Settled,
            _ => Account::Open,
        }
    }

    /// Where no force is given any more, nothing is left to damp: what was overdrawn in a last tick is let go. What may be overdrawn is
    /// not granted anew, or a hand that trembles would be fed by each ramp; it pays that back when it pushes.
    pub fn forgive(&mut self) {
        self.sampling_j = 0.0;
        self.port_j = self.port_j.max(-OVERDRAFT_J);
    }

    /// Concludes nothing from where the handle was.
    pub fn forget_position(&mut self) {
        self.follower = Follower::default();
    }

    /// Books a tick's motion, with the law's force at its end.
    fn observe(
        &mut self,
        params: &PassivityParams,
        way_m: &Vector3<f64>,
        wanted_n: &Vector3<f64>,
        owed_n: &Vector3<f64>,
    ) {
        let acted_n = self.sent_n[params.delay_ticks.min(MAX_DELAY)];
        let taken_j = -acted_n.dot(way_m);
        let due_j = -0.5 * (self.last_wanted_n + wanted_n).dot(way_m);
        let floor_j = -params.stored_j(params.max_force_n);
        self.sampling_j = (self.sampling_j + taken_j - due_j).clamp(floor_j, 0.0);
        self.port_j = (self.port_j + taken_j).clamp(floor_j, params.stored_j(owed_n.norm()));
    }

    /// Damping that would pay the debt over a tick of the same motion, in N·s/m: α = E T/Δx², less what is already on its way.
    /// Asked for again, it would be paid twice, and the damping would swing. Δx² is a mean over some ticks, so that damping follows the
    /// motion and not the unevenness that steps leave in it; for the same reason a debt that is seen once in so many ticks is paid
    /// over as many, and as many again.
    fn damping_n_s_per_m(&self, params: &PassivityParams, Followed { square_m2, ticks, .. }: Followed) -> f64 {
        let deficit_j = -self.sampling_j.min(self.port_j).min(0.0);
        let asked = deficit_j * params.period_s / square_m2;
        let on_its_way: f64 = self.damping_n_s_per_m.iter().take(params.delay_ticks.min(MAX_DELAY)).sum();
        let spread = f64::from(ticks.saturating_mul(2) - 1);
        // At rest there is nothing to damp, and no number.
        if asked.is_finite() { ((asked - on_its_way) / spread).clamp(0.0, params.max_damping_n_s_per_m) } else { 0.0 }
    }
}

/// A tick, as the observer sees it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DeviceMotion {
    /// Where the handle is, in m.
    pub position_m: Vector3<f64>,
    /// The force that is to be given, in N.
    pub wanted_n: Vector3<f64>,
    /// The force that the law wants of the device, gate or no gate, in N.
    pub owed_n: Vector3<f64>,
}

/// The force with the damping that the observer asks for, in N, and whether that can be felt.
pub fn step(params: &PassivityParams, state: &mut PassivityState, motion: &DeviceMotion) -> (Vector3<f64>, bool) {
    let DeviceMotion { position_m, wanted_n, owed_n } = motion;
    // The clamp behind this link is as conservative as the law: it belongs to what is due.
    let due_n = super::clamp::norm(wanted_n, params.max_force_n).0;
    let followed = state.follower.follow(*position_m);
    state.observe(params, &followed.way_m, &due_n, owed_n);
    state.last_wanted_n = due_n;
    let damping_n_s_per_m = state.damping_n_s_per_m(params, followed);
    state.damping_n_s_per_m.rotate_right(1);
    state.damping_n_s_per_m[0] = damping_n_s_per_m;
    let damping_n = followed.way_m * (damping_n_s_per_m / params.period_s);
    (wanted_n - damping_n, damping_n.norm() > FELT_N)
}

#[cfg(test)]
#[expect(clippy::float_cmp, reason = "what is left alone is the very same number")]
mod tests {
    //! The damper must pay what sampling makes up and no more, stop a law that only gives, and leave a pop alone. Too little is a
    //! buzz, too much is a wall of honey. What it does to a free handle is shown in `tests/main/passivity.rs`.

    use super::*;

    const PERIOD_S: f64 = 1e-3;
    const WALL_N_PER_M: f64 = 400.0;

    /// Moves along x at a speed in m/s for some ticks against a law of the position in m; wanted and sent forces, in N.
    fn moved(speed_m_per_s: f64, ticks: u32, law_n: impl Fn(f64) -> f64) -> Vec<(f64, f64)> {
        let params = PassivityParams::new(PERIOD_S, WALL_N_PER_M, 3.3);
        let mut state = PassivityState::default();
        let forces = |tick| {
            let x_m = speed_m_per_s * f64::from(tick) * PERIOD_S;
            let wanted_n = law_n(x_m);
            let along = |x: f64| Vector3::new(x, 0.0, 0.0);
            let motion = DeviceMotion { position_m: along(x_m), wanted_n: along(wanted_n), owed_n: along(wanted_n) };
            let (force_n, _) = step(&params, &mut state, &motion);
            state.sent(force_n);
            (wanted_n, force_n.x)
        };
        (0..ticks).map(forces).collect()
    }

    #[test]
    fn a_wall_is_damped_by_what_sampling_and_one_tick_of_delay_ask_for() {
        for speed_m_per_s in [0.005, 0.05] {
            let needs_n_s_per_m = 1.5 * WALL_N_PER_M * PERIOD_S;
            let forces = moved(speed_m_per_s, 150, |x_m| -WALL_N_PER_M * x_m);
            for (wanted_n, force_n) in &forces[100..] {
                let damping_n_s_per_m = (wanted_n - force_n) / speed_m_per_s;
                assert!((damping_n_s_per_m / needs_n_s_per_m - 1.0).abs() < 0.05, "{damping_n_s_per_m} N·s/m");
            }
        }
    }

    #[test]
    fn a_law_that_only_gives_is_damped_as_hard_as_allowed() {
        let forces = moved(0.1, 300, |_| 1.0);
        let (_, last_n) = forces[299];
        assert!((last_n - (1.0 - 10.0 * 0.1)).abs() < 1e-9, "{last_n} N");
    }

    #[test]
    fn a_pop_passes_untouched() {
        let forces = moved(0.02, 300, |x_m| if x_m < 0.003 { -WALL_N_PER_M * x_m } else { 0.0 });
        let after: Vec<f64> =
            forces.iter().filter(|(wanted_n, _)| *wanted_n == 0.0).map(|(_, sent_n)| *sent_n).collect();
        assert!(after.len() > 100 && after.iter().skip(1).all(|sent_n| sent_n.abs() < 1e-9), "{:?}", &after[..5]);
    }

    #[test]
    fn a_handle_at_rest_is_left_alone() {
        assert!(moved(0.0, 10, |_| 2.0).iter().all(|(wanted_n, sent_n)| wanted_n == sent_n));
    }
}
