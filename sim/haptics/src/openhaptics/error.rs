//! Errors of opening a device, and the meaning of its error codes in use.

use super::ffi::ErrorInfo;
use crate::device::DeviceFault;

/// Why an OpenHaptics device could not be opened.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum OpenHapticsError {
    /// The library cannot be found or loaded.
    #[error("library not found: {library} cannot be loaded: {why}")]
    LibraryNotFound {
        /// The requested name or path.
        library: String,
        /// The system's message.
        why: String,
    },
    /// The library is not the HD library, or has another version.
    #[error("wrong driver version: {library} lacks the function {symbol}")]
    WrongVersion {
        /// Name or path of the library.
        library: String,
        /// The first missing function.
        symbol: &'static str,
    },
    /// The driver does not find the device.
    #[error("device not found: {device}: the driver reports 0x{code:04x}, {words}")]
    DeviceNotFound {
        /// The requested device.
        device: String,
        /// The driver's error code.
        code: u32,
        /// The driver's message.
        words: String,
    },
    /// The driver's licence does not permit the use.
    #[error("licence refused: the driver reports 0x{code:04x}, {words}")]
    Licence {
        /// The driver's error code.
        code: u32,
        /// The driver's message.
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
        /// The driver's message, if any.
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

    /// Advice for the user.
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
                "connect and switch on the device, close other programs that use it, and set it up in the vendor's \
                 Touch Setup under the requested name"
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

/// The licence does not cover the operation.
const INVALID_LICENCE: u32 = 0x0600;
/// Force errors: warm motors, excessive force or velocity, motors that do not respond.
const FORCE_ERRORS: std::ops::RangeInclusive<u32> = 0x0200..=0x02FF;
/// Device fault, communication and timer errors: the device is lost.
const LOST: [u32; 4] = [0x0300, 0x0302, 0x0303, 0x0304];

/// Maps an error of a device in use to a fault.
pub(super) fn describe_fault(info: ErrorInfo) -> DeviceFault {
    match info.code {
        code if LOST.contains(&code) => DeviceFault::Gone,
        code if FORCE_ERRORS.contains(&code) => DeviceFault::RefusesForce(code),
        code => DeviceFault::Reported(code),
    }
}

/// The more serious of two errors of a frame; of two equally serious ones, the older, which caused
/// the other.
pub(super) fn graver(younger: DeviceFault, older: DeviceFault) -> DeviceFault {
    let rank = |fault: DeviceFault| match fault {
        DeviceFault::Gone => 2,
        DeviceFault::RefusesForce(_) => 1,
        DeviceFault::Reported(_) => 0,
    };
    if rank(younger) > rank(older) { younger } else { older }
}
