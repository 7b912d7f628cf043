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
    let mut run = Run {
        attempt: Attempt::new(params),
        writer,
        ledgers: Ticker::new(LEDGER_HZ, 0),
        owed: false,
        simulated: Simulated { duration_s: 0.0, ticks: 0, ruptures: 0 },
    };
    let mut force_n = Vector3::zeros();
    loop {
        let t_s = run.simulated.ticks as f64 / clock.tick_hz;
        if t_s > clock.time_limit_s || clock.time_limit_s.is_nan() {
            break;
        }
        let dt_s = if run.simulated.ticks == 0 { 0.0 } else { 1.0 / clock.tick_hz };
        let motion = source.step(dt_s, &force_n);
        force_n = run.tick(&Input::new(t_s, &motion))?;
        if motion.done {
            break;
        }
    }
    run.ledger()?;
    Ok(run.simulated)
}

/// An attempt on its way into a recording.
struct Run<'a, W: Write> {
    attempt: Attempt<'a>,
    writer: &'a mut Writer<W>,
    ledgers: Ticker,
    /// The last tick's ledger has not been written.
    owed: bool,
    /// What it has come to so far.
    simulated: Simulated,
}

impl<W: Write> Run<'_, W> {
    /// Simulates and records a tick; returns the force on the hand, in N.
    fn tick(&mut self, input: &Input) -> Result<Vector3<f64>, WriteError> {
        let tick = self.attempt.step(input);
        self.writer.sample(&tick.sample)?;
        for event in &tick.events {
            self.writer.event(event)?;
        }
        if let Some(tent) = &tick.tent {
            self.writer.tent(tent)?;
        }
        let ruptures = tick.events.iter().filter(|event| event.kind.contactor().is_some()).count() as u64;
        self.simulated.duration_s = input.t_s;
        self.simulated.ticks += 1;
        self.simulated.ruptures += ruptures;
        self.owed = true;
        if self.ledgers.due(nanoseconds(input.t_s)) || ruptures > 0 {
            self.ledger()?;
        }
        Ok(tick.force_n)
    }

    /// Writes the ledger, if it is owed.
    fn ledger(&mut self) -> Result<(), WriteError> {
        if std::mem::take(&mut self.owed) {
            self.writer.energy(&self.attempt.energy(self.simulated.duration_s))?;
        }
        Ok(())
    }
}
