//! Input, output and state of a step.

use nalgebra::{Isometry3, Point3, Vector3};
use serde::{Deserialize, Serialize};

use super::contact::{Latch, MAX_TRACKS, Track};
use super::params::PunctureParams;
use crate::axial::{AxialOutput, AxialScratch, AxialState, PiercingStage, Rupture};
use crate::hold::Hold;
use crate::ledger::Ledger;
use crate::structures::{Meeting, Sighting};

/// One sample of the device.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PunctureInput {
    /// Time, in s. Must increase.
    pub t_s: f64,
    /// Pose of the needle: position of the tip in m, orientation with +z from hub to tip.
    pub patient_from_needle: Isometry3<f64>,
}

/// The needle at the last good sample.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct LastPose {
    pub tip_m: Point3<f64>,
    pub axis: Vector3<f64>,
    /// The needle's +x, along which a bevel's edge lies.
    #[serde(default = "Vector3::x")]
    pub edge: Vector3<f64>,
}

/// The complete state, sufficient to continue. Floats survive JSON exactly, so a continued run is
/// bit-identical.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct PunctureState {
    /// The axial law on the current track; its ledger covers all tracks.
    pub axial: AxialState,
    pub(super) tracks: Vec<Track>,
    pub(super) latch: Option<Latch>,
    pub(super) last: Option<LastPose>,
    /// For each structure, whether the needle was in it.
    pub(super) touching: Vec<bool>,
    /// For each structure, whether its wall is open on the current track.
    #[serde(default)]
    pub(super) open_walls: Vec<bool>,
    /// For each structure, its hold on the tip: bone, from version 4 of the law.
    #[serde(default)]
    pub(super) holds: Vec<Option<Hold>>,
    /// The hub is at the skin.
    #[serde(default)]
    pub(super) hub_touches: bool,
}

/// Reused between steps, never saved. Holds the events of the last step.
#[derive(Clone, Debug)]
pub struct PunctureScratch {
    /// Events of the last step, in order. Preallocated.
    pub events: Vec<PunctureEvent>,
    pub(super) axial: AxialScratch,
    /// Relation of the needle to each structure.
    pub(super) meetings: Vec<Meeting>,
    /// The last distance search for each structure.
    pub(super) sightings: Vec<Option<Sighting>>,
}

/// An event of a step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum PunctureEvent {
    /// The tip met the skin.
    Contact {
        /// Entry point, in the patient frame, in m.
        entry_m: Point3<f64>,
        /// Index of the track, from 0.
        track: usize,
        /// Whether the track existed: this is a re-entry within 2 mm.
        reused: bool,
    },
    /// A boundary ruptured.
    Rupture(Rupture),
    /// The needle touched a structure from outside.
    StructureHit {
        /// Index into the scene's structures.
        structure: usize,
        /// Whether the tip itself is inside; otherwise only the shaft is.
        by_tip: bool,
    },
    /// The hub met the skin: the shaft is in to its end.
    HubContact,
    /// The tip left the skin.
    SkinExit,
    /// An invalid input was ignored.
    Fault,
}

/// The result of a step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PunctureOutput {
    /// Axial displacement of the tip along the latched axis from its entry, in m. Before contact:
    /// the distance to the skin along the needle's axis, negative.
    pub x_m: f64,
    /// The parts of the axial law.
    pub axial: AxialOutput,
    /// Lateral force on the hand, in the patient frame, in N.
    pub lateral_n: Vector3<f64>,
    /// Offset of the tip from the hand's line, in the patient frame, in m: 0 for a rigid needle.
    pub bend_m: Vector3<f64>,
    /// Force of bone and of closed walls on the hand, in the patient frame, in N.
    pub structures_n: Vector3<f64>,
    /// Push of bone alone on the tip, in N.
    pub bone_n: f64,
    /// How hard the skin pushes on the hub, against the latched axis, in N.
    pub hub_n: f64,
    /// Force on the hand along the latched axis, in N, positive outwards: the axial law, structures and the hub. What `force_n` has
    /// besides `lateral_n`, projected on that axis.
    pub hand_n: f64,
    /// Whole force on the hand, in the patient frame, in N.
    pub force_n: Vector3<f64>,
    /// Stage of the current boundary.
    pub stage: PiercingStage,
    /// The boundary of `stage`: the first that is not fully open, or the last if all are.
    pub boundary: usize,
    /// Whether the axis is latched: the tip is in the body.
    pub inside: bool,
}

impl PunctureState {
    /// The state of a needle in the air.
    #[must_use]
    pub fn new(params: &PunctureParams) -> Self {
        Self {
            axial: AxialState::new(&params.axial),
            tracks: Vec::with_capacity(MAX_TRACKS),
            latch: None,
            last: None,
            touching: vec![false; params.structures.len()],
            open_walls: vec![false; params.structures.len()],
            holds: vec![None; params.structures.len()],
            hub_touches: false,
        }
    }

    /// Energies so far, over all tracks.
    #[must_use]
    pub fn ledger(&self) -> &Ledger {
        &self.axial.ledger
    }

    /// The axis that the needle is held to in the body, unit length, from hub to tip; none in the air.
    #[must_use]
    pub fn latched_axis(&self) -> Option<Vector3<f64>> {
        self.latch.as_ref().map(|latch| latch.axis)
    }

    /// How many tracks there are.
    #[must_use]
    pub fn tracks(&self) -> usize {
        self.tracks.len()
    }
}

impl PunctureScratch {
    /// Scratch large enough for `params`.
    #[must_use]
    pub fn new(params: &PunctureParams) -> Self {
        let axial = AxialScratch::new(&params.axial);
        let structures = params.structures.len();
        // Contact, hub and exit or fault, every rupture, every structure.
        let events = 3 + axial.ruptures.capacity() + structures;
        let (meetings, sightings) = (Vec::with_capacity(structures), vec![None; structures]);
        Self { events: Vec::with_capacity(events), axial, meetings, sightings }
    }

    /// Resting positions of the boundaries along the needle's path, and of the far side, in m.
    /// Empty before the first step.
    #[must_use]
    pub fn boundaries_m(&self) -> &[f64] {
        self.axial.boundaries_m()
    }
}
