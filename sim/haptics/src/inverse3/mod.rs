//! The Haply Inverse3 with a VerseGrip, through the Haply Inverse Service: JSON over a WebSocket.
//!
//! A thread of the driver communicates with the service (`exchange.rs`); the servo's side reads and
//! writes latest-value cells and never waits. Both spellings of a force command are supported: the
//! service's version decides, and both are sent if the version is unknown. The force that the
//! service reports is compared with the commanded one. Without a VerseGrip the needle keeps the
//! planned direction.
//!
//! Tested with a simulated service that uses the same protocol; not on hardware.

mod agreement;
mod axes;
mod command;
mod error;
mod exchange;
mod session;
mod state;
mod version;

use std::sync::Arc;
use std::sync::atomic::Ordering;
use std::thread::{self, JoinHandle};

use nalgebra::{UnitQuaternion, Vector3};
use triple_buffer::{Input, Output, triple_buffer};

use self::agreement::Agreement;
pub use self::command::Dialect;
use self::command::SetForce;
pub use self::error::Inverse3Error;
use self::exchange::{Exchange, Shared};
use self::session::Inverse3Session;
use self::state::StateFrame;
use self::version::Version;
use crate::clock;
use crate::device::{Device, DeviceFault, DeviceInfo, Reading};

/// Fault codes of this driver.
pub mod code {
    /// [`DeviceFault::Reported`](crate::device::DeviceFault): a message of the service cannot be
    /// parsed.
    pub const NOT_UNDERSTOOD: u32 = 1;
    /// [`DeviceFault::RefusesForce`](crate::device::DeviceFault), a bit: the arm is not calibrated.
    pub const NOT_CALIBRATED: u32 = 1;
    /// [`DeviceFault::RefusesForce`](crate::device::DeviceFault), a bit: the arm is not ready.
    pub const NOT_READY: u32 = 2;
    /// [`DeviceFault::RefusesForce`](crate::device::DeviceFault), a bit: the arm has no power
    /// supply.
    pub const NO_POWER: u32 = 4;
}

/// Greatest force that may be commanded, in N: the arm's own limit.
const GREATEST_FORCE_N: f64 = 10.0;

/// Options for opening the device.
#[derive(Clone, Debug, PartialEq)]
pub struct Inverse3Options {
    /// Address of the service.
    pub url: String,
    /// Identifier of the device, for example `04C3`; the first one if absent.
    pub device_id: Option<String>,
    /// Port that reports the service's version, if the port of `url` does not.
    pub version_port: u16,
    /// Spelling of a force command; if absent, it follows the service's version, and both are sent
    /// if that is unknown.
    pub dialect: Option<Dialect>,
    /// Maximum force, in N; at most 10.
    pub max_force_n: f64,
}

impl Default for Inverse3Options {
    fn default() -> Self {
        let url = "ws://localhost:10001".to_owned();
        Self { url, device_id: None, version_port: 10000, dialect: None, max_force_n: GREATEST_FORCE_N }
    }
}

/// Statistics of the exchange with the service.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Health {
    /// States received since the device was opened.
    pub states: u64,
    /// Messages that could not be parsed.
    pub garbage: u64,
    /// Whether the driver's thread still runs.
    pub running: bool,
}

/// An open device.
pub struct Inverse3 {
    info: DeviceInfo,
    version: Option<String>,
    readings: Output<Reading>,
    forces_n: Input<Vector3<f64>>,
    shared: Arc<Shared>,
    thread: Option<JoinHandle<()>>,
}

impl Inverse3 {
    /// Connects to the service, finds the device, and starts exchanging states with it, at zero
    /// force.
    ///
    /// # Errors
    /// The first missing requirement; see [`Inverse3Error::advice`].
    pub fn open(options: &Inverse3Options) -> Result<Self, Inverse3Error> {
        let mut session = Inverse3Session::connect(&options.url)?;
        let first = session.inventory(&options.url)?;
        let version = Version::ask(session.address, options.version_port);
        let dialect = match (options.dialect, &version) {
            (Some(dialect), _) => dialect,
            (None, None) => Dialect::Both,
            (None, Some(version)) => {
                version.dialect().ok_or_else(|| Inverse3Error::WrongVersion { found: version.text.clone() })?
            }
        };
        let (device_id, reading) = find_inverse3(&first, options.device_id.as_deref())?;
        let has_grip = StateFrame::read(&first).is_some_and(|frame| frame.has_grip());
        let info = describe_inverse3(&device_id, options.max_force_n, has_grip);
        let (readings_in, readings) = triple_buffer(&reading);
        let (forces_n, forces_out) = triple_buffer(&Vector3::zeros());
        let shared = Arc::new(Shared::default());
        let exchange = Exchange {
            session,
            command: SetForce::new(&device_id, dialect),
            device_id,
            readings: readings_in,
            forces_n: forces_out,
            reading,
            agreement: Agreement::default(),
            shared: Arc::clone(&shared),
        };
        let thread = thread::Builder::new().name("inverse3".to_owned()).spawn(|| exchange.run());
        let thread = Some(thread.map_err(|error| Inverse3Error::Unreachable {
            url: options.url.clone(),
            why: format!("the thread for its messages cannot be started: {error}"),
        })?);
        Ok(Self { info, version: version.map(|version| version.text), readings, forces_n, shared, thread })
    }

    /// The version that the service reports, if any.
    #[must_use]
    pub fn service_version(&self) -> Option<&str> {
        self.version.as_deref()
    }

    /// Statistics of the exchange.
    #[must_use]
    pub fn health(&self) -> Health {
        Health {
            states: self.shared.states.load(Ordering::Relaxed),
            garbage: self.shared.garbage.load(Ordering::Relaxed),
            running: self.thread.as_ref().is_some_and(|thread| !thread.is_finished()),
        }
    }
}

impl Device for Inverse3 {
    fn info(&self) -> &DeviceInfo {
        &self.info
    }

    fn read(&mut self) -> Result<Reading, DeviceFault> {
        match self.shared.fault() {
            Some(fault) => Err(fault),
            None => Ok(*self.readings.read()),
        }
    }

    fn write(&mut self, force_n: &Vector3<f64>) -> Result<(), DeviceFault> {
        self.forces_n.write(self.info.within_limits(force_n));
        match (self.shared.fault(), self.shared.refusal.load(Ordering::Relaxed)) {
            (Some(fault), _) => Err(fault),
            (None, 0) => Ok(()),
            (None, why) => Err(DeviceFault::RefusesForce(why)),
        }
    }

    fn disagrees(&self) -> bool {
        self.shared.disagrees.load(Ordering::Relaxed)
    }

    fn close(&mut self) {
        self.shared.closing.store(true, Ordering::Release);
        if let Some(thread) = self.thread.take() {
            // A thread that panicked has dropped its connection; there is nothing else to release.
            let _ended = thread.join();
        }
    }
}

impl Drop for Inverse3 {
    fn drop(&mut self) {
        self.close();
    }
}

/// Finds the requested device, and returns its identifier and first reading.
fn find_inverse3(first: &str, wanted: Option<&str>) -> Result<(String, Reading), Inverse3Error> {
    let at_rest = Reading {
        t_s: clock::now_s(),
        position_m: Vector3::zeros(),
        orientation: UnitQuaternion::identity(),
        buttons: 0,
        motor_heat: 0.0,
    };
    let frame = StateFrame::read(first);
    let arms = || frame.iter().flat_map(StateFrame::arms);
    let arm = arms().find(|arm| wanted.is_none_or(|wanted| arm.device_id == wanted)).ok_or_else(|| {
        let found: Vec<&str> = arms().map(|arm| &*arm.device_id).collect();
        let found = if found.is_empty() { "no Inverse3".to_owned() } else { found.join(", ") };
        Inverse3Error::NoDevice { wanted: wanted.unwrap_or("an Inverse3").to_owned(), found }
    })?;
    let device_id = arm.device_id.clone().into_owned();
    if let Some(why) = say_device(arm.refusal().unwrap_or(0)) {
        return Err(Inverse3Error::NotReady { device_id, why });
    }
    let reading = frame.as_ref().and_then(|frame| frame.reading(&device_id, at_rest.t_s, &at_rest));
    Ok((device_id, reading.unwrap_or(at_rest)))
}

/// The most serious reason why an arm rejects forces.
fn say_device(refusal: u32) -> Option<&'static str> {
    let reasons = [
        (code::NO_POWER, "without power supply"),
        (code::NOT_CALIBRATED, "not calibrated"),
        (code::NOT_READY, "not ready"),
    ];
    reasons.into_iter().find(|(bit, _)| refusal & bit != 0).map(|(_, why)| why)
}

/// The limits of the arm. The service does not report them; the workspace is a conservative box of
/// our choice inside the arm's reach, and the arm monitors the temperature of its motors itself.
fn describe_inverse3(device_id: &str, max_force_n: f64, has_grip: bool) -> DeviceInfo {
    let max_force_n = if max_force_n.is_nan() { 0.0 } else { max_force_n.clamp(0.0, GREATEST_FORCE_N) };
    DeviceInfo {
        // A recording stores the name, and with it whether the trainee controlled the needle's
        // orientation.
        name: if has_grip { "Inverse3" } else { "Inverse3 without VerseGrip" }.to_owned(),
        serial: Some(device_id.to_owned()),
        max_force_n,
        continuous_force_n: max_force_n,
        max_stiffness_n_per_m: 1000.0,
        workspace_m: [0.20, 0.16, 0.16],
        measures_orientation: has_grip,
        is_virtual: false,
    }
}
