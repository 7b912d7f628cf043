//! The loop of a headless attempt: a source of motion meets the tissue, every tick is recorded.

use std::io::Write;

use mechanics::operator::Motion;
use mechanics::puncture::PunctureParams;
use nalgebra::Vector3;

use crate::summary::{Ticker, nanoseconds};
use crate::tick::{Attempt, Input};
use crate::write::{WriteError, Writer};

/// Rate of the ledger, in Hz; it is also recorded at each rupture and at the end.
const LEDGER_HZ: u32 = 10;

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

/// What an attempt came to.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Simulated {
    /// Simulated time, in s.
    pub duration_s: f64,
    /// Ticks recorded.
    pub ticks: u64,
    /// Ruptures recorded.
    pub ruptures: u64,
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
    let mut attempt = Attempt::new(params);
    let mut ledgers = Ticker::new(LEDGER_HZ, 0);
    let mut force_n = Vector3::zeros();
    let mut simulated = Simulated { duration_s: 0.0, ticks: 0, ruptures: 0 };
    let mut done = false;
    let mut owed = false;
    while !done {
        let t_s = simulated.ticks as f64 / clock.tick_hz;
        // Written so that a limit that is no number ends the attempt.
        if !(t_s <= clock.time_limit_s) {
            break;
        }
        let dt_s = if simulated.ticks == 0 { 0.0 } else { 1.0 / clock.tick_hz };
        let motion = source.step(dt_s, &force_n);
        let tick = attempt.step(&Input::new(t_s, &motion));
        writer.sample(&tick.sample)?;
        let ruptures_before = simulated.ruptures;
        for event in &tick.events {
            writer.event(event)?;
            simulated.ruptures += u64::from(event.kind.contactor().is_some());
        }
        owed = !(ledgers.due(nanoseconds(t_s)) || simulated.ruptures > ruptures_before);
        if !owed {
            writer.energy(&attempt.energy(t_s))?;
        }
        force_n = tick.force_n;
        done = motion.done;
        simulated.duration_s = t_s;
        simulated.ticks += 1;
    }
    if owed {
        writer.energy(&attempt.energy(simulated.duration_s))?;
    }
    Ok(simulated)
}
