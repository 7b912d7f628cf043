//! Re-simulates the recorded input and compares every recorded force.

use std::cmp::Ordering;

use recording::sample::{Energy, flags};
use recording::{Event, EventKind, Follows, Recording, Sample, Tent};
use tissue::Specimen;

use crate::tick::{TickInput, TickedAttempt};

/// The deviations of a recording from its re-simulation.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
pub struct Verification {
    /// Number of ticks compared.
    pub ticks: u64,
    /// Largest deviation of any force channel, in N, after rounding to f32; the largest f64 if only
    /// one side is a finite number.
    pub largest_deviation_n: f64,
    /// Its time, in s.
    pub at_s: f64,
    /// Its channel, for example `friction_n`; empty without a deviation.
    pub channel: String,
    /// Largest deviation of the tip's axial displacement, depth and bend, in m.
    pub largest_depth_deviation_m: f64,
    /// Number of events that only one of the two has, recording or re-simulation.
    pub event_differences: u64,
    /// Number of field steps compared: 0 in a scene without a field, and for a file that is older
    /// than the field's topic.
    pub tents: u64,
    /// Largest deviation of the field's displacements, in m.
    pub largest_tent_deviation_m: f64,
    /// Number of field steps from the first one on that does not match in time or shape.
    pub tent_differences: u64,
    /// Number of the recording's ledgers that differ in the re-simulation or have no tick there;
    /// one more if a signed recording does not end with a ledger.
    pub ledger_differences: u64,
    /// Number of pulses of the C-arm from the first one on that differs in time, kind, tube load or dose; counted by the caller, which has
    /// the exercise.
    pub pulse_differences: u64,
    /// Number of ticks that are inside the body in only one of the two.
    pub inside_differences: u64,
}

impl Verification {
    /// Whether the recording is bit-identical to the simulation of its input in this scene.
    #[must_use]
    pub fn exact(&self) -> bool {
        let largest = self.largest_deviation_n.max(self.largest_depth_deviation_m).max(self.largest_tent_deviation_m);
        largest <= 0.0 && self.count_differences() == 0
    }

    /// Returns the number of events, field steps, ledgers, pulses and ticks in which the two differ.
    #[must_use]
    pub fn count_differences(&self) -> u64 {
        let motion = self.event_differences + self.inside_differences;
        motion + self.tent_differences + self.ledger_differences + self.pulse_differences
    }
}

/// Compares a recording with its own re-simulation.
///
/// The force sent to the device is compared if the device takes any force; otherwise the safety
/// chain has changed it. Coaching, faults and interruptions are not compared: they come from
/// outside the force law.
#[must_use]
pub fn verify_recording(recording: &Recording, specimen: &Specimen) -> Verification {
    let device_takes_all = recording.session.device_max_force_n.is_infinite();
    let follows = recording.tents.first().map_or(Follows::Secant, |tent| tent.follows);
    let mut attempt = TickedAttempt::following(specimen, follows);
    let mut events = Vec::new();
    let mut verification = Verification {
        ticks: recording.samples.len() as u64,
        largest_deviation_n: 0.0,
        at_s: 0.0,
        channel: String::new(),
        largest_depth_deviation_m: 0.0,
        event_differences: 0,
        tents: recording.tents.len() as u64,
        largest_tent_deviation_m: 0.0,
        tent_differences: 0,
        ledger_differences: 0,
        pulse_differences: 0,
        inside_differences: 0,
    };
    let mut tents = Vec::new();
    let mut ledgers = recording.energies.iter().peekable();
    for recorded in &recording.samples {
        let tick = attempt.step(&TickInput::from(recorded));
        while let Some(energy) = ledgers.next_if(|energy| energy.t_s <= recorded.t_s) {
            verification.ledger_differences += u64::from(!is_same_ledger(energy, &attempt.energy(recorded.t_s)));
        }
        events.extend(tick.events.into_iter().filter(is_comparable));
        verification.compare(recorded, &tick.sample, device_takes_all);
        tents.extend(tick.tent);
    }
    verification.ledger_differences += ledgers.count() as u64;
    if recording.signature.is_some() && ends_without_ledger(recording) {
        verification.ledger_differences += 1;
    }
    let recorded: Vec<&Event> = recording.events.iter().filter(|e| is_comparable(e)).collect();
    verification.event_differences = count_event_differences(&recorded, &events);
    if verification.tents > 0 {
        verification.compare_field(&recording.tents, &tents);
    }
    verification
}

impl Verification {
    fn compare(&mut self, recorded: &Sample, again: &Sample, device_takes_all: bool) {
        for ((channel, a), (_, b)) in force_channels(recorded).into_iter().zip(force_channels(again)) {
            if channel.starts_with("device_n") && !device_takes_all {
                continue;
            }
            self.note(force_deviation(a.into(), b.into()), recorded.t_s, channel);
        }
        self.inside_differences += u64::from((recorded.flags ^ again.flags) & flags::INSIDE != 0);
        let depth_m = force_deviation(recorded.depth_m.into(), again.depth_m.into());
        let x_m = force_deviation(recorded.x_m, again.x_m);
        let bends = recorded.bend_m.into_iter().zip(again.bend_m);
        let bend_m = bends.map(|(a, b)| force_deviation(a.into(), b.into())).fold(0.0, f64::max);
        self.largest_depth_deviation_m = self.largest_depth_deviation_m.max(depth_m).max(x_m).max(bend_m);
    }

    /// Stores the deviation of a force, in N, if it is the largest so far.
    fn note(&mut self, deviation_n: f64, at_s: f64, channel: &str) {
        if deviation_n > self.largest_deviation_n {
            self.largest_deviation_n = deviation_n;
            self.at_s = at_s;
            channel.clone_into(&mut self.channel);
        }
    }

    /// Compares the steps of the field one by one. The first with another time, shape or followed
    /// quantity ends the comparison: the steps after it have no counterpart.
    fn compare_field(&mut self, recorded: &[Tent], again: &[Tent]) {
        let alike = |a: &Tent, b: &Tent| {
            a.t_s.total_cmp(&b.t_s).is_eq() && tent_shape(a) == tent_shape(b) && a.follows == b.follows
        };
        let same = recorded.iter().zip(again).take_while(|(a, b)| alike(a, b)).count();
        self.tent_differences = (recorded.len().max(again.len()) - same) as u64;
        for (a, b) in recorded.iter().zip(again).take(same) {
            let tent_m = largest_deviation(&a.tent_m, &b.tent_m);
            self.largest_tent_deviation_m = self.largest_tent_deviation_m.max(tent_m);
            self.note(largest_deviation(&a.contactor_n, &b.contactor_n), a.t_s, "contactor_n");
            self.note(largest_deviation(&a.drag_n, &b.drag_n), a.t_s, "drag_n");
            self.note(largest_deviation(&a.linear_n, &b.linear_n), a.t_s, "linear_n");
        }
    }
}

/// Whether a recording does not end with a ledger. The energy metrics are those of the last ledger.
/// A truncated recording ends before it, and is not signed.
fn ends_without_ledger(recording: &Recording) -> bool {
    let last = recording.samples.last().map(|sample| sample.t_s);
    last.is_some() && recording.energies.last().map(|energy| energy.t_s) != last
}

/// Whether two ledgers have the same time and the same energies in each layer. The totals are not
/// compared: no metric uses them, and earlier programs did not record all of them.
fn is_same_ledger(recorded: &Energy, again: &Energy) -> bool {
    recorded.t_s.total_cmp(&again.t_s).is_eq() && recorded.ledger.layers == again.ledger.layers
}

/// Returns every force of a sample, in N.
fn force_channels(s: &Sample) -> [(&'static str, f32); 14] {
    [
        ("tip_n", s.tip_n),
        ("rim_n", s.rim_n),
        ("viscous_n", s.viscous_n),
        ("friction_n", s.friction_n),
        ("cutting_n", s.cutting_n),
        ("force_n.x", s.force_n[0]),
        ("force_n.y", s.force_n[1]),
        ("force_n.z", s.force_n[2]),
        ("lateral_n.x", s.lateral_n[0]),
        ("lateral_n.y", s.lateral_n[1]),
        ("lateral_n.z", s.lateral_n[2]),
        ("device_n.x", s.device_n[0]),
        ("device_n.y", s.device_n[1]),
        ("device_n.z", s.device_n[2]),
    ]
}

/// Returns the numbers of boundaries and loads of a field step.
fn tent_shape(tent: &Tent) -> [usize; 4] {
    [tent.tent_m.len(), tent.contactor_n.len(), tent.drag_n.len(), tent.linear_n.len()]
}

/// Returns the largest deviation between two lists.
fn largest_deviation(a: &[f32], b: &[f32]) -> f64 {
    a.iter().zip(b).map(|(&a, &b)| force_deviation(a.into(), b.into())).fold(0.0, f64::max)
}

#[expect(clippy::float_cmp, reason = "verification asks for the very same number")]
fn force_deviation(a: f64, b: f64) -> f64 {
    // Compares first, because the difference of two equal infinities is NaN.
    let same = a == b || (a.is_nan() && b.is_nan());
    let difference = (a - b).abs();
    match (same, difference.is_finite()) {
        (true, _) => 0.0,
        (false, true) => difference,
        // JSON has no infinity.
        (false, false) => f64::MAX,
    }
}

fn is_comparable(event: &Event) -> bool {
    !matches!(event.kind, EventKind::Coaching | EventKind::Fault | EventKind::Interrupted)
}

/// Counts the events that only one of two lists in order of time contains.
fn count_event_differences(recorded: &[&Event], again: &[Event]) -> u64 {
    let (mut i, mut j, mut count) = (0, 0, 0);
    while let (Some(&a), Some(b)) = (recorded.get(i), again.get(j)) {
        let order = if a == b { Ordering::Equal } else { a.t_s.total_cmp(&b.t_s) };
        // Two that differ at the same time count once for each list.
        let differ = a != b;
        if order != Ordering::Greater {
            i += 1;
            count += u64::from(differ);
        }
        if order != Ordering::Less {
            j += 1;
            count += u64::from(differ);
        }
    }
    count + (recorded.len() - i) as u64 + (again.len() - j) as u64
}
