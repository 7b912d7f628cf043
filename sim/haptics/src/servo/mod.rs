//! The servo: a thread that reads the device, asks the force law and drives the device, once a millisecond.
//!
//! A tick is: read → map → force law → scale → safety chain → write → tell recorder and picture. It never allocates, locks, logs
//! or opens a file. [`start`] runs it in a thread of its own; [`Engine`] is the same without thread and clock.

mod bare;
mod engine;
mod grid;
mod latest;
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
pub use priority::Priority;
pub use record::{CAPACITY, Record, Records};
pub use rehearse::{Rehearsal, rehearse};
pub use timing::{Quantiles, Times};

use crate::device::{Clocked, Device, DeviceFault, DeviceInfo};
use crate::mapping::Mapping;
use crate::safety;
use crate::scaling::Scaling;

/// What happened to a tick besides what the safety chain did, in [`Record::flags`] beside [`safety::flags`].
pub mod flags {
    /// The tick began more than a period late.
    pub const STALLED: u32 = 1 << 12;
    /// The clutch holds the needle.
    pub const CLUTCHED: u32 = 1 << 13;
    /// The device did not take the force before.
    pub const REFUSED: u32 = 1 << 14;
    /// The scene is scaled to the device.
    pub const SCALED: u32 = 1 << 15;
    /// The device says that it shows another force than it was sent. The bit below is the safety chain's.
    pub const DISAGREES: u32 = 1 << 17;
}

/// What an attempt is made of.
#[derive(Clone, Debug)]
pub struct Setup {
    /// The force law.
    pub params: Arc<PunctureParams>,
    /// From the device to the patient.
    pub mapping: Mapping,
    /// The scene's forces on this device.
    pub scaling: Scaling,
    /// Limits of the safety chain.
    pub safety: safety::SafetyParams,
    /// Tick rate, in Hz.
    pub rate_hz: f64,
}

impl Setup {
    /// Fits a force law to a device. `target_x_m` is the axial displacement that the exercise asks for, in m.
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

/// A device, and who paces its ticks.
pub enum Driven {
    /// Our timer does.
    ByTimer(Box<dyn Device>),
    /// The device does.
    ByDevice(Box<dyn Clocked>),
}

impl Driven {
    /// What the device is and can do.
    #[must_use]
    pub fn info(&self) -> &DeviceInfo {
        match self {
            Self::ByTimer(device) => device.info(),
            Self::ByDevice(device) => device.info(),
        }
    }
}

/// Why there is no servo.
#[derive(Debug, thiserror::Error)]
pub enum StartError {
    /// The rate is none.
    #[error("tick rate = {0} Hz: must be a finite number above 0")]
    Rate(f64),
    /// The histogram refuses its bounds.
    #[error("histogram: {0}")]
    Histogram(#[from] hdrhistogram::errors::CreationError),
    /// The system gives no thread.
    #[error("no thread for the servo: {0}")]
    Thread(#[from] io::Error),
}

/// Why a servo is over.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Ended {
    /// It was told to stop.
    Stopped,
    /// The device is lost.
    DeviceLost(DeviceFault),
    /// The program has a defect; the force was zero before anything else.
    Panicked,
}

impl fmt::Display for Ended {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Stopped => f.write_str("stopped"),
            Self::DeviceLost(fault) => write!(f, "device lost: {fault}"),
            Self::Panicked => f.write_str("stopped by a defect of the program; the force was set to zero"),
        }
    }
}

/// What a servo came to.
#[derive(Clone, Debug)]
pub struct Report {
    /// Why it is over.
    pub ended: Ended,
    /// What happened.
    pub counts: Counts,
    /// The thread's priority.
    pub priority: Priority,
    /// How late ticks began.
    pub lateness: Times,
    /// What ticks took.
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

/// A servo that has been started.
pub struct Started {
    /// To stop it, and to hear how it went.
    pub running: Running,
    /// For the recorder.
    pub records: Records,
    /// For picture, field and overlay.
    pub latest: LatestReader,
}

/// What both sides of the thread see.
#[derive(Debug, Default)]
struct ServoShared {
    stop: AtomicBool,
    priority: OnceLock<Priority>,
    ended: OnceLock<Ended>,
}

/// A servo at work. Dropped, it stops, with zero force on the device.
#[derive(Debug)]
pub struct Running {
    shared: Arc<ServoShared>,
    thread: Option<JoinHandle<Report>>,
}

/// Starts a servo in a thread of its own, at real-time priority where that is allowed.
///
/// # Errors
/// When the rate is none or the system gives no thread. The device is closed then.
pub fn start(setup: Setup, driven: Driven) -> Result<Started, StartError> {
    let (mut engine, records, latest) = Engine::new(setup)?;
    let shared = Arc::new(ServoShared::default());
    let theirs = Arc::clone(&shared);
    let thread = thread::Builder::new().name("servo".to_owned()).spawn(move || serve(&mut engine, driven, &theirs))?;
    Ok(Started { running: Running { shared, thread: Some(thread) }, records, latest })
}

/// The thread.
fn serve(engine: &mut Engine, driven: Driven, shared: &ServoShared) -> Report {
    let priority = match driven {
        Driven::ByTimer(_) => priority::raise(priority::SERVO),
        Driven::ByDevice(_) => Priority::Device,
    };
    // Nobody else sets these two.
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

    /// Why it is over, once it is.
    #[must_use]
    pub fn ended(&self) -> Option<Ended> {
        self.shared.ended.get().copied()
    }

    /// Asks it to stop, without waiting: from a signal, for example.
    pub fn ask_to_stop(&self) {
        self.shared.stop.store(true, Ordering::Relaxed);
    }

    /// Stops it and says how it went; `None` if the thread itself was killed by a defect.
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
