//! The checks of haptic devices: each is opened as in a session, held at zero force for a moment,
//! and closed. A missing device limits training but does not prevent it: the mouse is always
//! available.

use std::sync::atomic::AtomicBool;
use std::time::Duration;

use haptics::device::{Clocked, Device, DeviceFault, DeviceInfo, Reading};
#[cfg(feature = "window")]
use haptics::devices::gamepad;
use haptics::inverse3::{self, Inverse3};
use haptics::openhaptics::{self, OpenHaptics};
use nalgebra::Vector3;

use super::{DoctorFinding, Level};
use crate::clock;

/// Time for which a device is held.
const HELD: Duration = Duration::from_millis(250);
/// Number of frames of an OpenHaptics device in that time.
const FRAMES: u32 = 250;
/// Exchange rate, per second, below which the delay becomes perceptible.
const FEW_PER_S: f64 = 900.0;

/// Checks an OpenHaptics device: library, licence, device, calibration, force, rate.
pub fn probe_openhaptics(options: &openhaptics::OpenHapticsOptions) -> DoctorFinding {
    let subject = "OpenHaptics";
    let mut device = match OpenHaptics::open(options) {
        Ok(device) => device,
        Err(error) => return DoctorFinding::warning(subject, error.to_string(), error.advice()),
    };
    let start = clock::instant();
    let mut frames = 0;
    let mut complaint = None;
    let mut tick = |_: &Reading, fault: Option<DeviceFault>| {
        frames += 1;
        complaint = complaint.or(fault);
        (frames < FRAMES).then(Vector3::zeros)
    };
    let ran = device.run(&mut tick, &AtomicBool::new(false));
    let per_s = f64::from(frames) / start.elapsed().as_secs_f64();
    held(subject, device.info(), per_s, ran.err().or(complaint))
}

/// Checks an Inverse3: service, its version, device, calibration and power, rate.
pub fn probe_inverse3(options: &inverse3::Inverse3Options) -> DoctorFinding {
    let subject = "Inverse3";
    let mut device = match Inverse3::open(options) {
        Ok(device) => device,
        Err(error) => return DoctorFinding::warning(subject, error.to_string(), error.advice()),
    };
    let start = clock::instant();
    let mut complaint = None;
    while start.elapsed() < HELD {
        std::thread::sleep(Duration::from_millis(1));
        complaint = complaint.or(device.write(&Vector3::zeros()).err());
    }
    let per_s = device.health().states as f64 / start.elapsed().as_secs_f64();
    let mut finding = held(subject, device.info(), per_s, complaint);
    let told_both = "of unknown version, forces sent in both formats";
    let version = device.service_version().unwrap_or(told_both);
    finding.found.push_str(&format!(", service {version}"));
    if !device.info().measures_orientation && finding.level == Level::Ok {
        finding.level = Level::Warning;
        "connect a VerseGrip and start its pairing in the Haply Hub; without one the needle points as planned"
            .clone_into(&mut finding.advice);
    }
    finding
}

/// Lists the gamepads.
#[cfg(feature = "window")]
pub fn probe_gamepads() -> DoctorFinding {
    let subject = "gamepads";
    match gamepad::connected() {
        Ok(names) if names.is_empty() => DoctorFinding::ok(subject, "none connected; the mouse can be used instead"),
        Ok(names) => DoctorFinding::ok(subject, names.join(", ")),
        Err(error) => DoctorFinding::warning(subject, error.to_string(), "connect one, or use the mouse"),
    }
}

/// The finding for a device that was held.
fn held(subject: &'static str, info: &DeviceInfo, per_s: f64, complaint: Option<DeviceFault>) -> DoctorFinding {
    let serial = info.serial.as_ref().map(|serial| format!(" {serial}")).unwrap_or_default();
    let found = format!(
        "{}{serial}: {:.1} N ({:.2} N continuous), {:.0} N/m, {per_s:.0} states per second",
        info.name, info.max_force_n, info.continuous_force_n, info.max_stiffness_n_per_m
    );
    match complaint {
        Some(fault) => {
            DoctorFinding::warning(subject, format!("{found}, but {fault}"), "try it in the vendor's own program")
        }
        None if per_s < FEW_PER_S => DoctorFinding::warning(
            subject,
            found,
            "close other programs that use the device or the processor; the servo needs 1000",
        ),
        None => DoctorFinding::ok(subject, found),
    }
}
