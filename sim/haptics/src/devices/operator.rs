//! A virtual operator as a device: it holds the handle and feels the servo's force. It receives
//! only the force, so it does not redirect off bone.
//!
//! It uses the patient frame: combine it with [`crate::mapping::Mapping::in_patient_frame`].

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use law::operator::{Felt, Operator};
use nalgebra::Vector3;

use super::hand;
use crate::device::{Device, DeviceFault, DeviceInfo, Reading, buttons};

/// The operator with a handle. Each reading advances its time by one period.
#[derive(Debug)]
pub struct OperatorDevice {
    info: DeviceInfo,
    operator: Operator,
    force_n: Vector3<f64>,
    period_s: f64,
    readings: u64,
    done: Arc<AtomicBool>,
}

impl OperatorDevice {
    /// An operator ticked at `rate_hz`, in Hz. `name` is stored in recordings, for example
    /// `operator:novice`.
    #[must_use]
    pub fn new(name: &str, operator: Operator, rate_hz: f64) -> Self {
        let done = Arc::new(AtomicBool::new(false));
        Self { info: hand::info(name), operator, force_n: Vector3::zeros(), period_s: 1.0 / rate_hz, readings: 0, done }
    }

    /// Becomes true when the operator has finished; it then holds still.
    #[must_use]
    pub fn done(&self) -> Arc<AtomicBool> {
        Arc::clone(&self.done)
    }
}

impl Device for OperatorDevice {
    fn info(&self) -> &DeviceInfo {
        &self.info
    }

    fn read(&mut self) -> Result<Reading, DeviceFault> {
        // A finished operator is stepped by zero time: it repeats its last motion.
        let dt_s = if self.done.load(Ordering::Relaxed) { 0.0 } else { self.period_s };
        let motion = self.operator.step(dt_s, &Felt::from(self.force_n));
        self.done.store(motion.done, Ordering::Relaxed);
        let t_s = self.readings as f64 * self.period_s;
        self.readings += 1;
        let pose = motion.patient_from_needle;
        let buttons = if motion.confirm { buttons::CONFIRM } else { 0 };
        Ok(Reading { t_s, position_m: pose.translation.vector, orientation: pose.rotation, buttons, motor_heat: 0.0 })
    }

    fn write(&mut self, force_n: &Vector3<f64>) -> Result<(), DeviceFault> {
        self.force_n = *force_n;
        Ok(())
    }

    fn close(&mut self) {
        self.force_n = Vector3::zeros();
    }
}
