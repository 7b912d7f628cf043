//! Every way out of the servo's thread leaves the device without force, closed, and says why.
//!
//! It would fail on a thread that dies with its last force standing: on a stop, on a handle that is dropped, on a device that is
//! lost, and on a panic in driver or callback.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use haptics::device::{Clocked, DeviceFault, DeviceInfo, Tick};
use haptics::devices::scripted::{Fault, Scripted, Watched};
use haptics::mapping::{Home, Mapping, Pointing};
use haptics::servo::{self, Driven, Ended, Priority, Setup, Started};
use law::puncture::PunctureParams;
use nalgebra::{Point3, Vector3};

use crate::inverse3::until;
use crate::support::{RATE_HZ, Rig, reading, shipped};

/// A virtual hand has no gate, so that the short lives below see force.
fn setup(info: &DeviceInfo, approach_m: f64) -> Setup {
    let params = Arc::new(PunctureParams::new(shipped("lower-back-training")).expect("a valid scene"));
    let home = Home::above(Point3::origin(), -Vector3::z_axis(), approach_m);
    Setup::new(params, Mapping::at_home(home, Pointing::Handle), info, 0.03, RATE_HZ)
}

/// An engine for a handle that starts above the skin by a distance in m.
pub fn rig(info: &DeviceInfo, approach_m: f64) -> Rig {
    Rig::of(setup(info, approach_m))
}

fn start(device: Scripted) -> (Started, Arc<Watched>) {
    let watched = device.watched();
    let setup = setup(servo_info(&device), 0.001);
    let started = servo::start(setup, Driven::ByTimer(Box::new(device))).expect("a thread");
    (started, watched)
}

fn servo_info(device: &Scripted) -> &DeviceInfo {
    haptics::device::Device::info(device)
}

/// Starts until a run shows force: where the machine stalls at the start, safety keeps force away until the handle is out.
fn start_with_force() -> (Started, Arc<Watched>) {
    let shown = || {
        let (started, watched) = start(Scripted::new(0.02, RATE_HZ));
        let soon = (0..1000).any(|_| {
            std::thread::sleep(std::time::Duration::from_millis(1));
            watched.force_n().norm() > 0.1
        });
        soon.then_some((started, watched))
    };
    (0..5).find_map(|_| shown()).expect("a run without a stall")
}

fn without_force(watched: &Watched) -> bool {
    watched.closed() && watched.force_n() == Vector3::zeros()
}

#[test]
fn a_stop_and_a_drop_leave_no_force() {
    let (started, watched) = start_with_force();
    let report = started.running.stop().expect("a report");
    assert!(without_force(&watched));
    assert_eq!(report.ended, Ended::Stopped);
    assert_eq!(report.lateness.count(), report.counts.ticks);

    let (started, watched) = start_with_force();
    drop(started);
    assert!(without_force(&watched));
}

#[test]
fn lost_device_and_driver_panic_leave_no_force_and_are_reported() {
    for (fault, why) in [(Fault::Disconnect, Ended::DeviceLost(DeviceFault::Gone)), (Fault::Panic, Ended::Panicked)] {
        assert!((0..5).any(|_| ends_without_force(fault, why)), "{fault:?}: there was force in a run without a stall");
    }
}

/// Whether there was force before the fault; that there is none after it in any case.
fn ends_without_force(fault: Fault, why: Ended) -> bool {
    // The 300th reading is 5 mm into the tissue.
    let (mut started, watched) = start(Scripted::new(0.02, RATE_HZ).with(fault, 300, u64::MAX));
    until(|| started.running.ended().is_some());
    assert!(without_force(&watched), "{fault:?}");
    assert_eq!(started.running.ended(), Some(why));
    let recorded = std::iter::from_fn(|| started.records.pop()).collect::<Vec<_>>();
    assert_eq!(recorded.len(), 300, "{fault:?}: every tick was recorded");
    assert_eq!(started.running.stop().map(|report| report.ended), Some(why));
    assert!(started.records.is_over());
    recorded.iter().any(|record| record.device_n[2] > 0.1)
}

/// A device with a clock of its own, that ticks as fast as it can and counts what it was sent.
struct Metronome {
    info: DeviceInfo,
    ticks: u64,
    /// It is lost after so many.
    lost_after: u64,
    /// The last force was not zero.
    pushing: Arc<AtomicBool>,
}

impl Clocked for Metronome {
    fn info(&self) -> &DeviceInfo {
        &self.info
    }

    fn run(&mut self, tick: &mut Tick<'_>, stop: &AtomicBool) -> Result<(), DeviceFault> {
        let mut ended = Ok(());
        while !stop.load(Ordering::Relaxed) {
            self.ticks += 1;
            let t_s = self.ticks as f64 / RATE_HZ;
            let handle = haptics::device::Reading {
                position_m: Vector3::new(0.0, -0.02 * t_s, 0.0),
                ..reading(t_s, Vector3::zeros())
            };
            let Some(force_n) = tick(&handle, None) else { break };
            self.pushing.store(force_n != Vector3::zeros(), Ordering::Relaxed);
            if self.ticks >= self.lost_after {
                ended = Err(DeviceFault::Gone);
                break;
            }
        }
        self.pushing.store(false, Ordering::Relaxed);
        ended
    }
}

#[test]
fn device_clock_runs_the_tick_and_its_end_is_reported() {
    for (lost_after, why) in [(u64::MAX, Ended::Stopped), (500, Ended::DeviceLost(DeviceFault::Gone))] {
        let pushing = Arc::new(AtomicBool::new(false));
        let info = servo_info(&Scripted::new(0.0, RATE_HZ)).clone();
        let device = Metronome { info, ticks: 0, lost_after, pushing: Arc::clone(&pushing) };
        let setup = setup(&device.info, 0.001);
        let mut started = servo::start(setup, Driven::ByDevice(Box::new(device))).expect("a thread");
        until(|| started.latest.read().is_some_and(|latest| latest.ticks >= 500));
        let report = started.running.stop().expect("a report");
        assert_eq!((report.ended, report.priority), (why, Priority::Device));
        assert!(!pushing.load(Ordering::Relaxed));
        assert!(started.records.pop().is_some());
    }
}
