//! What the servo asks of any device.
//!
//! Frame of every device: x to the right, y up, z towards the person who holds it, origin at the middle of its workspace.

use std::sync::atomic::AtomicBool;

use nalgebra::{UnitQuaternion, Vector3};

use crate::clamp;

/// What a device is and can do.
#[derive(Clone, Debug, PartialEq)]
pub struct DeviceInfo {
    /// Name shown to people and kept in recordings, for example `Touch`.
    pub name: String,
    /// Serial number, if it has one.
    pub serial: Option<String>,
    /// Largest force, in N; 0 for a device without motors.
    pub max_force_n: f64,
    /// Force that it can hold for ever, rms, in N.
    pub continuous_force_n: f64,
    /// Stiffest wall that it can show, in N/m.
    pub max_stiffness_n_per_m: f64,
    /// Width, height and depth of its workspace, in m.
    pub workspace_m: [f64; 3],
    /// It measures how the handle is turned. Without that the needle points as planned.
    pub measures_orientation: bool,
    /// No motor stands behind it: a hand that a program moves, for mouse, gamepad and operators. Nothing can hurt, so neither
    /// gate nor watchdog keep force from it.
    pub is_virtual: bool,
}

impl DeviceInfo {
    /// The force nearest to `force_n`, in N, that the device can show: of the same direction, and zero if it is not finite.
    /// Every driver asks for this last, whatever the safety chain did before: a clamp of each axis would turn the force, and
    /// refusing what is too large would let go exactly when contact is hard.
    #[must_use]
    pub fn within_limits(&self, force_n: &Vector3<f64>) -> Vector3<f64> {
        clamp::norm(force_n, self.max_force_n).0
    }
}

/// What a device says at a moment.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Reading {
    /// When it was measured, in s of a clock that only goes forward. The same time twice is the same reading.
    pub t_s: f64,
    /// Position of the handle, in m, device frame.
    pub position_m: Vector3<f64>,
    /// Orientation of the handle, device_from_handle: +z of the handle points from its back to its tip.
    pub orientation: UnitQuaternion<f64>,
    /// Buttons held down, a bit each; see [`buttons`].
    pub buttons: u32,
    /// Temperature of the warmest motor as the device reports it, from 0 (cold) to 1 (too hot); 0 where it reports none.
    pub motor_heat: f64,
}

/// Bits of [`Reading::buttons`].
pub mod buttons {
    /// Confirms the position.
    pub const CONFIRM: u32 = 1;
    /// Lets the handle move without moving the needle.
    pub const CLUTCH: u32 = 2;
}

/// What can go wrong with a device while it is in use. Plain data: it is made in the servo thread, which never allocates.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum DeviceFault {
    /// It is no longer there.
    #[error("the device is gone")]
    Gone,
    /// It takes no force.
    #[error("the device refuses force (code {0})")]
    RefusesForce(u32),
    /// It answers with an error of its own.
    #[error("the device reports error {0}")]
    Reported(u32),
}

/// A device in use. Neither reading nor writing allocates, waits, locks or logs.
pub trait Device: Send {
    /// What it is and can do.
    fn info(&self) -> &DeviceInfo;

    /// The latest reading, new or not.
    ///
    /// # Errors
    /// When there is none to be had.
    fn read(&mut self) -> Result<Reading, DeviceFault>;

    /// Asks for a force on the handle, in N, device frame. A device without motors ignores it or draws it.
    ///
    /// # Errors
    /// When the device does not take it.
    fn write(&mut self, force_n: &Vector3<f64>) -> Result<(), DeviceFault>;

    /// The device says that it shows another force than it was sent. One that does not say is believed.
    fn disagrees(&self) -> bool {
        false
    }

    /// Sends zero force and lets go of the device. Also done when dropped.
    fn close(&mut self);
}

/// What a device that keeps its own time calls in each of its periods. The latest reading goes in (an old one, recognisable by
/// its time, if there is no new one) and what the device complained of since the last tick; the force on the handle comes out,
/// in N, device frame; `None` ends it. It runs in the driver's thread and must neither allocate nor wait.
pub type Tick<'a> = dyn FnMut(&Reading, Option<DeviceFault>) -> Option<Vector3<f64>> + Send + 'a;

/// A device that keeps its own time, where a timer of ours would add a period of delay.
pub trait Clocked: Send {
    /// What it is and can do.
    fn info(&self) -> &DeviceInfo;

    /// Ticks once a period until the tick answers `None`, or `stop` is set, or the device is lost; then sends zero force.
    /// A panic of the tick goes on here, once the force is zero and no further tick is made.
    ///
    /// # Errors
    /// When the device cannot start, or is lost.
    fn run(&mut self, tick: &mut Tick<'_>, stop: &AtomicBool) -> Result<(), DeviceFault>;
}
