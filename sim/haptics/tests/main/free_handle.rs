//! A free handle on the needle's axis, let go by the servo and its safety chain, and followed.

use std::sync::Arc;

use haptics::device::DeviceInfo;
use haptics::mapping::{Mapping, NeedlePose};
use haptics::scaling::Scaling;
use haptics::servo::Setup;
use law::puncture::{PunctureInput, PunctureParams, PunctureScratch, PunctureSpec, PunctureState, step};
use nalgebra::Vector3;

use crate::support::{PERIOD_S, RATE_HZ, Rig, reading};

/// What is let go.
#[derive(Clone, Copy)]
pub struct Held {
    pub mass_kg: f64,
    pub damping_n_s_per_m: f64,
    /// Of its spring about where it was let go.
    pub stiffness_n_per_m: f64,
}

/// A handle alone.
pub const HANDLE: Held = Held { mass_kg: 0.045, damping_n_s_per_m: 0.0, stiffness_n_per_m: 0.0 };

/// Followed for so long, in ticks.
pub const FOLLOWED: u32 = 400;
/// Above the skin, in m.
const START_M: f64 = -0.002;
/// By then every force that was on its way is called back, in ticks.
const CALLED_BACK: u32 = 15;

/// How a handle is let go.
pub struct Release {
    /// Where the tip is, in m along the axis.
    pub x_m: f64,
    /// A steady push into the body that remains, in N: a hand's weight, under which the handle bounces on.
    pub push_n: f64,
    /// How fast it then moves out of the body, in m/s.
    pub speed_m_per_s: f64,
    /// Ticks between sending a force and its acting.
    pub delay: usize,
    pub held: Held,
}

/// The largest gain of a handle that was let go, as a part of what it had.
#[derive(Clone, Copy, Default)]
pub struct Gain {
    /// At any time.
    pub at_once: f64,
    /// After [`CALLED_BACK`].
    pub later: f64,
}

impl Gain {
    pub fn or(self, other: Self) -> Self {
        Self { at_once: self.at_once.max(other.at_once), later: self.later.max(other.later) }
    }
}

/// A handle on the axis, with the tissue beside it to know what is stored.
pub struct Bench {
    rig: Rig,
    params: Arc<PunctureParams>,
    state: PunctureState,
    scratch: PunctureScratch,
    pub scaling: Scaling,
    tick: u32,
    /// Where the handle was last, in m.
    x_m: f64,
    /// Forces sent, the latest last, in N along the axis into the body.
    pub sent_n: Vec<f64>,
}

impl Bench {
    pub fn new(scene: PunctureSpec, info: &DeviceInfo, target_x_m: f64, damped: bool) -> Self {
        let params = Arc::new(PunctureParams::new(scene).expect("a valid scene"));
        let mut setup = Setup::new(params, Mapping::in_patient_frame(), info, target_x_m, RATE_HZ);
        if !damped {
            setup.safety.passivity.max_damping_n_s_per_m = 0.0;
        }
        Self::of(setup)
    }

    /// With everything that a servo needs, in the patient frame.
    pub fn of(setup: Setup) -> Self {
        let (params, scaling) = (Arc::clone(&setup.params), setup.scaling.clone());
        let (state, scratch) = (PunctureState::new(&params), PunctureScratch::new(&params));
        Self { rig: Rig::of(setup), params, state, scratch, scaling, tick: 0, x_m: START_M, sent_n: vec![0.0; 8] }
    }

    /// A tick with the tip at a depth in m.
    pub fn tick(&mut self, x_m: f64) {
        self.late_tick(x_m, 0.0);
    }

    /// A tick that comes late, in s.
    pub fn late_tick(&mut self, x_m: f64, late_s: f64) {
        let t_s = f64::from(self.tick) * PERIOD_S;
        let reading = reading(t_s, Vector3::new(0.0, 0.0, -x_m));
        let force_n = self.rig.late_tick(Ok(reading), late_s).expect("it goes on");
        self.sent_n.push(-force_n.z);
        let record = self.rig.taken().pop().expect("recorded");
        let pose = NeedlePose { position_m: record.position_m, orientation: record.orientation };
        let input = PunctureInput { t_s: record.t_s, patient_from_needle: pose.isometry() };
        step(&self.params, &mut self.state, &mut self.scratch, &input);
        self.tick += 1;
        self.x_m = x_m;
    }

    /// What the tissue stores, as the device shows it, in J.
    pub fn stored_j(&self) -> f64 {
        let ledger = self.state.ledger();
        let boundaries = ledger.layers.iter().zip(&self.scaling.boundaries);
        let tents_j: f64 = boundaries.map(|(layer, boundary)| layer.elastic_j * boundary.factor).sum();
        tents_j + self.scaling.sliding_factor * ledger.presliding_j
    }

    /// Goes to a depth in m, at 50 mm/s, and rests there.
    pub fn go(&mut self, x_m: f64) {
        self.wait();
        self.go_on(x_m);
    }

    /// Waits above the skin until force is let in.
    pub fn wait(&mut self) {
        (0..1600).for_each(|_| self.tick(START_M));
    }

    /// Goes on from where the handle is to a depth in m, at 50 mm/s, and rests there.
    pub fn go_on(&mut self, x_m: f64) {
        let from_m = self.x_m;
        let ticks = ((x_m - from_m).abs() / 50e-6).ceil();
        (1..=ticks as u32).for_each(|n| self.tick(from_m + (x_m - from_m) * f64::from(n) / ticks));
        (0..50).for_each(|_| self.tick(x_m));
    }

    /// Lets a mass go and follows it.
    pub fn let_go(&mut self, release: &Release) -> Gain {
        let (mut x_m, mut v) = (release.x_m, -release.speed_m_per_s);
        let Held { mass_kg, damping_n_s_per_m, stiffness_n_per_m } = release.held;
        let begin_j = self.stored_j() + 0.5 * mass_kg * v * v;
        let mut worst = Gain::default();
        for tick in 0..FOLLOWED {
            // The force sent acts until the next tick, or a tick later: exact motion under a constant force.
            let acting_n = self.sent_n[self.sent_n.len() - 1 - release.delay] + release.push_n;
            let a = (acting_n - damping_n_s_per_m * v - stiffness_n_per_m * (x_m - release.x_m)) / mass_kg;
            x_m += v * PERIOD_S + 0.5 * a * PERIOD_S * PERIOD_S;
            v += a * PERIOD_S;
            self.tick(x_m);
            let fallen_j = release.push_n * (x_m - release.x_m);
            let held_j = 0.5 * mass_kg * v * v + 0.5 * stiffness_n_per_m * (x_m - release.x_m).powi(2);
            let at_once = (held_j + self.stored_j() - begin_j - fallen_j) / begin_j;
            worst = worst.or(Gain { at_once, later: if tick < CALLED_BACK { 0.0 } else { at_once } });
        }
        worst
    }
}
