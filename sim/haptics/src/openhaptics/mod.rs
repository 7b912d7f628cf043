//! OpenHaptics devices: the Phantom Omni, its successor the Touch, and the Phantom Desktop.
//!
//! The device has its own clock: the vendor's scheduler calls back at 1 kHz and the servo's tick
//! runs inside that call, so that a force responds to the position of the same millisecond. The
//! library `libHD.so` (`HD.dll`) is loaded when a device is opened.
//!
//! Tested with a substitute library with the same ABI, `tests/libhd`; not on hardware.

mod error;
mod ffi;
mod frame;

use std::ffi::{CString, OsString};
use std::panic::resume_unwind;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use nalgebra::{UnitQuaternion, Vector3};

pub use self::error::OpenHapticsError;
use self::ffi::{ErrorInfo, Handle, Hd, LoadError, calibration, name};
use self::frame::{DeviceFrame, Watch, read_motor_heat};
use crate::clock;
use crate::device::{Clocked, DeviceFault, DeviceInfo, Reading, Tick};

/// Interval at which the waiting thread checks for frames.
const LOOK: Duration = Duration::from_millis(5);
/// Checks without a frame after which the device is lost: a second.
const LOST_AFTER_LOOKS: u32 = 200;
/// Number of calibration attempts of a device in its inkwell, and the time for each.
const CALIBRATIONS: u32 = 5;
const CALIBRATION: Duration = Duration::from_millis(50);
/// Checks that the last frame gets to set zero force before the scheduler is stopped: a tenth of a
/// second.
const LAST_FRAME_LOOKS: u32 = 20;

/// Options for opening a device.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct OpenHapticsOptions {
    /// File name or path of the library.
    pub library: OsString,
    /// Name of the device in the vendor's configuration; the default device if absent.
    pub device: Option<String>,
}

impl Default for OpenHapticsOptions {
    fn default() -> Self {
        Self { library: libloading::library_filename("HD"), device: None }
    }
}

/// An open device.
pub struct OpenHaptics {
    hd: Hd,
    device: Handle,
    info: DeviceInfo,
    /// Middle of the workspace, in m, in the driver's coordinates.
    middle_m: Vector3<f64>,
    /// It reports the temperature of its motors: old drivers answer with an error.
    reports_heat: bool,
}

impl OpenHaptics {
    /// Opens a device, calibrates it if no manual action is needed, and switches its motors on, at
    /// zero force.
    ///
    /// # Errors
    /// The first missing requirement; see [`OpenHapticsError::advice`].
    pub fn open(options: &OpenHapticsOptions) -> Result<Self, OpenHapticsError> {
        let hd = load_openhaptics(options)?;
        let wanted = options.device.as_deref().unwrap_or("the default device");
        let not_found = |info: ErrorInfo| OpenHapticsError::of_device(wanted, info, hd.error_in_words(info.code));
        // No device has a name with a NUL inside.
        let name = options.device.as_deref().map(CString::new).transpose().map_err(|_| not_found(NO_DEVICE))?;
        let device = hd.init_device(name.as_deref());
        if let Some(info) = hd.error() {
            return Err(not_found(info));
        }
        // Some drivers return an invalid handle and report no error.
        if device == ffi::INVALID_HANDLE {
            return Err(not_found(NO_DEVICE));
        }
        let info = describe_device(&hd);
        let workspace_mm = hd.doubles(name::USABLE_WORKSPACE);
        let _heat = read_motor_heat(&hd);
        let reports_heat = hd.error().is_none();
        let this = Self { hd, device, info, middle_m: middle_m(&workspace_mm), reports_heat };
        this.calibrate()?;
        this.switch_on()?;
        Ok(this)
    }

    fn calibrate(&self) -> Result<(), OpenHapticsError> {
        let mut status = self.hd.check_calibration();
        if status == calibration::NEEDS_UPDATE {
            let offered = self.hd.integer(name::CALIBRATION_STYLE);
            let by_itself = [calibration::AUTO, calibration::INKWELL].into_iter().find(|style| offered & style != 0);
            by_itself.into_iter().for_each(|style| self.update_calibration(style));
            status = self.hd.check_calibration();
        }
        match (status, self.hd.error()) {
            (calibration::OK, None) => Ok(()),
            (status, _) => Err(OpenHapticsError::NotCalibrated { status }),
        }
    }

    /// Calibrates while frames without force are made: the reference requires a running scheduler
    /// to calibrate a device in its inkwell or automatically.
    fn update_calibration(&self, style: u32) {
        let mut frame = || {
            self.hd.begin_frame(self.device);
            self.hd.end_frame(self.device);
            true
        };
        let scheduled = self.hd.while_scheduled(&mut frame, || {
            (0..CALIBRATIONS).find(|_| {
                self.hd.update_calibration(style);
                std::thread::sleep(CALIBRATION);
                self.hd.check_calibration() == calibration::OK
            });
        });
        // A failure shows in the calibration status, which the caller checks.
        let _unscheduled = scheduled;
    }

    fn switch_on(&self) -> Result<(), OpenHapticsError> {
        let on = self.hd.enable(name::FORCE_OUTPUT);
        match self.hd.error() {
            None if on => Ok(()),
            error => {
                let words = error.map(|info| self.hd.error_in_words(info.code)).unwrap_or_default();
                Err(OpenHapticsError::ForceRefused { model: self.info.name.clone(), words })
            }
        }
    }

    /// Waits while frames are made; returns a fault if they stop.
    fn wait(watch: &Watch, stop: &AtomicBool) -> Option<DeviceFault> {
        let (mut seen, mut looks) = (0, 0);
        while !watch.ended.load(Ordering::Acquire) {
            std::thread::sleep(LOOK);
            let frames = watch.frames.load(Ordering::Relaxed);
            looks = if frames == seen { looks + 1 } else { 0 };
            seen = frames;
            let patience = if stop.load(Ordering::Relaxed) { LAST_FRAME_LOOKS } else { LOST_AFTER_LOOKS };
            if looks > patience {
                return Some(DeviceFault::Gone);
            }
        }
        None
    }
}

impl Clocked for OpenHaptics {
    fn info(&self) -> &DeviceInfo {
        &self.info
    }

    fn run(&mut self, tick: &mut Tick<'_>, stop: &AtomicBool) -> Result<(), DeviceFault> {
        let watch = Watch::default();
        let at_rest = Reading {
            t_s: clock::now_s(),
            position_m: Vector3::zeros(),
            orientation: UnitQuaternion::identity(),
            buttons: 0,
            motor_heat: 0.0,
        };
        let (hd, info, watched) = (&self.hd, &self.info, &watch);
        let (device, middle_m) = (self.device, self.middle_m);
        let mut frame = DeviceFrame {
            hd,
            device,
            info,
            middle_m,
            tick,
            stop,
            watch: watched,
            reports_heat: self.reports_heat,
            reading: at_rest,
            fault: None,
            panic: None,
        };
        let mut silent = None;
        let scheduled = hd.while_scheduled(&mut || frame.make(), || silent = Self::wait(watched, stop));
        if let Some(panic) = frame.panic.take() {
            resume_unwind(panic);
        }
        scheduled.map_err(error::describe_fault)?;
        match silent.or(frame.fault) {
            Some(DeviceFault::Gone) => Err(DeviceFault::Gone),
            _ => Ok(()),
        }
    }
}

impl Drop for OpenHaptics {
    fn drop(&mut self) {
        self.hd.disable(name::FORCE_OUTPUT);
        self.hd.disable_device(self.device);
    }
}

fn load_openhaptics(options: &OpenHapticsOptions) -> Result<Hd, OpenHapticsError> {
    let library = options.library.to_string_lossy().into_owned();
    Hd::load(&options.library).map_err(|error| match error {
        LoadError::NotFound(why) => OpenHapticsError::LibraryNotFound { library, why },
        LoadError::Lacks(symbol) => OpenHapticsError::WrongVersion { library, symbol },
    })
}

/// Stands for the error of a driver that reports none.
const NO_DEVICE: ErrorInfo = ErrorInfo { code: 0, internal_code: 0, device: ffi::INVALID_HANDLE };

/// The values that the device reports, where plausible; otherwise conservative values for its
/// model.
fn describe_device(hd: &Hd) -> DeviceInfo {
    let known = DataSheet::for_model(&hd.string(name::MODEL_TYPE));
    let serial = Some(hd.string(name::SERIAL_NUMBER)).filter(|serial| !serial.is_empty());
    let number = |name| Some(hd.doubles::<1>(name)[0]).filter(|value| value.is_finite() && *value > 0.0);
    // The driver uses N/mm. Where it and the table differ, the softer wall is the safe one.
    let stiffness = number(name::NOMINAL_MAX_STIFFNESS).map_or(f64::INFINITY, |n_per_mm| n_per_mm * 1e3);
    let workspace_mm: [f64; 6] = hd.doubles(name::USABLE_WORKSPACE);
    let info = DeviceInfo {
        name: known.name,
        serial,
        max_force_n: number(name::NOMINAL_MAX_FORCE).unwrap_or(known.max_force_n),
        continuous_force_n: number(name::NOMINAL_MAX_CONTINUOUS_FORCE).unwrap_or(known.continuous_force_n),
        max_stiffness_n_per_m: stiffness.min(known.max_stiffness_n_per_m),
        workspace_m: extent_m(&workspace_mm).unwrap_or([0.160, 0.120, 0.070]),
        measures_orientation: true,
        is_virtual: false,
    };
    // A value that an old device cannot report is not an error of opening it.
    let _forgotten = hd.error();
    info
}

/// Data sheet values of a model.
struct DataSheet {
    name: String,
    max_force_n: f64,
    continuous_force_n: f64,
    max_stiffness_n_per_m: f64,
}

impl DataSheet {
    fn for_model(model: &str) -> Self {
        let (max_force_n, continuous_force_n, max_stiffness_n_per_m) = match model {
            model if model.contains("Omni") => (3.3, 0.88, 700.0),
            model if model.contains("Desktop") => (7.9, 1.75, 1000.0),
            _ => (3.3, 0.88, 400.0),
        };
        let name = if model.is_empty() { "OpenHaptics device" } else { model };
        Self { name: name.to_owned(), max_force_n, continuous_force_n, max_stiffness_n_per_m }
    }
}

/// Width, height and depth in m, from the corners (least x, y, z, then greatest) in mm.
fn extent_m(corners_mm: &[f64; 6]) -> Option<[f64; 3]> {
    let extent_m = [0, 1, 2].map(|axis| (corners_mm[axis + 3] - corners_mm[axis]) * 1e-3);
    extent_m.iter().all(|side_m| side_m.is_finite() && *side_m > 0.0).then_some(extent_m)
}

/// Middle between the corners, in m; the driver's origin if the corners are invalid.
fn middle_m(corners_mm: &[f64; 6]) -> Vector3<f64> {
    match extent_m(corners_mm) {
        Some(_) => Vector3::from_fn(|axis, _| (corners_mm[axis] + corners_mm[axis + 3]) * 0.5e-3),
        None => Vector3::zeros(),
    }
}
