//! Records an attempt, tick by tick: shared by the simulation and the servo's recorder.

use std::io::Write;

use recording::error::WriteError;
use recording::rate::{Ticker, nanoseconds};
use recording::sample::Energy;
use recording::write::Writer;
use recording::{CArmControls, Event, EventKind, FluoroscopyPulse};
use tissue::Specimen;

use crate::fluoroscopy::Fluoroscope;
use crate::tick::{Tick, TickInput, TickedAttempt};

/// Rate of the ledger, in Hz; it is also recorded at each rupture and at the end.
const LEDGER_HZ: u32 = 10;

/// Summary of an attempt.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Simulated {
    /// Simulated time, in s.
    pub duration_s: f64,
    /// Ticks recorded.
    pub ticks: u64,
    /// Ruptures recorded.
    pub ruptures: u64,
}

/// Data of a tick that come from the servo, not from the force law.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sent {
    /// Force sent to the device after scaling and safety chain, in N, patient frame.
    pub device_n: [f32; 3],
    /// The servo's own flags, in addition to [`recording::sample::flags`].
    pub flags: u32,
    /// Lateness of the tick, in µs.
    pub lateness_us: f32,
}

/// Steps the ticks of an attempt, and returns the data to record of each.
pub(crate) struct RecordedAttempt<'a> {
    attempt: TickedAttempt<'a>,
    ledgers: Ticker,
    /// Whether the last tick's ledger is still to be recorded.
    owed: bool,
    so_far: Simulated,
}

/// The data to record of a tick.
pub(crate) struct RecordedTick {
    pub tick: Tick,
    /// The ledger, if one is due.
    energy: Option<Energy>,
}

impl RecordedTick {
    pub fn write<W: Write>(&self, writer: &mut Writer<W>) -> Result<(), WriteError> {
        writer.sample(&self.tick.sample)?;
        for event in &self.tick.events {
            writer.event(event)?;
        }
        if let Some(tent) = &self.tick.tent {
            writer.tent(tent)?;
        }
        self.energy.iter().try_for_each(|energy| writer.energy(energy))
    }
}

impl<'a> RecordedAttempt<'a> {
    pub fn new(specimen: &'a Specimen) -> Self {
        let so_far = Simulated { duration_s: 0.0, ticks: 0, ruptures: 0 };
        Self { attempt: TickedAttempt::new(specimen), ledgers: Ticker::new(LEDGER_HZ, 0), owed: false, so_far }
    }

    pub fn so_far(&self) -> Simulated {
        self.so_far
    }

    /// Steps the law. Without a servo the device takes the whole force.
    pub fn tick(&mut self, input: &TickInput, sent: Option<&Sent>) -> RecordedTick {
        let mut tick = self.attempt.step(input);
        if let Some(&Sent { device_n, flags, lateness_us }) = sent {
            tick.sample.device_n = device_n;
            tick.sample.flags |= flags;
            tick.sample.lateness_us = lateness_us;
        }
        let ruptures = tick.events.iter().filter(|event| event.kind.contactor().is_some()).count() as u64;
        self.so_far.duration_s = input.t_s;
        self.so_far.ticks += 1;
        self.so_far.ruptures += ruptures;
        self.owed = true;
        let is_due = self.ledgers.due(nanoseconds(tick.sample.t_s)) || ruptures > 0;
        let energy = if is_due { self.take_energy() } else { None };
        RecordedTick { tick, energy }
    }

    /// Takes the ledger after the last tick, unless it has been recorded.
    pub fn take_energy(&mut self) -> Option<Energy> {
        std::mem::take(&mut self.owed).then(|| self.attempt.energy(self.so_far.duration_s))
    }
}

/// A C-arm whose use is being recorded.
#[derive(Clone, Debug)]
pub struct RecordedArm {
    fluoroscope: Fluoroscope,
    recorded: Option<CArmControls>,
}

/// The data to record of a C-arm in a tick.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct CArmUse {
    /// The controls, if they have changed.
    pub controls: Option<CArmControls>,
    /// The pulse, if there is one.
    pub pulse: Option<FluoroscopyPulse>,
}

impl RecordedArm {
    /// A C-arm before its first pulse.
    #[must_use]
    pub fn new(fluoroscope: Fluoroscope) -> Self {
        Self { fluoroscope, recorded: None }
    }

    /// Steps the C-arm at a tick, whose time is that of the controls.
    pub fn step(&mut self, controls: &CArmControls) -> CArmUse {
        let is_new = self.recorded.is_none_or(|recorded| controls.differ(&recorded));
        if is_new {
            self.recorded = Some(*controls);
        }
        CArmUse { controls: is_new.then_some(*controls), pulse: self.fluoroscope.step(controls) }
    }
}

impl CArmUse {
    fn write<W: Write>(&self, writer: &mut Writer<W>) -> Result<(), WriteError> {
        self.controls.iter().try_for_each(|controls| writer.controls(controls))?;
        self.pulse.iter().try_for_each(|pulse| writer.pulse(pulse))
    }
}

/// An attempt that is being recorded.
pub struct Run<'a, W: Write> {
    attempt: RecordedAttempt<'a>,
    writer: &'a mut Writer<W>,
    /// The C-arm, if the exercise has one.
    arm: Option<RecordedArm>,
    /// Result of writing. After the first error nothing more is written, and the attempt continues
    /// without a recording.
    written: Result<(), WriteError>,
}

impl<'a, W: Write> Run<'a, W> {
    /// Starts before the first tick.
    pub fn new(specimen: &'a Specimen, writer: &'a mut Writer<W>) -> Self {
        Self { attempt: RecordedAttempt::new(specimen), writer, arm: None, written: Ok(()) }
    }

    /// Adds a C-arm with its controls at the start.
    #[must_use]
    pub fn with_arm(self, arm: Option<RecordedArm>) -> Self {
        Self { arm, ..self }
    }

    /// Operates the C-arm at the last tick. Returns the pulse in it.
    pub fn operate(&mut self, controls: &CArmControls) -> Option<FluoroscopyPulse> {
        let t_s = self.so_far().duration_s;
        let arm = self.arm.as_mut()?;
        let used = arm.step(&CArmControls { t_s, ..*controls });
        if self.written.is_ok() {
            self.written = used.write(self.writer);
        }
        used.pulse
    }

    /// Returns the summary so far.
    #[must_use]
    pub fn so_far(&self) -> Simulated {
        self.attempt.so_far()
    }

    /// Returns the error after which nothing more was written, if there is one.
    #[must_use]
    pub fn refused(&self) -> Option<&WriteError> {
        self.written.as_ref().err()
    }

    /// Steps the law and records the tick. Without a servo the device takes the whole force.
    pub fn tick(&mut self, input: &TickInput, sent: Option<&Sent>) -> Tick {
        let recorded = self.attempt.tick(input, sent);
        if self.written.is_ok() {
            self.written = recorded.write(self.writer);
        }
        recorded.tick
    }

    /// Records an event from outside the force law, such as a coaching message or a fault, at the
    /// last tick.
    pub fn note(&mut self, kind: EventKind, tick: &Tick, text: &str) {
        let Tick { sample, .. } = tick;
        let event = Event {
            t_s: sample.t_s,
            kind,
            boundary: None,
            x_m: sample.x_m,
            position_m: sample.position_m,
            force_n: sample.axial_n(),
            dissipated_j: 0.0,
            track: None,
            structure: None,
            text: text.to_owned(),
        };
        if self.written.is_ok() {
            self.written = self.writer.event(&event);
        }
    }

    /// Finishes with the last ledger.
    ///
    /// # Errors
    /// If writing has failed.
    pub fn finish(mut self) -> Result<Simulated, WriteError> {
        self.written?;
        self.attempt.take_energy().iter().try_for_each(|energy| self.writer.energy(energy))?;
        Ok(self.attempt.so_far())
    }
}
