//! A stand-in for the HD library of OpenHaptics: the symbols, the ABI and the manners of the vendor's `libHD.so`, with a
//! scripted device behind them. The driver is tested by loading it.
//!
//! The ABI is stated here a second time on purpose: a stand-in that took its types from the driver would agree with any
//! mistake in them.

#![expect(clippy::expect_used, reason = "a stand-in that cannot do its part has nobody to tell but the test")]

mod abi;
mod control;
mod device;

pub use control::{ENVIRONMENT, StandIn, lacking};

/// How many forces and calls are noted.
pub const NOTED: usize = 4096;

/// How the device behaves.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Script {
    /// Error of `hdInitDevice`; 0 for none.
    pub init_error: u32,
    /// What `hdCheckCalibration` answers.
    pub calibration: u32,
    /// `hdUpdateCalibration` calibrates it.
    pub calibrates: bool,
    /// Its force output can be switched on.
    pub takes_force: bool,
    /// Time between frames, in µs.
    pub period_us: u64,
    /// Way of the handle from one frame to the next, in mm along the device's axes.
    pub step_mm: [f64; 3],
    /// Step of its encoders, in mm; 0 for one that has none.
    pub encoder_mm: f64,
    /// Frames with the same reading, from 1.
    pub repeats: usize,
    /// Temperature of its motors, from 0 to 1; below 0 for a driver that does not know the name.
    pub motor_heat: f64,
    /// Frames run inside `hdStartScheduler`, in the caller's thread, instead of a thread of their own.
    pub inline: bool,
    /// The frame at which something happens, counted from 0.
    pub at_frame: u64,
    /// What happens then, and from then on.
    pub then: Then,
}

/// What happens to a device in use.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Then {
    /// Nothing.
    Nothing,
    /// Every frame ends with this error.
    Error(u32),
    /// Every frame ends with these errors, the second because of the first.
    Errors([u32; 2]),
    /// That frame ends with this error, and no other: a cable that was pulled and put back.
    ErrorOnce(u32),
    /// No further frame is made.
    Silence,
    /// Its transform is not a number.
    NotANumber,
}

impl Default for Script {
    fn default() -> Self {
        Self {
            init_error: 0,
            calibration: 0x5000,
            calibrates: false,
            takes_force: true,
            period_us: 1000,
            step_mm: [1.0, 0.0, 0.0],
            encoder_mm: 0.0,
            repeats: 1,
            motor_heat: 0.0,
            inline: false,
            at_frame: u64::MAX,
            then: Then::Nothing,
        }
    }
}

impl Script {
    /// The script that a word stands for, as the environment of another program gives it.
    fn named(word: &str) -> Self {
        let good = Self::default();
        match word {
            "no-device" => Self { init_error: 0x0301, ..good },
            "lost-once" => Self { at_frame: 400, then: Then::ErrorOnce(0x0302), ..good },
            "no-licence" => Self { init_error: 0x0600, ..good },
            "not-calibrated" => Self { calibration: 0x5002, ..good },
            "refuses-force" => Self { takes_force: false, ..good },
            _ => good,
        }
    }
}

/// A call worth noting.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Call {
    /// `hdInitDevice`
    Init,
    /// `hdCheckCalibration`
    CheckCalibration,
    /// `hdUpdateCalibration`
    UpdateCalibration,
    /// `hdEnable(HD_FORCE_OUTPUT)`
    EnableForce,
    /// `hdScheduleAsynchronous` at the highest priority
    Schedule,
    /// `hdStartScheduler`
    Start,
    /// `hdStopScheduler`
    Stop,
    /// `hdUnschedule`
    Unschedule,
    /// `hdDisable(HD_FORCE_OUTPUT)`
    DisableForce,
    /// `hdDisableDevice`
    DisableDevice,
}

/// What the library heard. Plain data of a fixed size: it passes between two copies of the standard library.
#[derive(Clone, Copy, Debug)]
pub struct Heard {
    calls: [Option<Call>; 32],
    forces_n: [[f64; 3]; NOTED],
    /// Frames begun and ended.
    pub frames: usize,
    /// Calls against the rules: a frame begun twice or not at all, a force outside a frame, too much force.
    pub faults: usize,
}

impl Heard {
    /// The calls, in order.
    #[must_use]
    pub fn calls(&self) -> Vec<Call> {
        self.calls.iter().flatten().copied().collect()
    }

    /// The force of each frame, in N; the first [`NOTED`].
    #[must_use]
    pub fn forces_n(&self) -> &[[f64; 3]] {
        &self.forces_n[..self.frames.min(NOTED)]
    }
}
