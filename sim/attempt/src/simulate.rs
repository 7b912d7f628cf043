//! The loop of a headless attempt: a source of motion meets the tissue, and every tick is recorded, in a file or in memory.

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

/// Anything that moves the needle.
pub trait MotionSource {
    /// The motion after `dt_s`, under what the hand has felt last. A first call with `dt_s` = 0 asks for the pose to start from.
    fn step(&mut self, dt_s: f64, felt: &Felt) -> Motion;
}

impl MotionSource for law::operator::Operator {
    fn step(&mut self, dt_s: f64, felt: &Felt) -> Motion {
        Self::step(self, dt_s, felt)
    }
}

/// Ticks are handed over in batches of so many, of which so many may wait to be written.
const BATCH: usize = 256;
const WAITING: usize = 4;

/// Rate and length of an attempt.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Clock {
    /// Servo rate, in Hz.
    pub tick_hz: f64,
    /// Longest simulated time, in s.
    pub time_limit_s: f64,
}

impl Clock {
    fn runs(&self) -> bool {
        self.tick_hz > 0.0 && self.tick_hz.is_finite()
    }

    /// Asks the source for its motion, tick by tick, until it is done, the time is up or a tick answers nothing that was felt.
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

/// Runs until the source is done or `time_limit_s` has passed, at `tick_hz`. The first sample is the start, at 0 s. What is recorded is
/// packed and written on a thread of its own, which takes as long as the simulation.
///
/// # Errors
/// When the clock has no rate, or the disk refuses.
pub fn simulate<W: Write + Send>(
    specimen: &Specimen,
    source: &mut dyn MotionSource,
    writer: &mut Writer<W>,
    clock: &Clock,
) -> Result<Simulated, WriteError> {
    if !clock.runs() {
        return Err(WriteError::invalid("tick_hz", clock.tick_hz, "a finite rate above 0 Hz is allowed"));
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
        // Fails where the disk has refused; the join below returns that error.
        let _ = ticks.send(batch);
        drop(ticks);
        writing.join().unwrap_or_else(|panic| resume_unwind(panic))
    })?;
    attempt.take_energy().iter().try_for_each(|energy| writer.energy(energy))?;
    Ok(attempt.so_far())
}

/// The same in memory, at the session's rate: samples, events and the last ledger. Without a rate above 0 Hz nothing happens.
#[must_use]
pub fn rehearse(specimen: &Specimen, source: &mut dyn MotionSource, session: Session, time_limit_s: f64) -> Recording {
    let clock = Clock { tick_hz: session.tick_hz, time_limit_s };
    let (attachments, samples, events) = (Vec::new(), Vec::new(), Vec::new());
    let (energies, tents) = (Vec::new(), Vec::new());
    let mut recording =
        Recording { session, attachments, samples, events, energies, tents, signature: None, complete: true };
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
