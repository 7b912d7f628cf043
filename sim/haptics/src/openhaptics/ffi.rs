//! The C ABI of the HD library, and the only unsafe code of the driver. The library is loaded at
//! run time, so that Stylet builds and starts without it.
//!
//! Constants and types: the OpenHaptics Toolkit, API reference, HD.

#![expect(unsafe_code, reason = "the vendor's library is C, loaded at run time")]

use std::error::Error;
use std::ffi::{CStr, OsStr, c_char, c_ulong, c_void};
use std::mem::ManuallyDrop;

use libloading::Library;

/// Handle of a device in the library.
pub type Handle = u32;
/// The invalid handle.
pub const INVALID_HANDLE: Handle = 0xFFFF_FFFF;

/// Names of parameters and capabilities.
pub mod name {
    pub const CURRENT_BUTTONS: u32 = 0x2000;
    pub const CURRENT_TRANSFORM: u32 = 0x2052;
    pub const MODEL_TYPE: u32 = 0x2501;
    pub const SERIAL_NUMBER: u32 = 0x2504;
    pub const USABLE_WORKSPACE: u32 = 0x2551;
    pub const CALIBRATION_STYLE: u32 = 0x2555;
    pub const NOMINAL_MAX_STIFFNESS: u32 = 0x2602;
    pub const NOMINAL_MAX_FORCE: u32 = 0x2603;
    pub const NOMINAL_MAX_CONTINUOUS_FORCE: u32 = 0x2604;
    pub const MOTOR_TEMPERATURE: u32 = 0x2605;
    pub const CURRENT_FORCE: u32 = 0x2700;
    pub const FORCE_OUTPUT: u32 = 0x4000;
}

/// Calibration states and styles.
pub mod calibration {
    pub const OK: u32 = 0x5000;
    pub const NEEDS_UPDATE: u32 = 0x5001;
    /// Styles that update without manual action at the device.
    pub const AUTO: u32 = 2;
    pub const INKWELL: u32 = 4;
}

/// Rate of the scheduler, in Hz: that of the servo.
const RATE_HZ: c_ulong = 1000;
const MAX_PRIORITY: u16 = 0xFFFF;
const CALLBACK_DONE: u32 = 0;
const CALLBACK_CONTINUE: u32 = 1;

/// Error report, returned by value.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ErrorInfo {
    /// 0 if there is no error.
    pub code: u32,
    /// The driver's internal code.
    pub internal_code: i32,
    /// Handle of the device.
    pub device: Handle,
}

type Callback = unsafe extern "system" fn(*mut c_void) -> u32;

/// Declares the functions used by the driver, and resolves each by its name.
macro_rules! functions {
    ($($field:ident = $symbol:literal ($($argument:ty),*) $(-> $answer:ty)?;)*) => {
        struct Functions { $($field: unsafe extern "system" fn($($argument),*) $(-> $answer)?,)* }

        impl Functions {
            /// Resolves all functions; returns the name of the first missing one as the error.
            fn find(library: &Library) -> Result<Self, &'static str> {
                // SAFETY: each symbol is a function of the HD API with the signature that its
                // reference gives.
                Ok(Self { $($field: *unsafe { library.get($symbol) }.map_err(|_| $symbol)?,)* })
            }
        }
    };
}

functions! {
    init_device = "hdInitDevice" (*const c_char) -> Handle;
    disable_device = "hdDisableDevice" (Handle);
    make_current_device = "hdMakeCurrentDevice" (Handle);
    begin_frame = "hdBeginFrame" (Handle);
    end_frame = "hdEndFrame" (Handle);
    get_error = "hdGetError" () -> ErrorInfo;
    get_error_string = "hdGetErrorString" (u32) -> *const c_char;
    enable = "hdEnable" (u32);
    disable = "hdDisable" (u32);
    is_enabled = "hdIsEnabled" (u32) -> u8;
    get_doubles = "hdGetDoublev" (u32, *mut f64);
    get_integers = "hdGetIntegerv" (u32, *mut i32);
    get_string = "hdGetString" (u32) -> *const c_char;
    set_doubles = "hdSetDoublev" (u32, *const f64);
    check_calibration = "hdCheckCalibration" () -> u32;
    update_calibration = "hdUpdateCalibration" (u32);
    start_scheduler = "hdStartScheduler" ();
    stop_scheduler = "hdStopScheduler" ();
    set_scheduler_rate = "hdSetSchedulerRate" (c_ulong);
    schedule_asynchronous = "hdScheduleAsynchronous" (Callback, *mut c_void, u16) -> c_ulong;
    unschedule = "hdUnschedule" (c_ulong);
}

/// Why the library cannot be used.
pub enum LoadError {
    /// The library cannot be found or loaded; the system's message.
    NotFound(String),
    /// The library lacks this function.
    Lacks(&'static str),
}

/// The loaded library.
pub struct Hd {
    functions: Functions,
    // Never unloaded: a driver's threads outlive its devices, and the next attempt opens one again.
    _library: ManuallyDrop<Library>,
}

impl Hd {
    /// Loads the library with this file name or path.
    pub fn load(file: &OsStr) -> Result<Self, LoadError> {
        // SAFETY: the file is the vendor's driver, named by the user or the system's search path;
        // its initialisers run.
        let library = unsafe { open(file) }.map_err(|error| {
            // The source of the error has the system's message, which names a missing dependency of
            // the library.
            let words = error.source().map_or_else(|| error.to_string(), ToString::to_string);
            LoadError::NotFound(words)
        })?;
        let functions = Functions::find(&library).map_err(LoadError::Lacks)?;
        Ok(Self { functions, _library: ManuallyDrop::new(library) })
    }

    /// Opens a device by its configured name, or the default device. Errors are in [`Hd::error`].
    pub fn init_device(&self, device: Option<&CStr>) -> Handle {
        let device = device.map_or(std::ptr::null(), CStr::as_ptr);
        // SAFETY: null or a string that ends with a zero and outlives the call.
        unsafe { (self.functions.init_device)(device) }
    }

    /// Releases a device.
    pub fn disable_device(&self, device: Handle) {
        // SAFETY: takes any handle, and reports one that is not open.
        unsafe { (self.functions.disable_device)(device) }
    }

    /// Begins a frame of a device: all values read until its end are consistent.
    pub fn begin_frame(&self, device: Handle) {
        // SAFETY: both take any handle, and report an error for one that is not open.
        unsafe {
            (self.functions.make_current_device)(device);
            (self.functions.begin_frame)(device);
        }
    }

    /// Ends a frame and sends the force to the motors.
    pub fn end_frame(&self, device: Handle) {
        // SAFETY: takes any handle, and reports a frame that was not begun.
        unsafe { (self.functions.end_frame)(device) }
    }

    /// Drains the library's error stack, most recent first. Bounded, in case it never empties.
    pub fn errors(&self) -> impl Iterator<Item = ErrorInfo> + '_ {
        // SAFETY: no arguments; the answer is plain data.
        let next = || Some(unsafe { (self.functions.get_error)() }).filter(|info| info.code != 0);
        std::iter::from_fn(next).take(ERRORS_KEPT)
    }

    /// Drains the error stack and returns the oldest error; the later ones follow from it.
    pub fn error(&self) -> Option<ErrorInfo> {
        self.errors().last()
    }

    /// The library's message for an error.
    pub fn error_in_words(&self, code: u32) -> String {
        // SAFETY: takes any code; the answer is null or a constant of the library.
        unsafe { text((self.functions.get_error_string)(code)) }
    }

    /// Enables a capability and returns whether it is now enabled.
    pub fn enable(&self, capability: u32) -> bool {
        // SAFETY: both take any capability, and report an unknown one.
        unsafe {
            (self.functions.enable)(capability);
            (self.functions.is_enabled)(capability) != 0
        }
    }

    /// Disables a capability.
    pub fn disable(&self, capability: u32) {
        // SAFETY: takes any capability, and reports an unknown one.
        unsafe { (self.functions.disable)(capability) }
    }

    /// Reads numbers by name. `N` is at least the length given in the reference; values not written
    /// stay NaN.
    pub fn doubles<const N: usize>(&self, name: u32) -> [f64; N] {
        let mut values = [f64::NAN; N];
        // SAFETY: the callers in this driver pass an array of the length in the reference for each
        // name.
        unsafe { (self.functions.get_doubles)(name, values.as_mut_ptr()) };
        values
    }

    /// Reads an integer or bit mask by name.
    pub fn integer(&self, name: u32) -> u32 {
        let mut value = 0_i32;
        // SAFETY: the callers in this driver only use names that hold one integer.
        unsafe { (self.functions.get_integers)(name, &raw mut value) };
        value.cast_unsigned()
    }

    /// Reads a text by name.
    pub fn string(&self, name: u32) -> String {
        // SAFETY: takes any name; the answer is null or a string of the library.
        unsafe { text((self.functions.get_string)(name)) }
    }

    /// Sets the force of the current frame, in N.
    pub fn set_force(&self, force_n: &[f64; 3]) {
        // SAFETY: the current force is three numbers.
        unsafe { (self.functions.set_doubles)(name::CURRENT_FORCE, force_n.as_ptr()) }
    }

    /// Returns the state of the calibration; one of [`calibration`].
    pub fn check_calibration(&self) -> u32 {
        // SAFETY: no arguments.
        unsafe { (self.functions.check_calibration)() }
    }

    /// Calibrates with a style.
    pub fn update_calibration(&self, style: u32) {
        // SAFETY: takes any style, and reports one that the device lacks.
        unsafe { (self.functions.update_calibration)(style) }
    }

    /// Calls `frame` from the scheduler's thread, a thousand times a second, until it returns false
    /// or `wait` returns. `frame` must not panic: the scheduler cannot unwind.
    pub fn while_scheduled<F: FnMut() -> bool + Send>(
        &self,
        frame: &mut F,
        wait: impl FnOnce(),
    ) -> Result<(), ErrorInfo> {
        let data = std::ptr::from_mut(frame).cast::<c_void>();
        // SAFETY: `data` points to an `F`, which the scheduler alone uses until the guard below has
        // stopped and unscheduled it, also when `wait` panics; it outlives this call.
        let guard = unsafe {
            let callback = (self.functions.schedule_asynchronous)(call::<F>, data, MAX_PRIORITY);
            let guard = Scheduled { hd: self, callback };
            (self.functions.set_scheduler_rate)(RATE_HZ);
            guard
        };
        // Some older drivers reject a rate and keep 1 kHz, their default: not an error.
        let refused = self.errors().filter(|info| !RATE_REFUSALS.contains(&info.code)).last();
        // SAFETY: no arguments.
        unsafe { (self.functions.start_scheduler)() };
        if let Some(error) = refused.or_else(|| self.error()) {
            return Err(error);
        }
        wait();
        drop(guard);
        Ok(())
    }
}

/// Opens a library.
///
/// # Safety
/// The file is a library whose initialisers may run.
#[cfg(not(windows))]
unsafe fn open(file: &OsStr) -> Result<Library, libloading::Error> {
    // SAFETY: guaranteed by the caller.
    unsafe { Library::new(file) }
}

/// Opens a library. With a full path, Windows looks for the libraries that it needs in its own
/// folder first: the vendor's driver brings several.
///
/// # Safety
/// The file is a library whose initialisers may run.
#[cfg(windows)]
unsafe fn open(file: &OsStr) -> Result<Library, libloading::Error> {
    use libloading::os::windows::{LOAD_WITH_ALTERED_SEARCH_PATH, Library as WindowsLibrary};
    let flags = if std::path::Path::new(file).is_absolute() { LOAD_WITH_ALTERED_SEARCH_PATH } else { 0 };
    // SAFETY: guaranteed by the caller.
    unsafe { WindowsLibrary::load_with_flags(file, flags) }.map(Library::from)
}

/// Bound of the error stack, more than can accumulate between two calls.
const ERRORS_KEPT: usize = 64;
/// Invalid value, invalid operation, timer: the errors of drivers for a rate that they cannot set.
const RATE_REFUSALS: [u32; 3] = [0x0101, 0x0102, 0x0304];

/// A callback in the scheduler; dropping it first stops the scheduler and then removes the
/// callback.
struct Scheduled<'a> {
    hd: &'a Hd,
    callback: c_ulong,
}

impl Drop for Scheduled<'_> {
    fn drop(&mut self) {
        // SAFETY: the handle was returned by scheduling; stopping returns when no callback runs any
        // more.
        unsafe {
            (self.hd.functions.stop_scheduler)();
            (self.hd.functions.unschedule)(self.callback);
        }
    }
}

/// The scheduler's callback.
unsafe extern "system" fn call<F: FnMut() -> bool + Send>(data: *mut c_void) -> u32 {
    // SAFETY: `while_scheduled` gave the scheduler a pointer to an `F` that nothing else uses while
    // it is scheduled.
    let frame = unsafe { &mut *data.cast::<F>() };
    if frame() { CALLBACK_CONTINUE } else { CALLBACK_DONE }
}

/// Copies a string of the library; empty if the pointer is null.
///
/// # Safety
/// `text` is null or points to a NUL-terminated string.
unsafe fn text(text: *const c_char) -> String {
    if text.is_null() {
        return String::new();
    }
    // SAFETY: not null, and guaranteed by the caller.
    unsafe { CStr::from_ptr(text) }.to_string_lossy().into_owned()
}
