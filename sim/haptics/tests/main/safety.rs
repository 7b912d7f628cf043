//! The whole safety chain: whatever comes in, what goes out is finite, within the device's force, and zero soon after the
//! input stops. And a device that misbehaves, in each of the ways seen, ends without force and without losing the attempt.
//!
//! It would fail on a NaN that passes, on a clamp that turns the force, on a hold without an end and on a link that is skipped.

use std::sync::Arc;

use documents::{ExerciseBundle, Patient};
use haptics::device::{Device, DeviceFault, DeviceInfo, Reading};
use haptics::devices::scripted::{Fault, Scripted};
use haptics::mapping::Mapping;
use haptics::safety::{self, SafetyInput, SafetyParams, SafetyState, flags};
use haptics::servo::{Ended, Setup, rehearse};
use law::operator::{Operator, Skill};
use law::puncture::PunctureParams;
use nalgebra::{Quaternion, UnitQuaternion, Vector3};
use proptest::prelude::*;

use crate::support::{PERIOD_S, RATE_HZ, Rig, device, reading, shipped, touch};

/// Any number, with the ones that hurt.
fn number() -> impl Strategy<Value = f64> {
    prop_oneof![
        6 => -0.1..0.1_f64,
        1 => -1e3..1e3_f64,
        1 => prop::sample::select(vec![f64::NAN, f64::INFINITY, f64::NEG_INFINITY, f64::MAX, f64::MIN_POSITIVE, 0.0]),
    ]
}

fn vector() -> impl Strategy<Value = Vector3<f64>> {
    prop::array::uniform3(number()).prop_map(Vector3::from)
}

fn any_reading() -> impl Strategy<Value = Result<Reading, DeviceFault>> {
    let any = (number(), vector(), prop::array::uniform4(number())).prop_map(|(t_s, position_m, q)| {
        let orientation = UnitQuaternion::new_unchecked(Quaternion::from(q));
        Ok(Reading { t_s, position_m, orientation, buttons: 0, motor_heat: 0.0 })
    });
    prop_oneof![1 => any, 1 => Just(Err(DeviceFault::Reported(3)))]
}

/// A tick of the chain: mostly a good reading, now and then any.
#[derive(Clone, Debug)]
struct Tick {
    reading: Option<Result<Reading, DeviceFault>>,
    wanted_n: Vector3<f64>,
    late_periods: f64,
    connected: bool,
}

fn tick() -> impl Strategy<Value = Tick> {
    let reading = prop_oneof![4 => Just(None), 1 => any_reading().prop_map(Some)];
    let late = prop_oneof![9 => Just(0.0), 1 => number()];
    (reading, vector(), late, prop::bool::weighted(0.99)).prop_map(|(reading, force, late_periods, connected)| Tick {
        reading,
        wanted_n: force * 40.0,
        late_periods,
        connected,
    })
}

/// The force sent in a tick, in N; none before the first good reading.
fn step(params: &SafetyParams, state: &mut SafetyState, number: usize, tick: &Tick) -> Option<Vector3<f64>> {
    let now_s = number as f64 * PERIOD_S;
    let reading = tick.reading.unwrap_or_else(|| Ok(reading(now_s, Vector3::new(0.0, 0.0, 0.01))));
    let believed = safety::believe(params, state, now_s, reading)?;
    let Tick { wanted_n, late_periods, connected, .. } = *tick;
    Some(safety::step(params, state, &SafetyInput { now_s, late_periods, connected, believed, wanted_n }).force_n)
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]
    #[test]
    fn whatever_comes_in_the_force_is_finite_bounded_and_soon_gone(
        ticks in prop::collection::vec(tick(), 1..1500),
        open in any::<bool>(),
    ) {
        let mut params = SafetyParams::new(&touch(), RATE_HZ, 83.0);
        if open {
            params.gate = None;
        }
        let mut state = SafetyState::default();
        for (number, tick) in ticks.iter().enumerate() {
            if let Some(force_n) = step(&params, &mut state, number, tick) {
                prop_assert!(force_n.iter().all(|part| part.is_finite()), "{force_n}");
                prop_assert!(force_n.norm() <= 3.3 * (1.0 + 1e-12), "{force_n}");
            }
        }
        let silent = Tick { reading: Some(Err(DeviceFault::Reported(1))), connected: true, late_periods: 0.0, ..ticks[0].clone() };
        let gone = (params.hold.gone_after_s() * RATE_HZ).ceil() as usize + 1;
        for after in 0..gone + 100 {
            let force_n = step(&params, &mut state, ticks.len() + after, &silent).unwrap_or_default();
            prop_assert!(after < gone || force_n == Vector3::zeros(), "{after} ms after the input stopped: {force_n}");
        }
    }
}

#[test]
fn a_force_reaches_the_motors_at_all() {
    // Guards the property above: a chain that never sends anything would pass it.
    let params = SafetyParams::new(&touch(), RATE_HZ, 83.0);
    let mut state = SafetyState::default();
    let wanted = |number: usize| Tick {
        reading: None,
        wanted_n: Vector3::new(0.0, if number < 1600 { 0.0 } else { 5.0 }, 0.0),
        late_periods: 0.0,
        connected: true,
    };
    let sent: Vec<Vector3<f64>> = (0..2400).filter_map(|n| step(&params, &mut state, n, &wanted(n))).collect();
    assert!((sent[2399] - Vector3::new(0.0, 3.3, 0.0)).norm() < 1e-9, "clamped and whole: {}", sent[2399]);
    assert!((sent[1610].y - 11.0 * 0.165).abs() < 1e-9, "risen by 0.165 N a tick: {}", sent[1610].y);
}

/// Drives a device that moves into the skin and misbehaves from its 1500th reading on; forces sent, and how it ended.
fn misbehave(fault: Fault, lasts: u64) -> (Vec<f64>, Option<Ended>, Rig) {
    let mut device = Scripted::new(0.01, RATE_HZ).as_device(touch()).with(fault, 1500, lasts);
    let mut rig = crate::exits::rig(device.info(), 0.0125);
    let mut sent = Vec::new();
    for _ in 0..4000 {
        let Some(force_n) = rig.tick(device.read()) else { break };
        rig.engine.wrote(device.write(&force_n));
        sent.push(force_n.norm());
    }
    (sent, rig.engine.ended(), rig)
}

#[test]
fn device_fault_ends_in_zero_force_and_the_attempt_continues() {
    for fault in [Fault::NotANumber, Fault::Freeze, Fault::Jump(0.05), Fault::Backwards] {
        let (sent, ended, _) = misbehave(fault, u64::MAX);
        assert!(sent[1499] > 0.3, "{fault:?}: the skin is tented before: {} N", sent[1499]);
        assert!((sent[1510] / sent[1499] - 1.0).abs() < 0.1, "{fault:?}: held at first");
        assert!(sent[1625] == 0.0, "{fault:?}: gone after 120 ms");
        assert_eq!(ended, None, "{fault:?}");
        // A handle that jumped is believed again from where it is, with the needle where it was.
        let stays_gone = matches!(fault, Fault::NotANumber | Fault::Freeze | Fault::Backwards);
        assert!(!stays_gone || sent[1626..].iter().all(|&force_n| force_n == 0.0), "{fault:?}");
    }
}

#[test]
fn device_refusing_force_gets_none_until_it_accepts_for_200_ms() {
    let (sent, ended, mut rig) = misbehave(Fault::RefusesForce, 100);
    assert!(sent[1499] > 0.3 && sent[1502..1800].iter().all(|&force_n| force_n == 0.0));
    assert_eq!(ended, None);
    let refused = rig.taken().iter().filter(|record| record.flags & flags::WATCHDOG != 0).count();
    assert!(refused >= 290, "100 refusals and 200 ms after: {refused}");
}

#[test]
fn lost_device_ends_the_servo_and_a_reported_fault_may_recover() {
    let (sent, ended, _) = misbehave(Fault::Disconnect, u64::MAX);
    assert_eq!((sent.len(), ended), (1500, Some(Ended::DeviceLost(DeviceFault::Gone))));
    let (sent, ended, _) = misbehave(Fault::Reports(9), u64::MAX);
    assert_eq!(ended, Some(Ended::DeviceLost(DeviceFault::Reported(9))));
    assert!(sent.len() > 3000 && sent[1625..].iter().all(|&force_n| force_n == 0.0), "two seconds of complaints");
    let (sent, ended, _) = misbehave(Fault::Reports(9), 10);
    assert_eq!((sent.len(), ended), (4000, None), "ten are forgiven");
}

#[test]
fn jumped_handle_is_rejoined_in_place_and_the_needle_stays() {
    let (_, _, mut rig) = misbehave(Fault::Jump(0.05), u64::MAX);
    let records = rig.taken();
    let way_m = |pair: &[haptics::servo::Record]| {
        (Vector3::from(pair[1].position_m) - Vector3::from(pair[0].position_m)).norm()
    };
    let longest_m = records.windows(2).map(way_m).fold(0.0, f64::max);
    assert!(longest_m < 1.1e-5, "never more than a tick of 10 mm/s: {longest_m} m");
    let held = records.iter().filter(|record| record.flags & flags::HELD != 0).count();
    assert!((150..400).contains(&held), "it is believed again: {held} ticks held");
}

#[test]
fn what_the_safety_chain_did_is_in_the_records() {
    let (_, _, mut rig) = misbehave(Fault::NotANumber, u64::MAX);
    let records = rig.taken();
    let held = records.iter().position(|record| record.flags & flags::HELD != 0);
    assert_eq!(held, Some(1500));
    assert!(records.iter().all(|record| record.position_m.iter().all(|part| part.is_finite())));
}

/// How the force came back after it was away, from the tick it was cut in: when it was first given again and when it was whole, in
/// ticks, and its greatest rise in a tick, in N.
fn comes_back(given_n: &[f64], whole_n: f64) -> (usize, usize, f64) {
    let first = given_n.iter().position(|&force_n| force_n > 0.0).expect("it comes back");
    let whole =
        given_n.iter().position(|&force_n| (force_n / whole_n - 1.0).abs() < 0.02).expect("it comes back wholly");
    let rise_n = given_n.windows(2).map(|pair| pair[1] - pair[0]).fold(0.0, f64::max);
    (first, whole, rise_n)
}

#[test]
fn host_stall_cuts_the_force_and_ramps_it_back_at_the_needle() {
    let mut rig = Rig::new(shipped("lower-back-training"), &touch(), 0.03);
    // 2 mm into the skin: far more than is let in at once.
    let force_at = |rig: &mut Rig, number: u32, late_s: f64| {
        let z_m = 0.002 - 2e-6 * f64::from(number.min(2000));
        rig.late_tick(Ok(reading(f64::from(number) * PERIOD_S, Vector3::new(0.0, 0.0, z_m))), late_s)
            .expect("it goes on")
            .norm()
    };
    let before_n = (0..2500).map(|n| force_at(&mut rig, n, 0.0)).last().unwrap_or_default();
    assert!(before_n > 0.3, "{before_n}");
    assert!(force_at(&mut rig, 2500, 0.05) == 0.0, "a stall of 50 ms cuts at once");
    let after: Vec<f64> = (2501..5000).map(|n| force_at(&mut rig, n, 0.0)).collect();
    let (first, whole, rise_n) = comes_back(&after, before_n);
    assert!((195..=205).contains(&first), "the watchdog is quiet after 200 ms: {first}");
    assert!((1400..=1710).contains(&whole) && rise_n < 0.001, "{whole} ms, {rise_n} N in a tick");
}

#[test]
fn force_ramps_back_after_a_freeze_and_unfelt_ticks_are_flagged() {
    // At 10 mm/s, 2.5 mm into the skin when 200 readings are the same; then the handle is 2 mm further on.
    let mut device = Scripted::new(0.01, RATE_HZ).as_device(touch()).with(Fault::Freeze, 1500, 200);
    let mut rig = crate::exits::rig(device.info(), 0.0125);
    let mut owed_n = Vec::new();
    for _ in 0..4000 {
        let force_n = rig.tick(device.read()).expect("it goes on");
        rig.engine.wrote(device.write(&force_n));
        owed_n.push(rig.latest.read().expect("ticks are shown").owed_n.z);
    }
    let records = rig.taken();
    let given = |record: &haptics::servo::Record| f64::from(record.device_n[2]);
    let step_m = (records[1749].position_m[2] - records[1500].position_m[2]).abs();
    assert!(step_m < 1.1e-5, "the needle stays where it was until the handle is believed again: {step_m} m");
    assert!(records[1621..1750].iter().all(|record| given(record) == 0.0));
    let back = &records[1755..];
    assert!(given(&back[100]) > 0.0, "it begins at once");
    let whole = records.iter().zip(&owed_n).skip(1755 + 1510);
    assert!(whole.into_iter().all(|(record, owed_n)| given(record) > 0.9 * owed_n), "and is whole after 1.5 s");
    for (record, &owed_n) in records.iter().zip(&owed_n) {
        let unfelt = record.flags & flags::UNFELT != 0;
        // A pop's rise is limited, so the edge of half is not exact.
        let share = given(record) / owed_n;
        assert!(owed_n < 0.051 || !(unfelt && share > 0.51) && (unfelt || share > 0.49), "{} s: {share}", record.t_s);
    }
    let unfelt = records.iter().filter(|record| record.flags & flags::UNFELT != 0).count();
    assert!((800..1100).contains(&unfelt), "half of the hold's ramp, the silence, half of the way back: {unfelt} ms");
}

#[test]
fn a_virtual_hand_has_neither_gate_nor_watchdog() {
    let mut device = Scripted::new(0.01, RATE_HZ);
    let mut rig = crate::exits::rig(device.info(), 0.0005);
    for tick in 0..1000_u32 {
        let late_s = if tick.is_multiple_of(3) { 0.05 } else { 0.0 };
        rig.late_tick(device.read(), late_s).expect("it goes on");
    }
    let records = rig.taken();
    let protected = flags::GATED | flags::WATCHDOG | flags::UNFELT;
    assert!(records.iter().all(|record| record.flags & protected == 0));
    assert!(records[100].device_n[2] > 0.1, "there is force from the first contact: {:?}", records[100].device_n);
}

/// How long the motors of a device are kept cool while an expert makes the attempt of an exercise, in s.
fn cooled_s(exercise: &str, info: &DeviceInfo) -> f64 {
    let file = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../../curricula").join(exercise);
    let bundle = ExerciseBundle::read(&file.with_extension("toml")).expect("a shipped exercise");
    let params = Arc::new(PunctureParams::new(bundle.scene.puncture_spec(&Patient::nominal(&bundle.scene))).unwrap());
    let target_x_m = bundle.exercise.target_depth_mm * 1e-3;
    let setup = Setup::new(params, Mapping::in_patient_frame(), info, target_x_m, RATE_HZ);
    let operator = Operator::skilled(&Skill::expert(), &bundle.exercise.plan(), 1);
    let rehearsal = rehearse(setup, operator, bundle.exercise.time_limit_s).unwrap();
    assert!(rehearsal.duration_s > 5.0, "{exercise}: over after {} s", rehearsal.duration_s);
    rehearsal.cooled_s
}

#[test]
fn expert_never_overheats_a_touch_and_weak_motors_are_detected() {
    let long = ["percutaneous-kidney-access/1-lower-pole", "lumbar-epidural/1-stop-in-the-epidural-space"];
    for exercise in long {
        let cooled_s = cooled_s(exercise, &touch());
        assert!(cooled_s < 0.1, "{exercise}: {cooled_s} s");
    }
    assert!(cooled_s(long[0], &device("weak", 3.3, 0.2, 400.0)) > 1.0);
}
