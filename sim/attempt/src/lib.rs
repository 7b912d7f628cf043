//! Attempts: simulation and analysis. A hand moves a needle in a [`tissue::Specimen`], tick by
//! tick, into a recording or into memory, and a recording's input is simulated again. From a
//! recording alone the analysis finds where the needle entered and along which axis, the layers
//! along it, the force at each event, the displacement of every boundary, and the curve of the
//! attempt.
//!
//! Window, page, replay, corridor and metrics all use this crate, so that their results agree.
//! *Advance* is the distance of the tip along the needle's axis from the skin; *depth* is the
//! length of the needle in material.

mod curve;
mod dents;
pub mod fluoroscopy;
mod follower;
mod force;
pub mod hand;
mod insertion;
mod layers;
mod lone;
pub mod playback;
pub mod run;
pub mod simulate;
mod stages;
pub mod tick;
pub mod trajectory;
pub mod verify;
mod wounds;

pub use curve::{AttemptCurve, CurveMark, CurvePoint, MAX_CURVE_POINTS, MarkKind};
pub use dents::Dents;
pub use force::{HandForces, HandSample, hand_force_n, raise_to_rupture_n};
pub use hand::HandChoice;
pub use insertion::{Insertion, deepest_insertion, find_insertions, is_inserted, needle_axis};
pub use layers::{LayerSpan, patient_thicknesses_m, span_layers};
pub use lone::LoneNeedle;
pub use stages::{BoundaryStage, StageSpan};
pub use wounds::{Hub, Wound, Wounds};
