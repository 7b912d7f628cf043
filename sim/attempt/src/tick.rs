//! One tick of an attempt: converts a pose to a sample and its events.
//!
//! The only place where forces become recorded values. A simulation and its verification both use
//! it, so that they can differ in their input only.

use law::axial::Contactor;
use law::operator::{Felt, Motion};
use law::puncture::{PunctureEvent, PunctureInput, PunctureOutput, PunctureScratch, PunctureState, step};
use nalgebra::{Isometry3, Quaternion, Translation3, UnitQuaternion, Vector3};
use recording::sample::{Energy, Sample, flags};
use recording::{Event, EventKind, Follows, Tent};
use tissue::Specimen;

use crate::follower::FieldFollower;

/// Input of a tick.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TickInput {
    /// Time since the start, in s.
    pub t_s: f64,
    /// Tip position, in m, patient frame.
    pub position_m: [f64; 3],
    /// Orientation patient_from_needle as a unit quaternion x, y, z, w.
    pub orientation: [f64; 4],
    /// Whether the confirm button is down.
    pub confirm: bool,
}

impl TickInput {
    /// Returns the input for a motion at a time in s.
    #[must_use]
    pub fn new(t_s: f64, motion: &Motion) -> Self {
        let pose = &motion.patient_from_needle;
        // A recording does not keep the sign of a zero. Adding 0 clears it before the force law can
        // see it.
        Self {
            t_s,
            position_m: pose.translation.vector.map(|c| c + 0.0).into(),
            orientation: pose.rotation.coords.map(|c| c + 0.0).into(),
            confirm: motion.confirm,
        }
    }

    fn pose(&self) -> Isometry3<f64> {
        // Unchecked, because normalising again would change the last bit of the recorded values.
        let rotation = UnitQuaternion::new_unchecked(Quaternion::from(self.orientation));
        Isometry3::from_parts(Translation3::from(self.position_m), rotation)
    }
}

impl From<&Sample> for TickInput {
    fn from(sample: &Sample) -> Self {
        Self {
            t_s: sample.t_s,
            position_m: sample.position_m,
            orientation: sample.orientation,
            confirm: sample.flags & flags::CONFIRM != 0,
        }
    }
}

/// The result of a tick.
#[derive(Clone, Debug, PartialEq)]
pub struct Tick {
    /// The sample, with the whole force sent to the device and no lateness.
    pub sample: Sample,
    /// Events, in order. Empty in almost every tick.
    pub events: Vec<Event>,
    /// The field, if a step of it was due.
    pub tent: Option<Tent>,
    /// The forces that the hand feels.
    pub felt: Felt,
    /// Force on the hand along the latched axis, in N: layers, bone, walls and the hub.
    pub hand_n: f64,
}

/// The tissue of one attempt, while it is punctured.
#[derive(Debug)]
pub struct TickedAttempt<'a> {
    specimen: &'a Specimen,
    state: PunctureState,
    scratch: PunctureScratch,
    /// The field behind the law, if the scene has one.
    follower: Option<FieldFollower<'a>>,
    last: Option<TickInput>,
    /// The layers' share of the axial force of the last tick, in N.
    axial_n: f64,
}

impl<'a> TickedAttempt<'a> {
    /// Untouched tissue.
    #[must_use]
    pub fn new(specimen: &'a Specimen) -> Self {
        Self::following(specimen, Follows::Secant)
    }

    /// As [`TickedAttempt::new`], with a field that follows the same quantity as a recording's.
    #[must_use]
    pub fn following(specimen: &'a Specimen, follows: Follows) -> Self {
        let law = specimen.law();
        Self {
            specimen,
            state: PunctureState::new(law),
            scratch: PunctureScratch::new(law),
            follower: FieldFollower::new(specimen, follows),
            last: None,
            axial_n: 0.0,
        }
    }

    /// Advances by one tick.
    pub fn step(&mut self, input: &TickInput) -> Tick {
        let puncture = PunctureInput { t_s: input.t_s, patient_from_needle: input.pose() };
        let output = step(self.specimen.law(), &mut self.state, &mut self.scratch, &puncture);
        let sample = self.sample(input, &output);
        let events = self.events(input, &output);
        self.last = Some(*input);
        self.axial_n = output.axial.total_n();
        let tent = self.follower.as_mut().and_then(|follower| follower.tick(input.t_s, &self.state, &self.scratch));
        Tick { sample, events, tent, felt: Felt::from(&output), hand_n: output.hand_n }
    }

    /// Returns the ledger after the last tick, at a time in s.
    #[must_use]
    pub fn energy(&self, t_s: f64) -> Energy {
        Energy { t_s, ledger: self.state.ledger().clone() }
    }

    fn sample(&self, input: &TickInput, output: &PunctureOutput) -> Sample {
        let axial = &output.axial;
        let faulty = self.scratch.events.contains(&PunctureEvent::Fault);
        let flag = |on: bool, bit: u32| if on { bit } else { 0 };
        Sample {
            t_s: input.t_s,
            position_m: input.position_m,
            orientation: input.orientation,
            velocity_m_per_s: self.velocity(input).map(|v| v as f32),
            x_m: output.x_m,
            depth_m: axial.depth_m as f32,
            force_n: single(&output.force_n),
            tip_n: axial.tip_n as f32,
            rim_n: axial.rim_n as f32,
            viscous_n: axial.viscous_n as f32,
            friction_n: axial.friction_n as f32,
            cutting_n: axial.cutting_n as f32,
            lateral_n: single(&output.lateral_n),
            device_n: single(&output.force_n),
            flags: flag(output.inside, flags::INSIDE)
                | flag(axial.held || faulty, flags::HELD)
                | flag(input.confirm, flags::CONFIRM),
            lateness_us: 0.0,
            bend_m: single(&output.bend_m),
        }
    }

    /// Backward difference of the position, in m/s; 0 at the first tick.
    fn velocity(&self, input: &TickInput) -> [f64; 3] {
        let Some(last) = &self.last else { return [0.0; 3] };
        let dt_s = input.t_s - last.t_s;
        if dt_s > 0.0 { std::array::from_fn(|i| (input.position_m[i] - last.position_m[i]) / dt_s) } else { [0.0; 3] }
    }

    fn events(&self, input: &TickInput, output: &PunctureOutput) -> Vec<Event> {
        let mut events: Vec<Event> = self.scratch.events.iter().map(|e| self.event(e, input, output)).collect();
        if input.confirm && !self.last.is_some_and(|last| last.confirm) {
            events.push(self.plain(EventKind::Confirm, input, output));
        }
        events
    }

    /// Returns an event of a kind, without data of its own.
    fn plain(&self, kind: EventKind, input: &TickInput, output: &PunctureOutput) -> Event {
        Event {
            t_s: input.t_s,
            kind,
            boundary: None,
            x_m: output.x_m,
            position_m: input.position_m,
            force_n: self.axial_n,
            dissipated_j: 0.0,
            track: None,
            structure: None,
            text: String::new(),
        }
    }

    fn event(&self, event: &PunctureEvent, input: &TickInput, output: &PunctureOutput) -> Event {
        let spec = self.specimen.spec();
        let plain = |kind| self.plain(kind, input, output);
        match *event {
            PunctureEvent::Contact { entry_m, track, reused } => Event {
                position_m: entry_m.into(),
                track: Some(number(track)),
                text: if reused { "re-entry" } else { "" }.to_owned(),
                ..plain(EventKind::Contact)
            },
            PunctureEvent::Rupture(rupture) => Event {
                boundary: Some(number(rupture.boundary)),
                x_m: rupture.x_m,
                force_n: rupture.force_n,
                dissipated_j: rupture.dissipated_j,
                text: spec.axial.layers.get(rupture.boundary).map(|l| l.name.clone()).unwrap_or_default(),
                ..plain(match rupture.contactor {
                    Contactor::Tip => EventKind::TipRupture,
                    Contactor::Rim => EventKind::RimRupture,
                })
            },
            PunctureEvent::StructureHit { structure, .. } => Event {
                structure: Some(number(structure)),
                text: spec.structures.get(structure).map(|s| s.name.clone()).unwrap_or_default(),
                ..plain(EventKind::StructureHit)
            },
            PunctureEvent::HubContact => plain(EventKind::HubContact),
            PunctureEvent::SkinExit => plain(EventKind::SkinExit),
            PunctureEvent::Fault => Event { text: "a bad input was held".to_owned(), ..plain(EventKind::Fault) },
        }
    }
}

fn single(v: &Vector3<f64>) -> [f32; 3] {
    v.map(|c| c as f32).into()
}

/// Converts an index to the recording's type.
#[expect(clippy::expect_used, reason = "documents limit the boundaries and structures of a scene to far fewer")]
fn number(index: usize) -> u32 {
    u32::try_from(index).expect("a scene has far fewer than 2³² of anything")
}
