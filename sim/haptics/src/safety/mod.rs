//! The safety chain between device and force law, and between force law and motors (physics section
//! 5).
//!
//! Before the law, [`believe`] decides which reading counts. After it, [`step`] passes the wanted
//! force through all links in this order: start gate, passivity, clamp, rise limit, thermal budget,
//! watchdog. Each link is a file with its own tests and is independent of the others. Everything
//! here is in the device frame, and forces are in N at the handle.
//!
//! For any input, the output is finite, within the device's maximum force, and zero within
//! [`hold::HoldParams::gone_after_s`] of the last good reading.

pub mod follower;
pub mod gate;
pub mod hold;
pub mod passivity;
pub mod rise;
pub mod thermal;
pub mod wall;
pub mod watchdog;

pub use hold::Believed;
use nalgebra::Vector3;

use crate::clamp;
use crate::device::{DeviceFault, DeviceInfo, Reading};

/// Flags of the changes that the chain made, one bit each. The four lowest bits are left to the
/// samples of a recording.
pub mod flags {
    /// The reading was bad or missing: the last good one is held, or the force is ramping to zero.
    pub const HELD: u32 = 1 << 4;
    /// The force is being ramped in: the gate is not fully open.
    pub const GATED: u32 = 1 << 5;
    /// Damping was added, by more than [`super::passivity::FELT_N`].
    pub const DAMPED: u32 = 1 << 6;
    /// The force exceeded the device's maximum.
    pub const CLAMPED: u32 = 1 << 7;
    /// The force rose faster than allowed.
    pub const RISE_LIMITED: u32 = 1 << 8;
    /// The force was reduced to keep the motors cool.
    pub const THERMAL: u32 = 1 << 9;
    /// The watchdog has cut the force.
    pub const WATCHDOG: u32 = 1 << 10;
    /// The law's force was not finite.
    pub const NOT_FINITE: u32 = 1 << 11;
    /// The hand was given less than half of the force that the law wants of this device, although
    /// that force is perceptible. Separated from the other flags by the bits of
    /// [`crate::servo::flags`].
    pub const UNFELT: u32 = 1 << 16;
    /// All flags of changes by the links.
    pub const ALL: u32 = HELD | GATED | DAMPED | CLAMPED | RISE_LIMITED | THERMAL | WATCHDOG | NOT_FINITE;
}

/// Parameters of all links, constant for an attempt.
#[derive(Clone, Debug, PartialEq)]
pub struct SafetyParams {
    /// Which readings are plausible, and how long the last one is held.
    pub hold: hold::HoldParams,
    /// The ramp of the force; `None` for a virtual device, which cannot hurt anyone.
    pub gate: Option<gate::GateParams>,
    /// Energy observer and damping.
    pub passivity: passivity::PassivityParams,
    /// Maximum force, in N.
    pub max_force_n: f64,
    /// Maximum rise of the force per tick, in N.
    pub max_rise_n: f64,
    /// Thermal budget.
    pub thermal: thermal::ThermalParams,
    /// Deadline supervision; `None` for a virtual device, which cannot hurt anyone.
    pub watchdog: Option<watchdog::WatchdogParams>,
}

impl SafetyParams {
    /// The parameters for a device at a tick rate in Hz. `softest_n_per_m` is the lowest stiffness
    /// that the scene has on this device.
    #[must_use]
    pub fn new(info: &DeviceInfo, rate_hz: f64, softest_n_per_m: f64) -> Self {
        /// Shortest time for a rise from zero to the maximum force, in s (choice): a stab, never a
        /// knock.
        const FULL_RISE_S: f64 = 0.02;
        let period_s = 1.0 / rate_hz;
        let max_force_n = info.max_force_n.max(0.0);
        Self {
            hold: hold::HoldParams::new(period_s),
            gate: (!info.is_virtual).then(gate::GateParams::default),
            passivity: passivity::PassivityParams::new(period_s, softest_n_per_m, max_force_n),
            max_force_n,
            max_rise_n: max_force_n * period_s / FULL_RISE_S,
            thermal: thermal::ThermalParams { period_s, max_force_n, continuous_force_n: info.continuous_force_n },
            watchdog: (!info.is_virtual).then(watchdog::WatchdogParams::default),
        }
    }
}

/// State of the links.
#[derive(Clone, Debug, Default)]
pub struct SafetyState {
    hold: hold::HoldState,
    gate: gate::GateState,
    passivity: passivity::PassivityState,
    thermal: thermal::ThermalState,
    watchdog: watchdog::WatchdogState,
    /// The force sent last, in N.
    sent_n: Vector3<f64>,
}

/// Input of the chain after the law.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SafetyInput {
    /// Time of the servo's clock, in s.
    pub now_s: f64,
    /// Lateness of the tick, in periods.
    pub late_periods: f64,
    /// Whether the device accepted the last force.
    pub connected: bool,
    /// The plausible reading.
    pub believed: Believed,
    /// The law's force, scaled to the device, in N.
    pub wanted_n: Vector3<f64>,
}

/// Output of the chain.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Output {
    /// The force to send, in N.
    pub force_n: Vector3<f64>,
    /// The changes that were made; see [`flags`].
    pub changed: u32,
    /// Fraction of the force that hold, gate and watchdog let through, from 0 to 1.
    pub let_through: f64,
}

/// The first link: decides which reading counts. Returns `None` until the first good one.
pub fn believe(
    params: &SafetyParams,
    state: &mut SafetyState,
    now_s: f64,
    reading: Result<Reading, DeviceFault>,
) -> Option<Believed> {
    let believed = hold::step(&params.hold, &mut state.hold, now_s, reading.ok())?;
    if believed.rejoined {
        state.gate = gate::GateState::default();
        state.passivity.forget_position();
    }
    Some(believed)
}

/// The links behind the law. Never fails.
pub fn step(params: &SafetyParams, state: &mut SafetyState, input: &SafetyInput) -> Output {
    let SafetyInput { now_s, believed, .. } = *input;
    let mut changed = if believed.held { flags::HELD } else { 0 };
    let mut mark = |on: bool, flag: u32| changed |= if on { flag } else { 0 };

    let finite = input.wanted_n.iter().all(|part| part.is_finite());
    mark(!finite, flags::NOT_FINITE);
    let law_n = if finite { input.wanted_n } else { Vector3::zeros() };
    let owed_n = clamp::norm(&law_n, params.max_force_n).0;

    let account = state.passivity.account(&params.passivity, &owed_n);
    let gate = params.gate.map_or(1.0, |gate| gate::step(&gate, &mut state.gate, now_s, account));
    mark(gate < 1.0, flags::GATED);
    if gate <= 0.0 {
        state.passivity.forgive();
    }
    let wanted_n = law_n * (gate * believed.gain);

    let motion = passivity::DeviceMotion { position_m: believed.reading.position_m, wanted_n, owed_n };
    let (passive_n, damped) = passivity::step(&params.passivity, &mut state.passivity, &motion);
    mark(damped, flags::DAMPED);
    let (clamped_n, clamped) = clamp::norm(&passive_n, params.max_force_n);
    mark(clamped, flags::CLAMPED);
    let (risen_n, limited) = rise::limit(&state.sent_n, &clamped_n, params.max_rise_n);
    mark(limited, flags::RISE_LIMITED);
    let (cool_n, hot) = thermal::step(&params.thermal, &mut state.thermal, believed.reading.motor_heat, &risen_n);
    mark(hot, flags::THERMAL);

    let barks = params
        .watchdog
        .is_some_and(|watchdog| watchdog::step(&watchdog, &mut state.watchdog, input.late_periods, input.connected));
    mark(barks, flags::WATCHDOG);
    if barks {
        state.gate = gate::GateState::default();
    }
    let force_n = if barks { Vector3::zeros() } else { cool_n };
    mark(params.gate.is_some() && is_unfelt(&owed_n, &force_n), flags::UNFELT);
    state.passivity.sent(force_n);
    state.sent_n = force_n;
    Output { force_n, changed, let_through: if barks { 0.0 } else { gate * believed.gain } }
}

/// Whether a perceptible force is not delivered: less than half of it is given, both in N.
fn is_unfelt(owed_n: &Vector3<f64>, given_n: &Vector3<f64>) -> bool {
    owed_n.norm() > passivity::FELT_N && given_n.norm() < 0.5 * owed_n.norm()
}
