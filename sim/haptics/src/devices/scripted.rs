//! A device with scripted faults whose forces can be watched, for tests of code that drives a
//! device.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};

use nalgebra::{UnitQuaternion, Vector3};

use super::hand;
use crate::device::{Device, DeviceFault, DeviceInfo, Reading};

/// A fault, from a given reading on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Fault {
    /// Nothing.
    None,
    /// Positions are not numbers.
    NotANumber,
    /// The same reading every time.
    Freeze,
    /// The position is offset by a length, in m.
    Jump(f64),
    /// Time runs backwards.
    Backwards,
    /// It rejects forces; its readings are valid.
    RefusesForce,
    /// It reports an error code of its own.
    Reports(u32),
    /// It is disconnected.
    Disconnect,
    /// The driver panics.
    Panic,
}

/// State of a scripted device, visible to other threads.
#[derive(Debug, Default)]
pub struct Watched {
    /// Bits of the three components of the last force.
    force: [AtomicU64; 3],
    writes: AtomicU64,
    closed: AtomicBool,
}

impl Watched {
    /// The last force that was written, in N, device frame.
    #[must_use]
    pub fn force_n(&self) -> Vector3<f64> {
        let part = |bits: &AtomicU64| f64::from_bits(bits.load(Ordering::Acquire));
        Vector3::new(part(&self.force[0]), part(&self.force[1]), part(&self.force[2]))
    }

    /// Number of forces written.
    #[must_use]
    pub fn writes(&self) -> u64 {
        self.writes.load(Ordering::Acquire)
    }

    /// Whether the device was closed.
    #[must_use]
    pub fn closed(&self) -> bool {
        self.closed.load(Ordering::Acquire)
    }

    fn note(&self, force_n: &Vector3<f64>) {
        self.force.iter().zip(force_n.iter()).for_each(|(bits, part)| bits.store(part.to_bits(), Ordering::Release));
        self.writes.fetch_add(1, Ordering::AcqRel);
    }
}

/// Moves down (device frame) at constant speed from the middle of its workspace, pointing down,
/// until its fault begins.
#[derive(Debug)]
pub struct Scripted {
    info: DeviceInfo,
    speed_m_per_s: f64,
    fault: Fault,
    /// The faulty readings: the first one, and their number.
    begins: u64,
    lasts: u64,
    period_s: f64,
    readings: u64,
    watched: Arc<Watched>,
}

impl Scripted {
    /// A device without faults that moves at a speed in m/s, ticked at a rate in Hz.
    #[must_use]
    pub fn new(speed_m_per_s: f64, rate_hz: f64) -> Self {
        Self {
            info: hand::info("scripted"),
            speed_m_per_s,
            fault: Fault::None,
            begins: 0,
            lasts: 0,
            period_s: 1.0 / rate_hz,
            readings: 0,
            watched: Arc::default(),
        }
    }

    /// The same device with a fault that begins at reading `begins` (from 0) and lasts for `lasts`
    /// readings.
    #[must_use]
    pub fn with(self, fault: Fault, begins: u64, lasts: u64) -> Self {
        Self { fault, begins, lasts, ..self }
    }

    /// The same device with the identity and limits of a real one.
    #[must_use]
    pub fn as_device(self, info: DeviceInfo) -> Self {
        Self { info, ..self }
    }

    /// The state that other threads can watch.
    #[must_use]
    pub fn watched(&self) -> Arc<Watched> {
        Arc::clone(&self.watched)
    }

    /// A valid reading.
    fn reading(&self, number: u64) -> Reading {
        let t_s = number as f64 * self.period_s;
        // Turns the handle's z from z to −y, downwards.
        let orientation = UnitQuaternion::from_axis_angle(&Vector3::x_axis(), core::f64::consts::FRAC_PI_2);
        Reading {
            t_s,
            position_m: Vector3::new(0.0, -self.speed_m_per_s * t_s, 0.0),
            orientation,
            buttons: 0,
            motor_heat: 0.0,
        }
    }

    /// The fault at a reading.
    fn fault_at(&self, number: u64) -> Fault {
        let faulty = number.checked_sub(self.begins).is_some_and(|since| since < self.lasts);
        if faulty { self.fault } else { Fault::None }
    }
}

impl Device for Scripted {
    fn info(&self) -> &DeviceInfo {
        &self.info
    }

    #[expect(clippy::panic, reason = "it stands in for a driver with a defect")]
    fn read(&mut self) -> Result<Reading, DeviceFault> {
        let number = self.readings;
        self.readings += 1;
        let good = self.reading(number);
        match self.fault_at(number) {
            Fault::None | Fault::RefusesForce => Ok(good),
            Fault::NotANumber => Ok(Reading { position_m: Vector3::repeat(f64::NAN), ..good }),
            Fault::Freeze => Ok(self.reading(self.begins)),
            Fault::Jump(way_m) => Ok(Reading { position_m: good.position_m + Vector3::x() * way_m, ..good }),
            Fault::Backwards => Ok(Reading { t_s: 2.0 * self.begins as f64 * self.period_s - good.t_s, ..good }),
            Fault::Reports(code) => Err(DeviceFault::Reported(code)),
            Fault::Disconnect => Err(DeviceFault::Gone),
            Fault::Panic => panic!("a driver with a defect"),
        }
    }

    fn write(&mut self, force_n: &Vector3<f64>) -> Result<(), DeviceFault> {
        match self.fault_at(self.readings.saturating_sub(1)) {
            Fault::RefusesForce => Err(DeviceFault::RefusesForce(1)),
            _ => {
                self.watched.note(force_n);
                Ok(())
            }
        }
    }

    fn close(&mut self) {
        self.watched.note(&Vector3::zeros());
        self.watched.closed.store(true, Ordering::Release);
    }
}
