//! The traits that connect a haptic device to the servo.
//!
//! Frame of every device: x to the right, y up, z towards the user, origin at the middle of the
//! workspace.

use std::sync::atomic::AtomicBool;

use nalgebra::{UnitQuaternion, Vector3};

use crate::clamp;

/// Identity and limits of a device.
#[derive(Clone, Debug, PartialEq)]
pub struct DeviceInfo {
    /// Name shown to users and stored in recordings, for example `Touch`.
    pub name: String,
    /// Serial number, if the device has one.
    pub serial: Option<String>,
    /// Largest force, in N; 0 for a device without motors.
    pub max_force_n: f64,
    /// Continuous force limit, rms, in N.
    pub continuous_force_n: f64,
    /// Greatest stiffness that it can render, in N/m.
    pub max_stiffness_n_per_m: f64,
    /// Width, height and depth of its workspace, in m.
    pub workspace_m: [f64; 3],
    /// Whether it measures the orientation of the handle. If not, the needle keeps the planned
    /// direction.
    pub measures_orientation: bool,
    /// Whether the device has no motors because a program moves the hand (mouse, gamepad, virtual
    /// operator). It cannot hurt anyone, so the gate and the watchdog do not limit its force.
    pub is_virtual: bool,
}

impl DeviceInfo {
    /// Clamps `force_n`, in N, to the norm that the device can render and keeps its direction; zero
    /// if the force is not finite. Every driver applies this last, whatever the safety chain has
    /// done: clamping each axis would turn the force, and rejecting a force that is too large would
    /// drop it exactly at hard contact.
    #[must_use]
    pub fn within_limits(&self, force_n: &Vector3<f64>) -> Vector3<f64> {
        clamp::norm(force_n, self.max_force_n).0
    }
}

/// One reading of a device.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Reading {
    /// Time of the measurement, in s of a monotonic clock. Two readings with the same time are the
    /// same reading.
    pub t_s: f64,
    /// Position of the handle, in m, device frame.
    pub position_m: Vector3<f64>,
    /// Orientation of the handle, device_from_handle: +z of the handle points from its back to its
    /// tip.
    pub orientation: UnitQuaternion<f64>,
    /// Buttons held down, one bit each; see [`buttons`].
    pub buttons: u32,
    /// Temperature of the warmest motor as the device reports it, from 0 (cold) to 1 (too hot); 0 where it reports none.
    pub motor_heat: f64,
}

/// Bits of [`Reading::buttons`].
pub mod buttons {
    /// Confirms the position.
    pub const CONFIRM: u32 = 1;
    /// Lets the handle move without moving the needle (clutch).
    pub const CLUTCH: u32 = 2;
}

/// A fault of a device in use. Plain data, because the servo thread creates it and never allocates.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum DeviceFault {
    /// The device is disconnected.
    #[error("the device is gone")]
    Gone,
    /// The device rejects force commands.
    #[error("the device rejects the force (code {0})")]
    RefusesForce(u32),
    /// The device reports an error code of its own.
    #[error("the device reports error {0}")]
    Reported(u32),
}

/// A device in use. Reading and writing must not allocate, wait, lock or log.
pub trait Device: Send {
    /// Identity and limits of the device.
    fn info(&self) -> &DeviceInfo;

    /// Returns the latest reading, new or not.
    ///
    /// # Errors
    /// If no reading is available.
    fn read(&mut self) -> Result<Reading, DeviceFault>;

    /// Commands a force on the handle, in N, device frame. A device without motors ignores or
    /// displays it.
    ///
    /// # Errors
    /// If the device rejects the force.
    fn write(&mut self, force_n: &Vector3<f64>) -> Result<(), DeviceFault>;

    /// Whether the device reports a force other than the commanded one. Always false for a device
    /// without such a report.
    fn disagrees(&self) -> bool {
        false
    }

    /// Sends zero force and releases the device. Dropping the device does the same.
    fn close(&mut self);
}

/// The callback that a device with its own clock calls once a period. Input: the latest reading (if
/// there is no new one, the previous one, recognisable by its time) and the fault reported since
/// the last tick, if any. Output: the force on the handle, in N, device frame, or `None` to stop.
/// It runs in the driver's thread and must neither allocate nor wait.
pub type Tick<'a> = dyn FnMut(&Reading, Option<DeviceFault>) -> Option<Vector3<f64>> + Send + 'a;

/// A device with its own clock. A timer of ours would add one period of delay.
pub trait Clocked: Send {
    /// Identity and limits of the device.
    fn info(&self) -> &DeviceInfo;

    /// Calls `tick` once a period until it returns `None`, `stop` is set, or the device is lost;
    /// then sends zero force. If `tick` panics, the panic is resumed here after the force is zero
    /// and no further tick is made.
    ///
    /// # Errors
    /// If the device cannot start, or is lost.
    fn run(&mut self, tick: &mut Tick<'_>, stop: &AtomicBool) -> Result<(), DeviceFault>;
}
