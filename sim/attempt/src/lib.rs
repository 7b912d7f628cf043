//! What an attempt is. Performing it: a hand moves a needle in a [`tissue::Specimen`], tick by tick, into a recording or into memory, and a
//! recording's input is simulated anew. And what it was, from its recording alone: where the needle went in and along which axis, where
//! the layers lie along it, what was felt at each event, how every boundary stood, and the curve of it all.
//!
//! Window, page, replay, corridor and metrics ask here, so that they cannot answer differently. *Advance* is the way of the tip along the
//! needle's axis from the skin; *depth* is how much of the needle is in material.

mod curve;
mod dents;
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
pub use force::{HandForces, hand_force_n, raise_to_rupture_n};
pub use hand::HandChoice;
pub use insertion::{Insertion, deepest_insertion, find_insertions, is_inserted, needle_axis};
pub use layers::{LayerSpan, patient_thicknesses_m, span_layers};
pub use lone::LoneNeedle;
pub use stages::{BoundaryStage, StageSpan};
pub use wounds::{Hub, Wound, Wounds};
