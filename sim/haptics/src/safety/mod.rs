//! The safety chain between device and force law, and between force law and motors (physics section 5).
//!
//! Before the law, [`believe`] decides which reading counts. After it, [`step`] passes the wanted force through every link, in
//! this order: start gate, passivity, clamp, limit of the rise, thermal budget, watchdog. Each link is a file with its own tests and
//! knows nothing of the others. Everything here is in the device's frame and in the newtons of its motors.
//!
//! Whatever comes in, what goes out is finite and within the device's force, and zero within [`hold::SafetyParams::gone_after_s`] of
//! the last good reading.

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

/// What the chain changed, a bit each. They keep clear of the four lowest bits, which a recording's samples use for themselves.
pub mod flags {
    /// The reading was bad or missing: the last good one is held, or the force is ramping to zero.
    pub const HELD: u32 = 1 << 4;
    /// Force comes back: the gate is not wholly open.
    pub const GATED: u32 = 1 << 5;
    /// Damping was added, by more than [`super::passivity::FELT_N`].
    pub const DAMPED: u32 = 1 << 6;
    /// The force was larger than the device's maximum.
    pub const CLAMPED: u32 = 1 << 7;
    /// The force rose faster than it may.
    pub const RISE_LIMITED: u32 = 1 << 8;
    /// The force was reduced to keep the motors cool.
    pub const THERMAL: u32 = 1 << 9;
    /// The watchdog has cut the force.
    pub const WATCHDOG: u32 = 1 << 10;
    /// The law asked for a force that is not a number.
    pub const NOT_FINITE: u32 = 1 << 11;
    /// The hand was given less than half of the force that the law wants of this device, although that can be felt. Kept apart from
    /// the bits of [`crate::servo::flags`] between.
    pub const UNFELT: u32 = 1 << 16;
    /// What the links changed.
    pub const ALL: u32 = HELD | GATED | DAMPED | CLAMPED | RISE_LIMITED | THERMAL | WATCHDOG | NOT_FINITE;
}

/// Limits of every link, constant for an attempt.
#[derive(Clone, Debug, PartialEq)]
pub struct SafetyParams {
    /// What readings are believed, and for how long the last one is.
    pub hold: hold::HoldParams,
    /// How force is let in; at once where it can hurt nobody.
    pub gate: Option<gate::GateParams>,
    /// Energy observer and damping.
    pub passivity: passivity::PassivityParams,
    /// Largest force, in N.
    pub max_force_n: f64,
    /// Largest rise of the force in a tick, in N.
    pub max_rise_n: f64,
    /// Budget of heat.
    pub thermal: thermal::ThermalParams,
    /// Deadlines; none where a late force can hurt nobody.
    pub watchdog: Option<watchdog::WatchdogParams>,
}

impl SafetyParams {
    /// The limits for a device at a tick rate in Hz. `softest_n_per_m` is the least stiffness that the scene shows on this device.
    #[must_use]
    pub fn new(info: &DeviceInfo, rate_hz: f64, softest_n_per_m: f64) -> Self {
        /// Fastest rise from nothing to the largest force, in s (choice): a stab, never a knock.
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

/// What the links remember.
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

/// What goes into the chain after the law.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SafetyInput {
    /// Time of the servo's clock, in s.
    pub now_s: f64,
    /// How many periods the tick is late.
    pub late_periods: f64,
    /// The device took the last force.
    pub connected: bool,
    /// What is believed of the device.
    pub believed: Believed,
    /// The force that the law wants, scaled to the device, in N.
    pub wanted_n: Vector3<f64>,
}

/// What comes out of the chain.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Output {
    /// The force to send, in N.
    pub force_n: Vector3<f64>,
    /// What was changed, and by whom; see [`flags`].
    pub changed: u32,
    /// The part of the force that hold, gate and watchdog let through, from 0 to 1.
    pub let_through: f64,
}

/// The first link: what to believe of a reading. `None` until the first good one.
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

/// Whether a force that can be felt is not: less than half of it is given, both in N.
fn is_unfelt(owed_n: &Vector3<f64>, given_n: &Vector3<f64>) -> bool {
    owed_n.norm() > passivity::FELT_N && given_n.norm() < 0.5 * owed_n.norm()
}
