//! The loop of a headless attempt: a source of motion moves the needle in the tissue, and every
//! tick is recorded, in a file or in memory.

use std::io::Write;
use std::panic::resume_unwind;
use std::sync::mpsc::sync_channel;
use std::thread;

use law::operator::{Felt, Motion};
use recording::error::WriteError;
use recording::write::Writer;
use recording::{Recording, Session};
use tissue::Specimen;

pub use crate::run::Simulated;
use crate::run::{RecordedAttempt, RecordedTick};
use crate::tick::{TickInput, TickedAttempt};

/// A source of motion of the needle.
pub trait MotionSource {
    /// Returns the motion after `dt_s`, given the forces that the hand felt last. A first call with
    /// `dt_s` = 0 returns the initial pose.
    fn step(&mut self, dt_s: f64, felt: &Felt) -> Motion;
}

impl MotionSource for law::operator::Operator {
    fn step(&mut self, dt_s: f64, felt: &Felt) -> Motion {
        Self::step(self, dt_s, felt)
    }
}

/// Number of ticks per batch for the writer, and of batches that may wait.
const BATCH: usize = 256;
const WAITING: usize = 4;

/// Rate and maximum duration of an attempt.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Clock {
    /// Servo rate, in Hz.
    pub tick_hz: f64,
    /// Maximum simulated time, in s.
    pub time_limit_s: f64,
}

impl Clock {
    fn runs(&self) -> bool {
        self.tick_hz > 0.0 && self.tick_hz.is_finite()
    }

    /// Steps the source, tick by tick, until it is done, the time is up, or `tick` returns `None`.
    fn drive(&self, source: &mut dyn MotionSource, mut tick: impl FnMut(&TickInput) -> Option<Felt>) {
        let mut felt = Felt::default();
        for i in 0_u64.. {
            let t_s = i as f64 / self.tick_hz;
            if t_s > self.time_limit_s || self.time_limit_s.is_nan() {
                break;
            }
            let motion = source.step(if i == 0 { 0.0 } else { 1.0 / self.tick_hz }, &felt);
            match tick(&TickInput::new(t_s, &motion)) {
                Some(now) if !motion.done => felt = now,
                _ => break,
            }
        }
    }
}

/// Simulates at `tick_hz` until the source is done or `time_limit_s` has passed. The first sample
/// is the start, at 0 s. A second thread packs and writes the data, which takes as long as the
/// simulation.
///
/// # Errors
/// If the clock has no rate, or writing fails.
pub fn simulate<W: Write + Send>(
    specimen: &Specimen,
    source: &mut dyn MotionSource,
    writer: &mut Writer<W>,
    clock: &Clock,
) -> Result<Simulated, WriteError> {
    if !clock.runs() {
        return Err(WriteError::invalid("tick_hz", clock.tick_hz, "allowed: a finite rate above 0 Hz"));
    }
    let mut attempt = RecordedAttempt::new(specimen);
    thread::scope(|scope| {
        let (ticks, waiting) = sync_channel::<Vec<RecordedTick>>(WAITING);
        let writer = &mut *writer;
        let writing = scope.spawn(move || waiting.iter().flatten().try_for_each(|tick| tick.write(writer)));
        let mut batch = Vec::with_capacity(BATCH);
        clock.drive(source, |input| {
            let recorded = attempt.tick(input, None);
            let felt = recorded.tick.felt;
            batch.push(recorded);
            let is_taken =
                batch.len() < BATCH || ticks.send(std::mem::replace(&mut batch, Vec::with_capacity(BATCH))).is_ok();
            is_taken.then_some(felt)
        });
        // Fails if writing has failed; the join below returns that error.
        let _ = ticks.send(batch);
        drop(ticks);
        writing.join().unwrap_or_else(|panic| resume_unwind(panic))
    })?;
    attempt.take_energy().iter().try_for_each(|energy| writer.energy(energy))?;
    Ok(attempt.so_far())
}

/// Simulates in memory, at the session's rate: samples, events, tents and the last ledger. Without
/// a finite rate above 0 Hz the recording stays empty.
#[must_use]
pub fn rehearse(specimen: &Specimen, source: &mut dyn MotionSource, session: Session, time_limit_s: f64) -> Recording {
    let clock = Clock { tick_hz: session.tick_hz, time_limit_s };
    let mut recording = Recording::in_memory(session);
    let mut attempt = TickedAttempt::new(specimen);
    if clock.runs() {
        clock.drive(source, |input| {
            let tick = attempt.step(input);
            recording.samples.push(tick.sample);
            recording.events.extend(tick.events);
            recording.tents.extend(tick.tent);
            Some(tick.felt)
        });
    }
    let last = recording.samples.last().map(|sample| attempt.energy(sample.t_s));
    recording.energies.extend(last);
    recording
}
