//! The loop of a headless attempt: a source of motion meets the tissue, every tick is recorded.

use std::io::Write;

use mechanics::operator::Motion;
use mechanics::puncture::PunctureParams;
use nalgebra::Vector3;

use crate::run::Run;
pub use crate::run::Simulated;
use crate::tick::Input;
use crate::write::{WriteError, Writer};

/// Anything that moves the needle.
pub trait MotionSource {
    /// The motion after `dt_s`, under the last force on the hand, in N, patient frame. A first call with `dt_s` = 0
    /// asks for the pose to start from.
    fn step(&mut self, dt_s: f64, force_n: &Vector3<f64>) -> Motion;
}

impl MotionSource for mechanics::operator::Operator {
    fn step(&mut self, dt_s: f64, force_n: &Vector3<f64>) -> Motion {
        Self::step(self, dt_s, force_n)
    }
}

/// Rate and length of an attempt.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Clock {
    /// Servo rate, in Hz.
    pub tick_hz: f64,
    /// Longest simulated time, in s.
    pub time_limit_s: f64,
}

/// Runs until the source is done or `time_limit_s` has passed, at `tick_hz`. The first sample is the start, at 0 s.
///
/// # Errors
/// When the clock has no rate, or the disk refuses.
pub fn simulate<W: Write>(
    params: &PunctureParams,
    source: &mut dyn MotionSource,
    writer: &mut Writer<W>,
    clock: &Clock,
) -> Result<Simulated, WriteError> {
    if !(clock.tick_hz > 0.0 && clock.tick_hz.is_finite()) {
        return Err(WriteError::invalid("tick_hz", clock.tick_hz, "a finite rate above 0 Hz is allowed"));
    }
    let mut run = Run::new(params, writer);
    let mut force_n = Vector3::zeros();
    loop {
        let t_s = run.so_far().ticks as f64 / clock.tick_hz;
        if t_s > clock.time_limit_s || clock.time_limit_s.is_nan() {
            break;
        }
        let dt_s = if run.so_far().ticks == 0 { 0.0 } else { 1.0 / clock.tick_hz };
        let motion = source.step(dt_s, &force_n);
        force_n = run.tick(&Input::new(t_s, &motion), None).force_n;
        if motion.done || run.refused().is_some() {
            break;
        }
    }
    run.finish()
}
