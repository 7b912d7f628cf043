//! The loop of a headless attempt: a source of motion meets the tissue, every tick is recorded.

use std::io::Write;

use mechanics::operator::Motion;
use mechanics::puncture::PunctureParams;
use nalgebra::Vector3;

use crate::write::{WriteError, Writer};

/// Anything that moves the needle.
pub trait MotionSource {
    /// The motion after `dt_s`, under the last force on the hand, in N, patient frame.
    fn step(&mut self, dt_s: f64, force_n: &Vector3<f64>) -> Motion;
}

impl MotionSource for mechanics::operator::Operator {
    fn step(&mut self, dt_s: f64, force_n: &Vector3<f64>) -> Motion {
        Self::step(self, dt_s, force_n)
    }
}

/// What an attempt came to.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Simulated {
    /// Simulated time, in s.
    pub duration_s: f64,
    /// Ticks recorded.
    pub ticks: u64,
}

/// Runs until the source is done or `time_limit_s` has passed, at `tick_hz`.
///
/// # Errors
/// When the disk refuses.
pub fn simulate<W: Write>(
    _params: &PunctureParams,
    _source: &mut dyn MotionSource,
    _writer: &mut Writer<W>,
    _clock: &Clock,
) -> Result<Simulated, WriteError> {
    unimplemented!()
}

/// Rate and length of an attempt.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Clock {
    /// Servo rate, in Hz.
    pub tick_hz: f64,
    /// Longest simulated time, in s.
    pub time_limit_s: f64,
}
