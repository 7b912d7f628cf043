//! The servo's thread: two ways to pace the ticks, and zero force on every exit path.

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use nalgebra::Vector3;
use spin_sleep::{SpinSleeper, SpinStrategy};

use super::engine::{Engine, TickMoment};
use super::grid::TickGrid;
use super::{Driven, Ended};
use crate::clock;
use crate::device::{Clocked, Device, DeviceFault, Reading};

/// Time before a tick that is spent spinning, in ns: longer than Linux needs to wake a thread.
const SPIN_NS: u32 = 100_000;

/// Runs until the servo is stopped or the device is lost, and returns the reason.
pub(super) fn run(engine: &mut Engine, driven: Driven, stop: &AtomicBool) -> Ended {
    // Unwind safe: after a panic only the engine's counters are read.
    let ended = catch_unwind(AssertUnwindSafe(|| match driven {
        Driven::ByTimer(mut device) => by_timer(engine, device.as_mut(), stop),
        Driven::ByDevice(mut device) => by_device(engine, device.as_mut(), stop),
    }));
    ended.unwrap_or(Ended::Panicked)
}

/// Sends zero force and closes the device when dropped, on return and on panic alike.
struct Released<'a> {
    device: &'a mut dyn Device,
}

impl Drop for Released<'_> {
    fn drop(&mut self) {
        // A device that rejects the write applies no force anyway.
        let _ = self.device.write(&Vector3::zeros());
        self.device.close();
    }
}

/// Paced by the servo's timer: sleep, then spin.
fn by_timer(engine: &mut Engine, device: &mut dyn Device, stop: &AtomicBool) -> Ended {
    let sleeper = sleeper();
    let released = Released { device };
    loop {
        if stop.load(Ordering::Relaxed) {
            return Ended::Stopped;
        }
        let moment = wait(engine.grid(), sleeper);
        let Some(force_n) = engine.tick(released.device.read(), &moment, &clock::now_s) else {
            return engine.ended().unwrap_or(Ended::Stopped);
        };
        let wrote = released.device.write(&force_n);
        engine.wrote(wrote);
        engine.doubted(released.device.disagrees());
        engine.took(clock::now_s() - moment.now_s);
    }
}

/// A sleeper that spins for the last [`SPIN_NS`]. On Windows it is created in the thread that waits,
/// which then has a high-resolution timer: that wakes it up to half a millisecond late, and the
/// sleeper's own limit covers it. A system without such timers gets a period of 1 ms.
pub(super) fn sleeper() -> SpinSleeper {
    let sleeper = if cfg!(windows) { SpinSleeper::default() } else { SpinSleeper::new(SPIN_NS) };
    sleeper.with_spin_strategy(SpinStrategy::SpinLoopHint)
}

/// Waits for the next tick.
pub(super) fn wait(grid: &TickGrid, sleeper: SpinSleeper) -> TickMoment {
    let Some(due_s) = grid.due_s() else {
        // Before the first tick: poll a device that has no reading yet once a period.
        sleeper.sleep(Duration::from_secs_f64(grid.period_s()));
        return TickMoment { now_s: clock::now_s(), late_s: 0.0 };
    };
    sleeper.sleep(Duration::from_secs_f64((due_s - clock::now_s()).max(0.0)));
    let now_s = clock::now_s();
    TickMoment { now_s, late_s: now_s - due_s }
}

/// Paced by the device: the tick runs inside the device's callback. The driver sends zero force
/// when the callback ends or panics.
fn by_device(engine: &mut Engine, device: &mut dyn Clocked, stop: &AtomicBool) -> Ended {
    let period_s = engine.grid().period_s();
    let mut last_s = None;
    let mut tick = |reading: &Reading, complaint: Option<DeviceFault>| {
        let now_s = clock::now_s();
        let late_s = last_s.map_or(0.0, |last_s: f64| (now_s - last_s - period_s).max(0.0));
        last_s = Some(now_s);
        let (reading, wrote) = match complaint {
            None => (Ok(*reading), Ok(())),
            Some(refusal @ DeviceFault::RefusesForce(_)) => (Ok(*reading), Err(refusal)),
            Some(fault) => (Err(fault), Ok(())),
        };
        engine.wrote(wrote);
        let force_n = engine.tick(reading, &TickMoment { now_s, late_s }, &clock::now_s);
        engine.took(clock::now_s() - now_s);
        force_n
    };
    let ran = device.run(&mut tick, stop);
    match (engine.ended(), ran) {
        (Some(ended), _) => ended,
        (None, Err(fault)) => Ended::DeviceLost(fault),
        (None, Ok(())) => Ended::Stopped,
    }
}
