//! A tick of the servo: what it must never do, what it hands to recorder and picture, and how soon a pop is felt.
//!
//! It would fail on a heap in the tick, on a record that differs from what the law was fed in a single bit, on a stall that is
//! hidden in the times, on a pop that waits for a filter, and on a recorder that can stop the servo.

use std::sync::Arc;

use allocation_counter::measure;
use haptics::device::{Device, Reading, buttons};
use haptics::devices::hand::{Aim, VirtualHand};
use haptics::devices::operator::OperatorDevice;
use haptics::devices::scripted::{Fault, Scripted};
use haptics::devices::trajectory::Trajectory;
use haptics::mapping::{Home, Mapping, NeedlePose, Pointing};
use haptics::safety;
use haptics::servo::{CAPACITY, Record, Setup, flags};
use law::operator::{Operator, Plan, Skill};
use law::puncture::{PunctureEvent, PunctureInput, PunctureParams, PunctureScratch, PunctureState, step};
use nalgebra::{Point3, Vector3};

use crate::support::{PERIOD_S, RATE_HZ, Rig, reading, shipped, touch};

fn plan() -> Plan {
    Plan {
        entry_m: Point3::origin(),
        skin: law::Skin::Flat,
        axis: -Vector3::z(),
        target_x_m: 0.03,
        approach_m: 0.01,
        hold_s: 0.5,
        reach_m: 0.15,
    }
}

/// Drives a device for some ticks, as the thread does; the forces it was sent, in N.
fn drive(rig: &mut Rig, device: &mut dyn Device, ticks: u32) -> Vec<Vector3<f64>> {
    let mut sent = Vec::with_capacity(ticks as usize);
    for _ in 0..ticks {
        let Some(force_n) = rig.tick(device.read()) else { break };
        rig.engine.wrote(device.write(&force_n));
        sent.push(force_n);
    }
    sent
}

#[test]
fn ticks_with_ruptures_stalls_and_faults_allocate_nothing() {
    const AWAY: u32 = CAPACITY as u32 + 810;
    const TICKS: u32 = AWAY + 3000;
    let mut rig = Rig::new(shipped("lower-back-training"), &touch(), 0.03);
    let mut operator = OperatorDevice::new("operator:constant", Operator::constant(0.01, &plan()), RATE_HZ);
    let counted = measure(|| {
        for tick in 0..TICKS {
            let late_s = if tick.is_multiple_of(997) { 0.004 } else { 0.0 };
            let mut reading = operator.read();
            if tick % 501 == 500 {
                reading = reading.map(|reading| Reading { t_s: f64::NAN, ..reading });
            }
            let force_n = rig.late_tick(reading, late_s).expect("it goes on");
            rig.engine.wrote(operator.write(&force_n));
            rig.latest.read();
            // The recorder is away for a while: the ring runs full.
            if tick >= AWAY {
                while rig.records.pop().is_some() {}
            }
        }
    });
    assert_eq!(counted.count_total, 0);
    let counts = rig.engine.counts();
    let stalls = u64::from(TICKS.div_ceil(997));
    let eventful = counts.ruptures >= 6 && counts.stalls == stalls && counts.ticks == u64::from(TICKS);
    assert!(eventful, "it must be eventful, with {stalls} stalls: {counts:?}");
    assert_eq!(counts.dropped, u64::from(AWAY + 1) - CAPACITY as u64, "what the recorder missed is counted");
}

/// Steps the law on records, as a recorder does, and compares every force to the bit.
fn replays(params: &PunctureParams, records: &[Record]) {
    let (mut state, mut scratch) = (PunctureState::new(params), PunctureScratch::new(params));
    for record in records {
        let pose = NeedlePose { position_m: record.position_m, orientation: record.orientation };
        let input = PunctureInput { t_s: record.t_s, patient_from_needle: pose.isometry() };
        let output = step(params, &mut state, &mut scratch, &input);
        let force_n: [f32; 3] = output.force_n.map(|part| part as f32).into();
        assert_eq!(force_n.map(f32::to_bits), record.force_n.map(f32::to_bits), "at {} s", record.t_s);
        assert!(!scratch.events.contains(&PunctureEvent::Fault), "the law is never fed what it must hold");
    }
    assert!(state.axial.tip_open >= 2, "the needle must have been in the tissue");
}

#[test]
fn records_replay_bit_for_bit_through_faults_and_stalls() {
    let params = Arc::new(PunctureParams::new(shipped("lower-back-training")).expect("a valid scene"));
    for fault in [Fault::None, Fault::NotANumber, Fault::Jump(0.05), Fault::Backwards, Fault::Reports(7)] {
        let mut device = Scripted::new(0.01, RATE_HZ).with(fault, 2500, 300);
        let home = Home::above(Point3::origin(), -Vector3::z_axis(), 0.015);
        let mapping = Mapping::at_home(home, Pointing::Handle);
        let mut rig = Rig::of(Setup::new(Arc::clone(&params), mapping, device.info(), 0.03, RATE_HZ));
        drive(&mut rig, &mut device, 2000);
        rig.late_tick(device.read(), 0.006);
        drive(&mut rig, &mut device, 2000);
        let records = rig.taken();
        assert_eq!(records.len(), 4001);
        assert!(records.windows(2).all(|pair| pair[0].t_s < pair[1].t_s), "{fault:?}: times rise");
        replays(&params, &records);
    }
}

#[test]
fn a_stall_is_a_gap_in_the_times_counted_and_flagged() {
    let mut rig = Rig::new(shipped("lower-back-training"), &touch(), 0.03);
    let at = |tick: u32| Ok(reading(f64::from(tick) * PERIOD_S, Vector3::new(0.0, 0.0, 0.01)));
    (0..10).for_each(|tick| assert!(rig.tick(at(tick)).is_some()));
    rig.late_tick(at(10), 0.0072);
    rig.tick(at(11));
    let records = rig.taken();
    let periods: Vec<u32> = records.iter().map(|record| (record.t_s * RATE_HZ).round() as u32).collect();
    assert_eq!(periods[8..], [8, 9, 17, 18]);
    let stalled: Vec<bool> = records.iter().map(|record| record.flags & flags::STALLED != 0).collect();
    assert_eq!(stalled[8..], [false, false, true, false]);
    assert!((records[10].lateness_us - 7200.0).abs() < 0.01);
    assert_eq!(rig.engine.counts().stalls, 1);
}

#[test]
fn a_pop_changes_the_force_at_the_device_in_the_very_tick() {
    let mut rig = Rig::new(shipped("lower-back-training"), &touch(), 0.03);
    let (mut last_n, mut pops, mut felt) = (0.0, 0, 0);
    for tick in 0..5000_u32 {
        let t_s = f64::from(tick) * PERIOD_S;
        let before = rig.engine.counts().ruptures;
        let force_n =
            rig.tick(Ok(reading(t_s, Vector3::new(0.0, 0.0, 0.015 - 0.01 * t_s)))).expect("it goes on").norm();
        let latest = rig.latest.read().expect("ticks are shown");
        if latest.ruptures > before {
            pops += 1;
            felt += u32::from(force_n < last_n - 0.1);
            let law_n = latest.owed_n.norm();
            assert!(
                (force_n - law_n).abs() < 0.01,
                "pop {pops}: {law_n} N wanted, {force_n} N sent, {last_n} N before"
            );
        }
        last_n = force_n;
    }
    assert!(pops == 8 && felt >= 4, "{pops} pops, {felt} of them by more than 0.1 N");
}

#[test]
fn picture_gets_the_recorded_tick_and_the_tissue_loads() {
    let mut rig = Rig::new(shipped("lower-back-training"), &touch(), 0.03);
    assert!(rig.latest.read().is_none(), "nothing before the first tick");
    let at =
        |tick: u32| reading(f64::from(tick) * PERIOD_S, Vector3::new(0.0, 0.0, 1e-3 * (1.0 - 0.003 * f64::from(tick))));
    for tick in 0..1000 {
        rig.tick(Ok(Reading { buttons: buttons::CONFIRM, ..at(tick) }));
    }
    let last = rig.taken().pop().expect("recorded");
    let latest = rig.latest.read().expect("shown");
    assert_eq!(latest.record, last);
    assert!(last.confirm && latest.buttons == buttons::CONFIRM);
    assert!(
        (latest.loads_n[0] - latest.output.axial.tip_n).abs() < 1e-12 && latest.loads_n[0] > 0.5,
        "the skin is tented"
    );
    assert_eq!(latest.loads_n.len(), 8, "a load and a drag for each of four layers");
}

#[test]
fn what_was_changed_is_flagged() {
    let mut rig = Rig::new(shipped("epidural-71kg"), &touch(), 0.048);
    for tick in 0..3000_u32 {
        let t_s = f64::from(tick) * PERIOD_S;
        rig.tick(Ok(reading(t_s, Vector3::new(0.0, 0.0, 0.015 - 0.01 * t_s))));
    }
    let records = rig.taken();
    assert!(records.iter().all(|record| record.flags & flags::SCALED != 0), "12 N do not fit a device of 3.3 N");
    let gated = records.iter().filter(|record| record.flags & safety::flags::GATED != 0).count();
    assert!((1500..=1501).contains(&gated), "the gate takes a second and a half: {gated}");
    let deep = records.last().expect("recorded");
    let (law_n, sent_n) = (deep.force_n[2], deep.device_n[2]);
    assert!(law_n > 1.5 && (sent_n / law_n - 3.3 / 13.2).abs() < 0.01, "{law_n} N → {sent_n} N");
}

#[test]
fn skin_stops_a_virtual_hand_and_its_pop_throws_it_forward() {
    let params = Arc::new(PunctureParams::new(shipped("lower-back-training")).expect("a valid scene"));
    let (mut hand, mut aim) = VirtualHand::new("mouse", &VirtualHand::braced(), RATE_HZ);
    let home = Home::above(Point3::origin(), -Vector3::z_axis(), 0.002);
    let mapping = Mapping::at_home(home, Pointing::Planned);
    let mut rig = Rig::of(Setup::new(params, mapping, hand.info(), 0.03, RATE_HZ));
    drive(&mut rig, &mut hand, 1100);
    let mut x_m = |rig: &mut Rig, push_m: f64| {
        aim.write(Aim { position_m: Vector3::new(0.0, -push_m, 0.0), ..Aim::default() });
        drive(rig, &mut hand, 400);
        rig.latest.read().expect("shown").output.x_m
    };
    // The mouse asks for 2.5 mm below the skin: 419.7 N/m against the hand's 1500 leave 1.95 mm of it.
    let stopped_m = x_m(&mut rig, 0.0045);
    assert!((stopped_m - 0.0025 * 1500.0 / 1919.735).abs() < 2e-5, "{stopped_m} m");
    assert_eq!(rig.engine.counts().ruptures, 0);
    let thrown_m = x_m(&mut rig, 0.0088);
    assert!(rig.engine.counts().ruptures == 1 && thrown_m > 0.0053, "it springs on: {thrown_m} m");
}

#[test]
fn an_operator_does_through_the_servo_what_it_does_without_one() {
    let params = Arc::new(PunctureParams::new(shipped("lower-back-training")).expect("a valid scene"));
    let mut device = OperatorDevice::new("operator:expert", Operator::skilled(&Skill::expert(), &plan(), 3), RATE_HZ);
    let done = device.done();
    let setup = Setup::new(Arc::clone(&params), Mapping::in_patient_frame(), device.info(), 0.03, RATE_HZ);
    let mut rig = Rig::of(setup);
    let mut confirms = 0;
    let mut deepest_m = 0.0_f64;
    while !done.load(std::sync::atomic::Ordering::Relaxed) && rig.now_s < 200.0 {
        drive(&mut rig, &mut device, 1);
        let latest = rig.latest.read().expect("shown");
        deepest_m = deepest_m.max(latest.output.x_m);
        confirms += u32::from(latest.record.confirm);
    }
    assert_eq!(confirms, 1, "it confirms once");
    assert!((deepest_m - 0.03).abs() < 0.003, "it reaches the target: {deepest_m} m");
    assert!(rig.now_s < 200.0, "it gets done");
}

#[test]
fn a_trajectory_is_played_reading_by_reading_and_then_holds() {
    let place = |tick: u32| Vector3::new(0.0, 0.0, 0.002 - 1e-5 * f64::from(tick));
    let readings = (0..300).map(|tick| reading(0.0, place(tick))).collect();
    let mut device = Trajectory::new("recording", readings, RATE_HZ);
    let mut rig = Rig::new(shipped("lower-back-training"), device.info(), 0.03);
    drive(&mut rig, &mut device, 400);
    let records = rig.taken();
    let last = 299;
    for (tick, record) in (0_u32..).zip(&records) {
        assert_eq!(record.position_m.map(f64::to_bits), <[f64; 3]>::from(place(tick.min(last))).map(f64::to_bits));
    }
    assert!(device.done().load(std::sync::atomic::Ordering::Relaxed) && records.len() == 400);
}
