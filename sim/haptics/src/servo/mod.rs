//! The servo: a thread that reads the device, steps the force law and drives the device, once a
//! millisecond.
//!
//! A tick is: read → map → force law → scale → safety chain → write → record and publish. It never
//! allocates, locks, logs or opens a file. [`start`] runs it in a thread of its own; [`Engine`] is
//! the same without a thread and a clock.

mod bare;
mod engine;
mod grid;
mod latest;
#[cfg(windows)]
mod multimedia;
pub(crate) mod priority;
mod record;
mod rehearse;
mod run;
mod timing;

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, OnceLock};
use std::thread::{self, JoinHandle};
use std::{fmt, io};

pub use bare::bare;
pub use engine::{Counts, Engine, TickMoment};
pub use latest::{LatestReader, Snapshot};
use law::puncture::PunctureParams;
pub use priority::{Priority, granted};
pub use record::{CAPACITY, Record, Records};
pub use rehearse::{Rehearsal, rehearse};
pub use timing::{Quantiles, Times};

use crate::device::{Clocked, Device, DeviceFault, DeviceInfo};
use crate::mapping::Mapping;
use crate::safety;
use crate::scaling::Scaling;

/// Flags of a tick in [`Record::flags`], in addition to those of the safety chain,
/// [`safety::flags`].
pub mod flags {
    /// The tick began more than a period late.
    pub const STALLED: u32 = 1 << 12;
    /// The clutch holds the needle.
    pub const CLUTCHED: u32 = 1 << 13;
    /// The device rejected the previous force.
    pub const REFUSED: u32 = 1 << 14;
    /// The forces of the scene are scaled to the device.
    pub const SCALED: u32 = 1 << 15;
    /// The device reports a force other than the commanded one. The bit below belongs to the safety
    /// chain.
    pub const DISAGREES: u32 = 1 << 17;
}

/// Everything that a servo needs for an attempt.
#[derive(Clone, Debug)]
pub struct Setup {
    /// The force law.
    pub params: Arc<PunctureParams>,
    /// From the device frame to the patient frame.
    pub mapping: Mapping,
    /// The scaling of the scene's forces to this device.
    pub scaling: Scaling,
    /// Limits of the safety chain.
    pub safety: safety::SafetyParams,
    /// Tick rate, in Hz.
    pub rate_hz: f64,
}

impl Setup {
    /// Fits a force law to a device. `target_x_m` is the axial displacement that the exercise
    /// requires, in m.
    #[must_use]
    pub fn new(
        params: Arc<PunctureParams>,
        mapping: Mapping,
        info: &DeviceInfo,
        target_x_m: f64,
        rate_hz: f64,
    ) -> Self {
        let scaling = Scaling::new(&params.spec().axial, target_x_m, info);
        let safety = safety::SafetyParams::new(info, rate_hz, scaling.scaled_softest_n_per_m);
        Self { params, mapping, scaling, safety, rate_hz }
    }
}

/// A device, by the clock that paces its ticks.
pub enum Driven {
    /// Paced by the servo's timer.
    ByTimer(Box<dyn Device>),
    /// Paced by the device.
    ByDevice(Box<dyn Clocked>),
}

impl Driven {
    /// Identity and limits of the device.
    #[must_use]
    pub fn info(&self) -> &DeviceInfo {
        match self {
            Self::ByTimer(device) => device.info(),
            Self::ByDevice(device) => device.info(),
        }
    }
}

/// Why the servo could not start.
#[derive(Debug, thiserror::Error)]
pub enum StartError {
    /// The rate is not positive and finite.
    #[error("tick rate = {0} Hz: must be a finite number above 0")]
    Rate(f64),
    /// The histogram rejects its bounds.
    #[error("histogram: {0}")]
    Histogram(#[from] hdrhistogram::errors::CreationError),
    /// The thread cannot be created.
    #[error("the servo's thread cannot be started: {0}")]
    Thread(#[from] io::Error),
}

/// Why a servo ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Ended {
    /// It was asked to stop.
    Stopped,
    /// The device is lost.
    DeviceLost(DeviceFault),
    /// The program has a defect; the force was set to zero first.
    Panicked,
}

impl fmt::Display for Ended {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Stopped => f.write_str("stopped"),
            Self::DeviceLost(fault) => write!(f, "device lost: {fault}"),
            Self::Panicked => f.write_str("stopped by a program error; the force was set to zero"),
        }
    }
}

/// The final report of a servo.
#[derive(Clone, Debug)]
pub struct Report {
    /// Why it ended.
    pub ended: Ended,
    /// Event counts.
    pub counts: Counts,
    /// The thread's priority.
    pub priority: Priority,
    /// Lateness of the ticks.
    pub lateness: Times,
    /// Compute time of the ticks.
    pub compute: Times,
}

impl fmt::Display for Report {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Counts { ticks, stalls, dropped, .. } = self.counts;
        writeln!(
            f,
            "servo: {}, {ticks} ticks, {stalls} stalls, {dropped} records dropped, {}",
            self.ended, self.priority
        )?;
        writeln!(f, "lateness: {}", self.lateness.quantiles())?;
        write!(f, "compute: {}", self.compute.quantiles())
    }
}

/// A started servo.
pub struct Started {
    /// Stops the servo and returns its report.
    pub running: Running,
    /// For the recorder.
    pub records: Records,
    /// For the display, the field and the overlay.
    pub latest: LatestReader,
}

/// State shared between the servo thread and its owner.
#[derive(Debug, Default)]
struct ServoShared {
    stop: AtomicBool,
    priority: OnceLock<Priority>,
    ended: OnceLock<Ended>,
}

/// A running servo. Dropping it stops it and leaves zero force on the device.
#[derive(Debug)]
pub struct Running {
    shared: Arc<ServoShared>,
    thread: Option<JoinHandle<Report>>,
}

/// Starts a servo in a thread of its own, at real-time priority if the system allows it.
///
/// # Errors
/// If `rate_hz` is not positive and finite, or the thread cannot be created. The device is then
/// closed.
pub fn start(setup: Setup, driven: Driven) -> Result<Started, StartError> {
    let (mut engine, records, latest) = Engine::new(setup)?;
    let shared = Arc::new(ServoShared::default());
    let theirs = Arc::clone(&shared);
    let thread = thread::Builder::new().name("servo".to_owned()).spawn(move || serve(&mut engine, driven, &theirs))?;
    Ok(Started { running: Running { shared, thread: Some(thread) }, records, latest })
}

/// Body of the servo thread.
fn serve(engine: &mut Engine, driven: Driven, shared: &ServoShared) -> Report {
    let priority = match driven {
        Driven::ByTimer(_) => priority::raise(priority::SERVO),
        Driven::ByDevice(_) => Priority::Device,
    };
    // Only this thread sets these two cells, so `set` cannot fail.
    let _ = shared.priority.set(priority);
    let ended = run::run(engine, driven, &shared.stop);
    let _ = shared.ended.set(ended);
    let (lateness, compute) = engine.times();
    Report { ended, counts: engine.counts(), priority, lateness: lateness.clone(), compute: compute.clone() }
}

impl Running {
    /// The thread's priority, once it is known.
    #[must_use]
    pub fn priority(&self) -> Option<Priority> {
        self.shared.priority.get().copied()
    }

    /// Why the servo ended, once it has.
    #[must_use]
    pub fn ended(&self) -> Option<Ended> {
        self.shared.ended.get().copied()
    }

    /// Requests a stop without waiting, for example from a signal handler.
    pub fn ask_to_stop(&self) {
        self.shared.stop.store(true, Ordering::Relaxed);
    }

    /// Stops the servo and returns its report; `None` if the thread itself panicked.
    pub fn stop(mut self) -> Option<Report> {
        self.join()
    }

    fn join(&mut self) -> Option<Report> {
        self.ask_to_stop();
        self.thread.take()?.join().ok()
    }
}

impl Drop for Running {
    fn drop(&mut self) {
        self.join();
    }
}
