//! The whole servo through the vendors' drivers, from the handle's motion to the motors: each stand-in pushes its handle down
//! through the training scene.
//!
//! It would fail where driver and servo, each right by itself, do not fit: a force in another frame's axes, a tick late, on the
//! wrong handle's place, or one that stands after the servo has stopped.

use std::sync::Arc;
use std::thread::sleep;
use std::time::Duration;

use haptics::mapping::{Home, Mapping, Pointing};
use haptics::openhaptics::{OpenHaptics, OpenHapticsOptions};
use haptics::safety::flags::GATED;
use haptics::servo::{self, Driven, Ended, Record, Report, Setup};
use inverse_service::State;
use law::puncture::PunctureParams;
use libhd::StandIn;
use nalgebra::{Point3, Vector3};

use crate::inverse3::opened;
use crate::support::{RATE_HZ, shipped};

/// How far down the needle goes, in m: past skin, fat and fascia.
const DEPTH_M: f64 = 0.030;
/// Ticks after which a needle that has not come there never will.
const MOST_TICKS: usize = 30_000;
/// Runs after which a machine is too busy for this.
const MOST_RUNS: usize = 20;

fn mapping() -> Mapping {
    Mapping::at_home(Home::above(Point3::origin(), -Vector3::z_axis(), 0.002), Pointing::Planned)
}

/// Runs a servo until the needle is down, and stops it.
fn punctured(driven: Driven) -> (Vec<Record>, Report) {
    let params = Arc::new(PunctureParams::new(shipped("lower-back-training")).expect("a valid scene"));
    let setup = Setup::new(params, mapping(), driven.info(), DEPTH_M, RATE_HZ);
    let mut started = servo::start(setup, driven).expect("it starts");
    let mut records: Vec<Record> = Vec::new();
    while records.last().is_none_or(|last| last.position_m[2] > -DEPTH_M) && records.len() < MOST_TICKS {
        match started.records.pop() {
            Some(record) => records.push(record),
            None => sleep(Duration::from_millis(1)),
        }
    }
    let report = started.running.stop().expect("no defect");
    records.extend(std::iter::from_fn(|| started.records.pop()));
    (records, report)
}

/// What the servo sent in a tick, in N in the device's axes.
fn sent(record: &Record) -> Vector3<f64> {
    mapping().device_from_patient(&Vector3::from(record.device_n).cast())
}

/// Whether the gate opens, and never closes again: a stall of a busy machine cuts the force, as it must, and it then comes back slowly.
fn gate_stays_open(records: &[Record]) -> bool {
    let is_open = |record: &Record| record.flags & GATED == 0;
    records.iter().position(is_open).is_some_and(|opened| records[opened..].iter().all(is_open))
}

fn is_a_puncture(records: &[Record], report: &Report) {
    assert_eq!(report.ended, Ended::Stopped);
    assert!(report.counts.ruptures >= 2, "{:?}", report.counts);
    assert_eq!(report.counts.dropped, 0);
    assert!(records.iter().any(|record| sent(record).y > 0.5), "the tissue pushes the handle back up");
}

#[test]
fn a_touch_feels_each_tick_in_its_own_frame() {
    let run = |_| {
        let stand_in = StandIn::new(libhd::Script { step_mm: [0.0, -0.01, 0.0], ..libhd::Script::default() });
        let device =
            OpenHaptics::open(&OpenHapticsOptions { library: stand_in.path().into(), device: None }).expect("it opens");
        let (records, report) = punctured(Driven::ByDevice(Box::new(device)));
        (stand_in, records, report)
    };
    let in_time = (0..MOST_RUNS).map(run).find(|(_, records, _)| gate_stays_open(records));
    let (stand_in, records, report) = in_time.expect("a run without a stall");
    is_a_puncture(&records, &report);
    let heard = stand_in.heard();
    assert_eq!(heard.faults, 0, "no frame was begun twice, no force was too much");
    // Frame by frame, so a pop is felt in the very tick in which the law has it.
    for (tick, (record, heard_n)) in records.iter().zip(heard.forces_n()).enumerate() {
        let difference_n = (sent(record) - Vector3::from(*heard_n)).norm();
        assert!(difference_n < 1e-6, "frame {tick}: {:?} N sent, {heard_n:?} N heard", sent(record));
    }
    assert_eq!(heard.forces_n().last(), Some(&[0.0; 3]), "the last frame is without force");
}

#[test]
fn an_inverse3_is_told_what_the_servo_sends_and_zero_at_the_end() {
    let state = State { step_m: [0.0, 0.0, -1e-5], ..State::default() };
    let first = Some(inverse_service::first(&state));
    let run = |_| {
        let (service, device) = opened(inverse_service::Script {
            state: state.clone(),
            first: first.clone(),
            ..inverse_service::Script::default()
        });
        let (records, report) = punctured(Driven::ByTimer(Box::new(device)));
        (service, records, report)
    };
    let in_time = (0..MOST_RUNS).map(run).find(|(_, records, _)| gate_stays_open(records));
    let (service, records, report) = in_time.expect("a run without a stall");
    is_a_puncture(&records, &report);
    let told_n: Vec<_> = service.forces_n().into_iter().map(|(_, [x, y, z])| Vector3::new(x, z, -y)).collect();
    // The service is asked at its own pace: it hears some of the ticks, each as it was sent.
    for told_n in told_n.iter().filter(|told_n| told_n.norm() > 0.0) {
        let was_sent = records.iter().any(|record| (sent(record) - told_n).norm() < 1e-5);
        assert!(was_sent, "{told_n:?} N were never sent");
    }
    assert!(told_n.iter().any(|told_n| told_n.y > 0.5), "it pushes back up");
    assert_eq!(told_n.last(), Some(&Vector3::zeros()), "the last it hears is no force");
}
