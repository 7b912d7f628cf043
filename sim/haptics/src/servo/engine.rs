//! The servo's tick with time as an argument: the thread runs it in real time, tests run it faster.

use std::sync::Arc;

use law::puncture::{
    PunctureEvent, PunctureInput, PunctureOutput, PunctureParams, PunctureScratch, PunctureState, step, write_loads,
};
use nalgebra::Vector3;

use super::grid::TickGrid;
use super::latest::{self, LatestReader, Publisher, Snapshot};
use super::record::{self, Record, Records, Sender};
use super::timing::{Quantiles, Times};
use super::{Ended, Setup, StartError, flags};
use crate::device::{DeviceFault, Reading, buttons};
use crate::mapping::{Mapping, NeedlePose};
use crate::safety::{self, Believed};
use crate::scaling::Scaling;

/// A device that has only reported errors for this long, in s, counts as lost.
const LOST_AFTER_S: f64 = 2.0;
/// Ticks between two updates of the overlay's quantiles: each one walks a histogram.
const QUANTILES_EVERY: u64 = 50;

/// Time of a tick.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct TickMoment {
    /// Time on the servo's clock, in s.
    pub now_s: f64,
    /// Lateness of the tick, in s.
    pub late_s: f64,
}

/// The state that ticks change.
pub struct Engine {
    params: Arc<PunctureParams>,
    scaling: Scaling,
    safety: safety::SafetyParams,
    mapping: Mapping,
    state: PunctureState,
    scratch: PunctureScratch,
    chain: safety::SafetyState,
    grid: TickGrid,
    /// Whether the tip was in the body at the last tick.
    inside: bool,
    /// Result of writing the last force.
    wrote: Result<(), DeviceFault>,
    /// Whether the device reports a force other than the commanded one.
    disagrees: bool,
    /// Start of the current run of device errors, in s.
    failing_since_s: Option<f64>,
    /// Why the servo ended, once it has.
    ended: Option<Ended>,
    records: Sender,
    latest: Publisher,
    counts: Counts,
    /// Lateness and compute time of the ticks.
    lateness: Times,
    compute: Times,
    shown: (Quantiles, Quantiles),
}

/// Event counts since the start.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Counts {
    /// Ticks made.
    pub ticks: u64,
    /// Ticks that began more than a period late.
    pub stalls: u64,
    /// Boundaries that ruptured.
    pub ruptures: u64,
    /// Records dropped because the recorder was too slow.
    pub dropped: u64,
}

impl Engine {
    /// Returns an engine, the records for the recorder and a reader of the latest tick.
    ///
    /// # Errors
    /// If `rate_hz` is not positive and finite, or a histogram cannot be created.
    pub fn new(setup: Setup) -> Result<(Self, Records, LatestReader), StartError> {
        let Setup { params, mapping, scaling, safety, rate_hz } = setup;
        let (sender, records) = record::ring();
        let (publisher, reader) = latest::cell(2 * params.spec().axial.layers.len());
        let engine = Self {
            state: PunctureState::new(&params),
            scratch: PunctureScratch::new(&params),
            chain: safety::SafetyState::default(),
            grid: TickGrid::new(rate_hz)?,
            inside: false,
            wrote: Ok(()),
            disagrees: false,
            failing_since_s: None,
            ended: None,
            records: sender,
            latest: publisher,
            counts: Counts::default(),
            lateness: Times::new()?,
            compute: Times::new()?,
            shown: Default::default(),
            params,
            scaling,
            safety,
            mapping,
        };
        Ok((engine, records, reader))
    }

    /// The times at which ticks are due.
    pub(super) fn grid(&self) -> &TickGrid {
        &self.grid
    }

    /// Makes one tick: takes a reading, or the fault that prevented it, and returns the force for
    /// the device, in N, device frame; `None` if the device is lost. `clock` returns the time in s
    /// while the tick is computed.
    pub fn tick(
        &mut self,
        reading: Result<Reading, DeviceFault>,
        moment: &TickMoment,
        clock: &dyn Fn() -> f64,
    ) -> Option<Vector3<f64>> {
        self.watch(&reading, moment.now_s);
        if self.ended.is_some() {
            return None;
        }
        let Some(believed) = safety::believe(&self.safety, &mut self.chain, moment.now_s, reading) else {
            return Some(Vector3::zeros());
        };
        if believed.rejoined {
            self.mapping.let_go();
        }
        let t_s = self.grid.stamp(moment.now_s);
        let needle = self.mapping.needle(&believed.reading, self.inside);
        let output = self.advance(t_s, &needle);
        let owed_n = self.scaling.apply(&self.state, &output);
        let sent = self.protect(moment, believed, &owed_n);
        self.count(moment);
        self.tell(&TickReceivers { t_s, needle, believed, output, owed_n, sent, moment: *moment }, clock);
        Some(sent.force_n)
    }

    /// Records whether the device accepted the force of the last tick.
    pub fn wrote(&mut self, result: Result<(), DeviceFault>) {
        self.wrote = result;
        if result == Err(DeviceFault::Gone) {
            self.ended = Some(Ended::DeviceLost(DeviceFault::Gone));
        }
    }

    /// Records whether the device reports a force other than the commanded one.
    pub fn doubted(&mut self, disagrees: bool) {
        self.disagrees = disagrees;
    }

    /// Records the duration of the whole tick, in s, including reading and writing the device.
    pub fn took(&mut self, compute_s: f64) {
        self.compute.add(compute_s);
        // The two alternate, so that no tick pays for both.
        match self.counts.ticks % QUANTILES_EVERY {
            0 => self.shown.0 = self.lateness.quantiles(),
            25 => self.shown.1 = self.compute.quantiles(),
            _ => {}
        }
    }

    /// Why the servo ended, if it has.
    #[must_use]
    pub fn ended(&self) -> Option<Ended> {
        self.ended
    }

    /// Event counts since the start.
    #[must_use]
    pub fn counts(&self) -> Counts {
        Counts { dropped: self.records.dropped(), ..self.counts }
    }

    /// Lateness and compute time of the ticks.
    #[must_use]
    pub fn times(&self) -> (&Times, &Times) {
        (&self.lateness, &self.compute)
    }

    /// Ends the servo if the device is disconnected or has reported only errors for too long.
    fn watch(&mut self, reading: &Result<Reading, DeviceFault>, now_s: f64) {
        match *reading {
            Ok(_) => self.failing_since_s = None,
            Err(DeviceFault::Gone) => self.ended = Some(Ended::DeviceLost(DeviceFault::Gone)),
            Err(fault) => {
                let since_s = *self.failing_since_s.get_or_insert(now_s);
                if now_s - since_s > LOST_AFTER_S {
                    self.ended = Some(Ended::DeviceLost(fault));
                }
            }
        }
    }

    /// Steps the force law.
    fn advance(&mut self, t_s: f64, needle: &NeedlePose) -> PunctureOutput {
        let input = PunctureInput { t_s, patient_from_needle: needle.isometry() };
        let output = step(&self.params, &mut self.state, &mut self.scratch, &input);
        self.inside = output.inside;
        let ruptures = self.scratch.events.iter().filter(|event| matches!(event, PunctureEvent::Rupture(_)));
        self.counts.ruptures += ruptures.count() as u64;
        output
    }

    /// Makes a scaled force safe, in N, patient frame.
    fn protect(&mut self, moment: &TickMoment, believed: Believed, owed_n: &Vector3<f64>) -> safety::Output {
        let input = safety::SafetyInput {
            now_s: moment.now_s,
            late_periods: moment.late_s / self.grid.period_s(),
            connected: self.wrote.is_ok(),
            believed,
            wanted_n: self.mapping.device_from_patient(owed_n),
        };
        safety::step(&self.safety, &mut self.chain, &input)
    }

    fn count(&mut self, moment: &TickMoment) {
        self.lateness.add(moment.late_s);
        self.counts.ticks += 1;
        self.counts.stalls += u64::from(moment.late_s > self.grid.period_s());
    }

    /// Sends the tick to the recorder and publishes it for the display.
    fn tell(&mut self, told: &TickReceivers, clock: &dyn Fn() -> f64) {
        let device_n = self.mapping.patient_from_device(&told.sent.force_n);
        let record = Record {
            t_s: told.t_s,
            position_m: told.needle.position_m,
            orientation: told.needle.orientation,
            confirm: told.believed.reading.buttons & buttons::CONFIRM != 0,
            force_n: single(&told.output.force_n),
            device_n: single(&device_n),
            flags: told.sent.changed | self.flags(&told.moment),
            lateness_us: (told.moment.late_s * 1e6) as f32,
            compute_us: ((clock() - told.moment.now_s) * 1e6) as f32,
        };
        self.records.send(record);
        let Counts { ticks, stalls, ruptures, dropped } = self.counts();
        let snapshot = Snapshot {
            record,
            output: told.output,
            owed_n: told.owed_n,
            device_n,
            // Filled in place: an empty vector does not allocate.
            loads_n: Vec::new(),
            buttons: told.believed.reading.buttons,
            let_through: told.sent.let_through,
            ruptures,
            ticks,
            stalls,
            dropped,
            lateness: self.shown.0,
            compute: self.shown.1,
        };
        let (params, state, scratch) = (&self.params, &self.state, &self.scratch);
        self.latest.publish(snapshot, |loads_n| write_loads(params, state, scratch, loads_n));
    }

    /// The flags of this tick, without those of the safety chain.
    fn flags(&self, moment: &TickMoment) -> u32 {
        let flag = |on: bool, flag: u32| if on { flag } else { 0 };
        flag(moment.late_s > self.grid.period_s(), flags::STALLED)
            | flag(self.mapping.clutched(), flags::CLUTCHED)
            | flag(self.wrote.is_err(), flags::REFUSED)
            | flag(self.scaling.factor < 1.0, flags::SCALED)
            | flag(self.disagrees, flags::DISAGREES)
    }
}

/// The data of one tick for the recorder and the display.
struct TickReceivers {
    t_s: f64,
    needle: NeedlePose,
    believed: Believed,
    output: PunctureOutput,
    owed_n: Vector3<f64>,
    sent: safety::Output,
    moment: TickMoment,
}

fn single(v: &Vector3<f64>) -> [f32; 3] {
    v.map(|part| part as f32).into()
}
