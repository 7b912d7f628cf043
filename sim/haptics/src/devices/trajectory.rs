//! A recorded motion as a device: it plays one reading per call and then holds still. It ignores
//! forces.
//!
//! It uses the patient frame: combine it with [`crate::mapping::Mapping::in_patient_frame`].

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use nalgebra::Vector3;

use super::hand;
use crate::device::{Device, DeviceFault, DeviceInfo, Reading};

/// A motion to play.
#[derive(Debug)]
pub struct Trajectory {
    info: DeviceInfo,
    readings: Vec<Reading>,
    next: usize,
    period_s: f64,
    done: Arc<AtomicBool>,
}

impl Trajectory {
    /// Plays readings as if one period of `rate_hz`, in Hz, apart; their own times are ignored.
    #[must_use]
    pub fn new(name: &str, readings: Vec<Reading>, rate_hz: f64) -> Self {
        let done = Arc::new(AtomicBool::new(readings.is_empty()));
        Self { info: hand::info(name), readings, next: 0, period_s: 1.0 / rate_hz, done }
    }

    /// Becomes true when the last reading has been played.
    #[must_use]
    pub fn done(&self) -> Arc<AtomicBool> {
        Arc::clone(&self.done)
    }
}

impl Device for Trajectory {
    fn info(&self) -> &DeviceInfo {
        &self.info
    }

    fn read(&mut self) -> Result<Reading, DeviceFault> {
        let t_s = self.next as f64 * self.period_s;
        let last = self.readings.len().saturating_sub(1);
        let reading = self.readings.get(self.next.min(last)).ok_or(DeviceFault::Gone)?;
        self.done.store(self.next >= last, Ordering::Relaxed);
        self.next += 1;
        Ok(Reading { t_s, ..*reading })
    }

    fn write(&mut self, _force_n: &Vector3<f64>) -> Result<(), DeviceFault> {
        Ok(())
    }

    fn close(&mut self) {}
}
