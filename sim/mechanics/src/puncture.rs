//! The needle in space: contact, latched axis, tracks, lateral foundation and structures around the axial law.

use nalgebra::{Isometry3, Point3, Vector3};
use serde::{Deserialize, Serialize};

use crate::axial::{AxialOutput, AxialSpec, AxialState, ParamError, Rupture, Stage};
use crate::ledger::Ledger;
use crate::structures::StructureSpec;

/// What [`PunctureParams`] is made of, unchecked.
#[derive(Clone, Debug)]
pub struct PunctureSpec {
    /// The axial law.
    pub axial: AxialSpec,
    /// Lateral foundation per inserted metre, in N/m² (default 10 000).
    pub lateral_stiffness_n_per_m2: f64,
    /// Needle length from tip to hub, in m.
    pub needle_length_m: f64,
    /// Structures in the patient frame.
    pub structures: Vec<StructureSpec>,
}

/// Checked parameters, constant for an attempt.
#[derive(Debug)]
pub struct PunctureParams {
    _private: (),
}

/// One sample of the device.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PunctureInput {
    /// Time, in s. Must increase.
    pub t_s: f64,
    /// Pose of the needle: position of the tip in m, orientation with +z from hub to tip.
    pub patient_from_needle: Isometry3<f64>,
}

/// All that must be saved to continue.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct PunctureState {
    /// The axial law on the current track; its ledger covers all tracks.
    pub axial: AxialState,
}

/// Reused between steps, never saved. Holds the events of the last step.
#[derive(Clone, Debug)]
pub struct PunctureScratch {
    /// What happened in the last step, in order. Preallocated.
    pub events: Vec<PunctureEvent>,
}

/// Something that happened in a step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum PunctureEvent {
    /// The tip met the skin.
    Contact {
        /// Where, in the patient frame, in m.
        entry_m: Point3<f64>,
        /// Which track, from 0.
        track: usize,
        /// The track existed: this is a re-entry within 2 mm.
        reused: bool,
    },
    /// A boundary ruptured.
    Rupture(Rupture),
    /// The needle met a structure it was outside of.
    StructureHit {
        /// Index into the scene's structures.
        structure: usize,
        /// The tip itself is inside; otherwise only the shaft is.
        by_tip: bool,
    },
    /// The tip left the skin.
    SkinExit,
    /// A bad input was held.
    Fault,
}

/// The result of a step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PunctureOutput {
    /// Axial displacement of the tip along the latched axis from its entry, in m; negative above the skin.
    pub x_m: f64,
    /// The axial law's parts.
    pub axial: AxialOutput,
    /// Lateral force on the hand, in the patient frame, in N.
    pub lateral_n: Vector3<f64>,
    /// Contact force of bone on the hand, in the patient frame, in N.
    pub bone_n: Vector3<f64>,
    /// Whole force on the hand, in the patient frame, in N.
    pub force_n: Vector3<f64>,
    /// Where the current boundary stands.
    pub stage: Stage,
    /// The boundary that `stage` speaks of: the first that is not fully open.
    pub boundary: usize,
    /// The axis is latched: the tip is in the body.
    pub inside: bool,
    /// Least distance of the tip, or of the inserted shaft, to any structure that is not a target, in m; infinite if none.
    pub clearance_m: f64,
}

impl PunctureParams {
    /// Checks and freezes a specification.
    ///
    /// # Errors
    /// The first parameter that is non-finite or out of range.
    pub fn new(_spec: PunctureSpec) -> Result<Self, ParamError> {
        unimplemented!()
    }

    /// The specification these parameters were made from.
    #[must_use]
    pub fn spec(&self) -> &PunctureSpec {
        unimplemented!()
    }
}

impl PunctureState {
    /// A needle in the air.
    #[must_use]
    pub fn new(_params: &PunctureParams) -> Self {
        unimplemented!()
    }
}

impl PunctureState {
    /// Energy so far, over all tracks.
    #[must_use]
    pub fn ledger(&self) -> &Ledger {
        &self.axial.ledger
    }
}

impl PunctureScratch {
    /// Scratch large enough for `params`.
    #[must_use]
    pub fn new(_params: &PunctureParams) -> Self {
        unimplemented!()
    }
}

/// One step. Never fails: a bad input is held, flagged and reported as an event.
pub fn step(
    _params: &PunctureParams,
    _state: &mut PunctureState,
    _scratch: &mut PunctureScratch,
    _input: &PunctureInput,
) -> PunctureOutput {
    unimplemented!()
}
