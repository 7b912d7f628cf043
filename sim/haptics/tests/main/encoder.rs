//! A real encoder through driver, servo and safety chain: the stand-in of a Touch reports its handle in steps of 10 to 55 µm, each reading
//! once or three times, and pushes it through the shipped scenes at 0.5 to 30 mm/s.
//!
//! It would fail on a cutting force that is on only in ticks whose position has moved, and on anything in the driver, the mapping or
//! the chain that turns an encoder's steps into jumps of the force.

use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use haptics::device::{Clocked, DeviceFault, Reading};
use haptics::mapping::{Home, Mapping, Pointing};
use haptics::openhaptics::{OpenHaptics, Options};
use haptics::servo::Setup;
use libhd::{Script, StandIn};
use mechanics::puncture::PunctureParams;
use nalgebra::{Point3, Vector3};

use crate::support::{RATE_HZ, Rig, shipped};

/// Every shipped scene but the paper's, in which nothing cuts and speed is taken between two samples, as the paper has it.
const SCENES: [&str; 6] = [
    "lower-back-training",
    "epidural-71kg",
    "lower-back-lean",
    "lower-back-obese",
    "lower-back-thick-needle",
    "lower-back-vessel",
];
/// How far the handle is pushed, in mm: 20 mm above the skin, where force is let in, and 30 mm below.
const WAY_MM: f64 = 50.0;
const APPROACH_M: f64 = 0.020;
/// A jump of the force that a hand would notice, in N.
const JUMP_N: f64 = 0.05;

/// How a handle's motion is reported.
#[derive(Clone, Copy, Debug)]
struct Encoder {
    step_um: f64,
    repeats: usize,
}

/// A tick: the law's cutting force, and the force that the hand is given, in N.
struct Felt {
    cutting_n: f64,
    given_n: f64,
}

/// Pushes the handle at a speed in mm/s.
fn push(scene: &str, mm_per_s: f64, encoder: Encoder) -> Vec<Felt> {
    let step_mm = [0.0, -mm_per_s / RATE_HZ, 0.0];
    let Encoder { step_um, repeats } = encoder;
    let script =
        Script { step_mm, encoder_mm: step_um * 1e-3, repeats, period_us: 0, inline: true, ..Script::default() };
    let stand_in = StandIn::new(script);
    let mut device = OpenHaptics::open(&Options { library: stand_in.path().into(), device: None }).expect("it opens");
    let params = Arc::new(PunctureParams::new(shipped(scene)).expect("a valid scene"));
    let home = Home::above(Point3::origin(), -Vector3::z_axis(), APPROACH_M);
    let mapping = Mapping::at_home(home, Pointing::Planned);
    let mut rig = Rig::of(Setup::new(params, mapping, device.info(), (0.03, RATE_HZ)));
    let ticks = (WAY_MM / mm_per_s * RATE_HZ) as usize;
    let mut felt = Vec::with_capacity(ticks);
    let mut tick = |reading: &Reading, fault: Option<DeviceFault>| {
        assert_eq!(fault, None);
        let force_n = rig.tick(Ok(*reading)).expect("it goes on");
        rig.taken();
        let latest = rig.latest.read().expect("shown");
        felt.push(Felt { cutting_n: latest.output.axial.cutting_n, given_n: latest.device_n.norm() });
        (felt.len() < ticks).then_some(force_n)
    };
    assert_eq!(device.run(&mut tick, &AtomicBool::new(false)), Ok(()));
    felt
}

/// How far the force goes within some ticks around one, in N: an encoder is ahead of the handle or behind it by a step.
fn changes_n(felt: &[Felt], around: usize, at: usize) -> f64 {
    let stretch = felt[at.saturating_sub(around)..felt.len().min(at + around + 2)].iter().map(|tick| tick.given_n);
    let (low, high) = stretch.fold((f64::INFINITY, 0.0_f64), |(low, high), n| (low.min(n), high.max(n)));
    high - low
}

fn judge(case: &str, felt: &[Felt], ideal: &[Felt], around: usize) {
    let cuts: Vec<usize> = (0..ideal.len()).filter(|&at| ideal[at].cutting_n > 0.0).collect();
    let on = cuts.iter().filter(|&&at| felt[at].cutting_n > 0.0).count();
    assert!(on as f64 >= 0.95 * cuts.len() as f64, "{case}: cutting in {on} of {} ticks", cuts.len());
    let sum = |all: &[Felt]| cuts.iter().map(|&at| all[at].cutting_n).sum::<f64>();
    let ratio = if cuts.is_empty() { 1.0 } else { sum(felt) / sum(ideal) };
    assert!((ratio - 1.0).abs() <= 0.02, "{case}: mean cutting is {ratio} of the ideal");
    for at in 1..felt.len() {
        let jump_n = (felt[at].given_n - felt[at - 1].given_n).abs();
        assert!(jump_n <= JUMP_N + changes_n(ideal, around, at), "{case}: a jump of {jump_n} N at tick {at}");
    }
}

#[test]
fn force_is_as_steady_through_an_encoder_as_without_one() {
    for scene in SCENES {
        let speeds: &[f64] = if scene == "lower-back-training" { &[0.5, 2.0, 7.0, 30.0] } else { &[2.0, 30.0] };
        for &mm_per_s in speeds {
            let ideal = push(scene, mm_per_s, Encoder { step_um: 0.0, repeats: 1 });
            for (step_um, repeats) in [(10.0, 1), (55.0, 1), (0.0, 3), (55.0, 3)] {
                let felt = push(scene, mm_per_s, Encoder { step_um, repeats });
                let around = (step_um * 1e-3 / mm_per_s * RATE_HZ) as usize + 2 * repeats;
                judge(&format!("{scene}, {mm_per_s} mm/s, {step_um} µm, {repeats} times"), &felt, &ideal, around);
            }
        }
    }
}
