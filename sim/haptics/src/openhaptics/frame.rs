//! One frame of the device: the driver's work a thousand times a second, in the thread of the
//! vendor's scheduler. Nothing here allocates, waits, locks or logs, and no panic of the tick
//! escapes.

use std::any::Any;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};

use nalgebra::{Matrix3, Rotation3, UnitQuaternion, Vector3};

use super::error::{describe_fault, graver};
use super::ffi::{Handle, Hd, name};
use crate::clock;
use crate::device::{DeviceFault, DeviceInfo, Reading, Tick};

/// State of the frames, visible to the waiting thread.
#[derive(Default)]
pub struct Watch {
    /// Frames made so far.
    pub frames: AtomicU64,
    /// The last frame has been made; the force is zero.
    pub ended: AtomicBool,
}

/// The data of a frame, prepared before the first.
pub struct DeviceFrame<'a, 'tick> {
    pub hd: &'a Hd,
    pub device: Handle,
    pub info: &'a DeviceInfo,
    /// Middle of the workspace, in m, in the driver's coordinates.
    pub middle_m: Vector3<f64>,
    pub tick: &'a mut Tick<'tick>,
    pub stop: &'a AtomicBool,
    pub watch: &'a Watch,
    /// The device reports the temperature of its motors.
    pub reports_heat: bool,
    /// The last good reading.
    pub reading: Reading,
    /// The fault reported in the last frame.
    pub fault: Option<DeviceFault>,
    /// The payload of a panic of the tick, to resume where unwinding is allowed.
    pub panic: Option<Box<dyn Any + Send>>,
}

impl DeviceFrame<'_, '_> {
    /// Makes a frame; returns false if it was the last.
    pub fn make(&mut self) -> bool {
        self.hd.begin_frame(self.device);
        if let Some(reading) = self.read() {
            self.reading = reading;
        }
        let force_n = if self.stop.load(Ordering::Relaxed) { None } else { self.ask() };
        let shown_n = force_n.map_or_else(Vector3::zeros, |force_n| self.info.within_limits(&force_n));
        self.hd.set_force(shown_n.as_ref());
        self.hd.end_frame(self.device);
        self.fault = self.hd.errors().map(describe_fault).reduce(graver);
        let goes_on = force_n.is_some() && self.fault != Some(DeviceFault::Gone);
        self.watch.frames.fetch_add(1, Ordering::Relaxed);
        // Stored last with release ordering: a thread that sees the end may release the device.
        self.watch.ended.store(!goes_on, Ordering::Release);
        goes_on
    }

    /// Runs the tick and returns its force, in N; `None` if it ends or panics.
    fn ask(&mut self) -> Option<Vector3<f64>> {
        let (tick, reading, fault) = (&mut *self.tick, &self.reading, self.fault);
        // Unwind safe: after a panic neither the tick nor its captures are used again.
        let asked = catch_unwind(AssertUnwindSafe(|| tick(reading, fault)));
        asked.unwrap_or_else(|panic| {
            self.panic = Some(panic);
            None
        })
    }

    /// Reads the handle; `None` if the driver returns numbers that are not finite.
    fn read(&self) -> Option<Reading> {
        let transform = self.hd.doubles(name::CURRENT_TRANSFORM);
        let (position_m, orientation) = pose(&transform)?;
        let buttons = self.hd.integer(name::CURRENT_BUTTONS);
        let motor_heat = if self.reports_heat { read_motor_heat(self.hd) } else { 0.0 };
        Some(Reading { t_s: clock::now_s(), position_m: position_m - self.middle_m, orientation, buttons, motor_heat })
    }
}

/// Temperature of the warmest motor, from 0 (cold) to 1 (too hot); 0 where the driver gives no number.
pub fn read_motor_heat(hd: &Hd) -> f64 {
    let heats: [f64; 3] = hd.doubles(name::MOTOR_TEMPERATURE);
    heats.into_iter().filter(|heat| heat.is_finite()).fold(0.0, f64::max)
}

/// Position in m and orientation of the handle, from a transform in mm with its columns one after the other.
///
/// The driver's stylus points along its own −z; ours points along +z, half a turn about y away.
fn pose(transform: &[f64; 16]) -> Option<(Vector3<f64>, UnitQuaternion<f64>)> {
    if !transform.iter().all(|part| part.is_finite()) {
        return None;
    }
    let column = |at: usize| Vector3::new(transform[at], transform[at + 1], transform[at + 2]);
    let axes = Rotation3::from_matrix_unchecked(Matrix3::from_columns(&[-column(0), column(4), -column(8)]));
    Some((column(12) * 1e-3, UnitQuaternion::from_rotation_matrix(&axes)))
}
