//! A real encoder through driver, servo and safety chain: both stand-ins report a handle in steps of 10 to 55 µm, each reading once
//! or three times, while it is pushed through the shipped scenes at 0.5 to 30 mm/s.
//!
//! It would fail on a cutting force that is on only in ticks whose position has moved, and on anything in a driver, the mapping or
//! the chain that turns an encoder's steps into jumps of the force.

use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use haptics::device::{Clocked, Device, DeviceFault, DeviceInfo, Reading};
use haptics::mapping::{Home, Mapping, Pointing};
use haptics::openhaptics::{OpenHaptics, OpenHapticsOptions};
use haptics::servo::Setup;
use inverse_service::State;
use law::puncture::PunctureParams;
use libhd::StandIn;
use nalgebra::{Point3, Vector3};

use crate::inverse3::{opened, until};
use crate::support::{PERIOD_S, RATE_HZ, Rig, reading, shipped};

/// Every shipped scene but the paper's, in which nothing cuts and speed is taken between two samples, as the paper has it.
const SCENES: [&str; 9] = [
    "lower-back-training",
    "epidural-71kg",
    "epidural-midline",
    "lower-back-lean",
    "lower-back-obese",
    "lower-back-thick-needle",
    "lower-back-vessel",
    "liver-18g",
    "heart-18g",
];
/// How far the handle is pushed, in m: 20 mm above the skin, where force is let in, and 30 mm below.
const WAY_M: f64 = 0.050;
const APPROACH_M: f64 = 0.020;
/// A jump of the force that a hand would notice, in N.
const JUMP_N: f64 = 0.05;
/// The same where readings come three times: at 30 mm/s each is then a step of 90 µm, whatever the encoder.
const REPEATED_JUMP_N: f64 = 0.1;

/// A push, and how the handle's motion is reported.
#[derive(Clone, Copy, Debug)]
struct Push {
    scene: &'static str,
    mm_per_s: f64,
    step_um: f64,
    repeats: usize,
}

impl Push {
    fn ideal(scene: &'static str, mm_per_s: f64) -> Self {
        Self { scene, mm_per_s, step_um: 0.0, repeats: 1 }
    }

    fn ticks(&self) -> usize {
        (WAY_M / self.m_per_tick()) as usize
    }

    fn m_per_tick(&self) -> f64 {
        self.mm_per_s * 1e-3 * PERIOD_S
    }

    /// How far down the handle is when the reading of a tick is made, in m.
    fn down_m(&self, tick: usize) -> f64 {
        self.m_per_tick() * (tick - tick % self.repeats) as f64
    }
}

/// A tick: the law's cutting force, and the force that the hand is given, in N.
struct Felt {
    cutting_n: f64,
    given_n: f64,
}

/// A servo on a scene, told its readings by hand, and what was felt of it so far.
struct Trial {
    rig: Rig,
    felt: Vec<Felt>,
}

impl Trial {
    fn new(scene: &str, info: &DeviceInfo) -> Self {
        let params = Arc::new(PunctureParams::new(shipped(scene)).expect("a valid scene"));
        let home = Home::above(Point3::origin(), -Vector3::z_axis(), APPROACH_M);
        let mapping = Mapping::at_home(home, Pointing::Planned);
        Self { rig: Rig::of(Setup::new(params, mapping, info, 0.03, RATE_HZ)), felt: Vec::new() }
    }

    fn tick(&mut self, reading: &Reading) -> Vector3<f64> {
        let force_n = self.rig.tick(Ok(*reading)).expect("it goes on");
        self.rig.taken();
        let latest = self.rig.latest.read().expect("shown");
        self.felt.push(Felt { cutting_n: latest.output.axial.cutting_n, given_n: latest.device_n.norm() });
        force_n
    }
}

/// Without a driver.
fn push_alone(info: &DeviceInfo, push: &Push) -> Vec<Felt> {
    let mut trial = Trial::new(push.scene, info);
    for tick in 0..push.ticks() {
        let position_m = Vector3::new(0.0, -push.down_m(tick), 0.0);
        trial.tick(&reading(tick as f64 * PERIOD_S, position_m));
    }
    trial.felt
}

/// The stand-in of a Touch, which moves its handle from frame to frame.
fn touch(push: &Push) -> (DeviceInfo, Vec<Felt>) {
    let step_mm = [0.0, -push.m_per_tick() * 1e3, 0.0];
    let encoder_mm = push.step_um * 1e-3;
    let script = libhd::Script {
        step_mm,
        encoder_mm,
        repeats: push.repeats,
        period_us: 0,
        inline: true,
        ..libhd::Script::default()
    };
    let stand_in = StandIn::new(script);
    let mut device =
        OpenHaptics::open(&OpenHapticsOptions { library: stand_in.path().into(), device: None }).expect("it opens");
    let info = Clocked::info(&device).clone();
    let mut trial = Trial::new(push.scene, &info);
    let mut tick = |reading: &Reading, fault: Option<DeviceFault>| {
        assert_eq!(fault, None);
        let force_n = trial.tick(reading);
        (trial.felt.len() < push.ticks()).then_some(force_n)
    };
    assert_eq!(device.run(&mut tick, &AtomicBool::new(false)), Ok(()));
    (info, trial.felt)
}

/// The stand-in of an Inverse3: its handle is held where it is to be, and a tick waits until the driver has heard of it.
fn inverse3(push: &Push) -> (DeviceInfo, Vec<Felt>) {
    let encoder_m = push.step_um * 1e-6;
    let state = State { encoder_m, step_m: [0.0; 3], ..State::default() };
    let (service, mut device) = opened(inverse_service::Script { state, ..inverse_service::Script::default() });
    let start_m = device.read().expect("a reading").position_m.y;
    let info = Device::info(&device).clone();
    let mut trial = Trial::new(push.scene, &info);
    for tick in 0..push.ticks() {
        let down_m = push.down_m(tick);
        service.hold([0.0, 0.0, -down_m]);
        let seen_m = start_m + if encoder_m > 0.0 { (-down_m / encoder_m).floor() * encoder_m } else { -down_m };
        let mut heard = device.read().expect("a reading");
        until(|| {
            heard = device.read().expect("a reading");
            (heard.position_m.y - seen_m).abs() < 1e-9
        });
        // The servo's time is told here, and every tick hears of the handle, whether it has moved or not.
        let force_n = trial.tick(&Reading { t_s: tick as f64 * PERIOD_S, ..heard });
        device.write(&force_n).expect("it takes the force");
    }
    (info, trial.felt)
}

/// How far the force goes within some ticks around one, in N: an encoder is ahead of the handle or behind it by a step.
fn changes_n(felt: &[Felt], around: usize, at: usize) -> f64 {
    let stretch = felt[at.saturating_sub(around)..felt.len().min(at + around + 2)].iter().map(|tick| tick.given_n);
    let (low, high) = stretch.fold((f64::INFINITY, 0.0_f64), |(low, high), n| (low.min(n), high.max(n)));
    high - low
}

fn judge(case: &str, felt: &[Felt], ideal: &[Felt], (around, most_n): (usize, f64)) {
    let cuts: Vec<usize> = (0..ideal.len()).filter(|&at| ideal[at].cutting_n > 0.0).collect();
    let on = cuts.iter().filter(|&&at| felt[at].cutting_n > 0.0).count();
    assert!(on as f64 >= 0.95 * cuts.len() as f64, "{case}: cutting in {on} of {} ticks", cuts.len());
    let sum = |all: &[Felt]| cuts.iter().map(|&at| all[at].cutting_n).sum::<f64>();
    let ratio = if cuts.is_empty() { 1.0 } else { sum(felt) / sum(ideal) };
    assert!((ratio - 1.0).abs() <= 0.02, "{case}: mean cutting is {ratio} of the ideal");
    for at in 1..felt.len() {
        let jump_n = (felt[at].given_n - felt[at - 1].given_n).abs();
        // A pop falls at once, from where an encoder has it by then.
        assert!(jump_n <= most_n + 1.1 * changes_n(ideal, around, at), "{case}: a jump of {jump_n} N at tick {at}");
    }
}

/// Pushes through a driver, and compares with the same push that every tick tells exactly.
fn compare(through: impl Fn(&Push) -> (DeviceInfo, Vec<Felt>), push: &Push) {
    let (info, felt) = through(push);
    let ideal = push_alone(&info, &Push::ideal(push.scene, push.mm_per_s));
    // Two positions that it tells apart, and a reading as old as can be.
    let around = (2.0 * push.step_um * 1e-6 / push.m_per_tick()) as usize + 3 * push.repeats;
    let most_n = if push.repeats > 1 { REPEATED_JUMP_N } else { JUMP_N };
    judge(&format!("{push:?} on {}", info.name), &felt, &ideal, (around, most_n));
}

#[test]
fn force_is_as_steady_through_a_touch_as_without_it() {
    for scene in SCENES {
        let speeds: &[f64] = if scene == "lower-back-training" { &[0.5, 2.0, 7.0, 30.0] } else { &[2.0, 30.0] };
        for &mm_per_s in speeds {
            for (step_um, repeats) in [(0.0, 1), (10.0, 1), (30.0, 1), (55.0, 1), (0.0, 3), (55.0, 3)] {
                compare(touch, &Push { scene, mm_per_s, step_um, repeats });
            }
        }
    }
}

#[test]
fn force_is_as_steady_through_an_inverse3_as_without_it() {
    for scene in SCENES {
        let speeds: &[f64] = if scene == "lower-back-training" { &[0.5, 2.0, 7.0, 30.0] } else { &[30.0] };
        for &mm_per_s in speeds {
            for (step_um, repeats) in [(10.0, 3), (55.0, 1), (55.0, 3)] {
                // Every place is a round trip to the service.
                if step_um > 20.0 || mm_per_s > 20.0 {
                    compare(inverse3, &Push { scene, mm_per_s, step_um, repeats });
                }
            }
        }
    }
}
