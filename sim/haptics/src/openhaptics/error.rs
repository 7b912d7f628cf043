//! Why a device could not be opened, and what its errors mean while it is in use.

use super::ffi::ErrorInfo;
use crate::device::DeviceFault;

/// Why an OpenHaptics device could not be opened.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum OpenHapticsError {
    /// The system does not find the library, or cannot load it.
    #[error("library not found: {library} cannot be loaded: {why}")]
    LibraryNotFound {
        /// Name or path that was looked for.
        library: String,
        /// The system's words.
        why: String,
    },
    /// The library is not the HD library, or one of another version.
    #[error("wrong driver version: {library} lacks the function {symbol}")]
    WrongVersion {
        /// Name or path of the library.
        library: String,
        /// The first function that it lacks.
        symbol: &'static str,
    },
    /// The driver finds no such device.
    #[error("device not found: {device}: the driver reports 0x{code:04x}, {words}")]
    DeviceNotFound {
        /// The device that was asked for.
        device: String,
        /// The driver's error.
        code: u32,
        /// The driver's words.
        words: String,
    },
    /// The driver's licence does not allow it.
    #[error("licence refused: the driver reports 0x{code:04x}, {words}")]
    Licence {
        /// The driver's error.
        code: u32,
        /// The driver's words.
        words: String,
    },
    /// The device must be calibrated by hand.
    #[error("calibration needed: the device reports 0x{status:04x}")]
    NotCalibrated {
        /// The driver's calibration status.
        status: u32,
    },
    /// The motors cannot be switched on.
    #[error("force refused: {model} does not switch its force output on: {words}")]
    ForceRefused {
        /// Model of the device.
        model: String,
        /// The driver's words, if it had any.
        words: String,
    },
}

impl OpenHapticsError {
    /// The error of opening `device`.
    pub(super) fn of_device(device: &str, info: ErrorInfo, words: String) -> Self {
        match info.code {
            INVALID_LICENCE => Self::Licence { code: info.code, words },
            code => Self::DeviceNotFound { device: device.to_owned(), code, words },
        }
    }

    /// What to do about it.
    #[must_use]
    pub fn advice(&self) -> &'static str {
        match self {
            Self::LibraryNotFound { .. } => {
                "install the OpenHaptics runtime and the device's driver, or name its library with --openhaptics FILE"
            }
            Self::WrongVersion { .. } => {
                "install OpenHaptics 3.4 or later; no other library may be named libHD.so or HD.dll"
            }
            Self::DeviceNotFound { .. } => {
                "connect and switch on the device, close other programs that use it, and set it up in the vendor's Touch \
                 Setup under the name that is asked for"
            }
            Self::Licence { .. } => "renew the OpenHaptics licence in the vendor's licence manager",
            Self::NotCalibrated { .. } => {
                "put the stylus into its inkwell and keep it there for a moment, or calibrate in the vendor's Touch Diagnostic"
            }
            Self::ForceRefused { .. } => {
                "check the power supply, let the motors cool down, and try the forces in the vendor's Touch Diagnostic"
            }
        }
    }
}

/// The licence does not cover what is asked.
const INVALID_LICENCE: u32 = 0x0600;
/// Errors of force: warm motors, too much force or velocity, motors that do not answer.
const FORCE_ERRORS: std::ops::RangeInclusive<u32> = 0x0200..=0x02FF;
/// Device fault, communication and timer: the device is no longer there.
const LOST: [u32; 4] = [0x0300, 0x0302, 0x0303, 0x0304];

/// What an error means for a device in use.
pub(super) fn describe_fault(info: ErrorInfo) -> DeviceFault {
    match info.code {
        code if LOST.contains(&code) => DeviceFault::Gone,
        code if FORCE_ERRORS.contains(&code) => DeviceFault::RefusesForce(code),
        code => DeviceFault::Reported(code),
    }
}

/// The graver of two errors of a frame, the first of which is the younger; the older of two alike, from which the other follows.
pub(super) fn graver(younger: DeviceFault, older: DeviceFault) -> DeviceFault {
    let rank = |fault: DeviceFault| match fault {
        DeviceFault::Gone => 2,
        DeviceFault::RefusesForce(_) => 1,
        DeviceFault::Reported(_) => 0,
    };
    if rank(younger) > rank(older) { younger } else { older }
}
