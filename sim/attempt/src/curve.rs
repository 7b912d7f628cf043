//! The curve of an attempt, as a picture draws it.
//!
//! Reading a whole recording for each page view would cost far more than the page itself. A few
//! hundred points preserve the shape: of each stretch of ticks the one with the least and the one
//! with the greatest force are kept, so no peak is lost.

use documents::ExerciseBundle;
use recording::{Event, EventKind, Recording};
use serde::{Deserialize, Serialize};

use crate::force::{HandForces, HandSample};
use crate::layers::{LayerSpan, span_layers};
use crate::stages::{StageSpan, span_stages};

/// Maximum number of points of a curve.
pub const MAX_CURVE_POINTS: usize = 800;

/// A point of the curve.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct CurvePoint {
    /// Time since the start, in s.
    pub t_s: f64,
    /// Advance of the tip along its axis from the skin, in mm; negative above the skin.
    #[serde(alias = "depth_mm")]
    pub advance_mm: f64,
    /// Force on the hand along the needle, in N.
    pub force_n: f64,
}

/// Kind of a mark.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum MarkKind {
    /// The tip met the skin.
    Contact,
    /// The stylet tip opened a boundary: the first peak.
    TipRupture,
    /// The cannula rim opened a boundary: the second peak.
    RimRupture,
    /// The needle met a structure.
    StructureHit,
    /// The hub met the skin.
    HubContact,
    /// The tip left the skin.
    SkinExit,
    /// The trainee confirmed the position.
    Confirm,
}

/// A mark of an event on the curve.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct CurveMark {
    /// Kind of the event.
    pub kind: MarkKind,
    /// Time since the start, in s.
    pub t_s: f64,
    /// Advance of the tip along its axis from the skin, in mm.
    #[serde(alias = "depth_mm")]
    pub advance_mm: f64,
    /// Force on the hand along the needle just before, in N: the height of the mark on the curve.
    pub axial_n: f64,
    /// Name of the layer or structure concerned, or empty.
    pub name: String,
}

/// All data of an attempt that a page draws.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct AttemptCurve {
    /// Layers from the surface down.
    pub bands: Vec<LayerSpan>,
    /// Points in order of time, at most [`MAX_CURVE_POINTS`].
    pub points: Vec<CurvePoint>,
    /// Marks in order of time.
    pub marks: Vec<CurveMark>,
    /// Stages of each boundary along the deepest track.
    pub stages: Vec<StageSpan>,
    /// Planned depth, in mm along the needle.
    pub target_depth_mm: f64,
    /// Duration of the attempt, in s.
    pub duration_s: f64,
}

impl AttemptCurve {
    /// Computes the curve of a recorded attempt.
    #[must_use]
    pub fn draw(recording: &Recording, bundle: &ExerciseBundle) -> Self {
        let bands = span_layers(recording, bundle);
        let forces = HandForces::measure(recording);
        let stages = span_stages(recording, &bands, bundle.scene.needle.tip_to_rim_mm);
        Self {
            bands,
            points: forces.thin(MAX_CURVE_POINTS).into_iter().map(curve_point).collect(),
            marks: recording.events.iter().filter_map(|event| event_mark(event, &forces)).collect(),
            stages,
            target_depth_mm: bundle.exercise.target_depth_mm,
            duration_s: recording.samples.last().map_or(0.0, |s| s.t_s),
        }
    }
}

fn curve_point(HandSample { sample, force_n }: HandSample<'_>) -> CurvePoint {
    CurvePoint {
        t_s: round_to_micro(sample.t_s),
        advance_mm: round_to_micro(sample.x_m * 1e3),
        force_n: round_to_micro(force_n),
    }
}

/// Rounds to four decimals: a tenth of a micrometre and of a millinewton, far below a pixel, in a
/// third of the bytes.
fn round_to_micro(value: f64) -> f64 {
    (value * 1e4).round() / 1e4
}

fn event_mark(event: &Event, forces: &HandForces) -> Option<CurveMark> {
    let kind = match event.kind {
        EventKind::Contact => MarkKind::Contact,
        EventKind::TipRupture => MarkKind::TipRupture,
        EventKind::RimRupture => MarkKind::RimRupture,
        EventKind::StructureHit => MarkKind::StructureHit,
        EventKind::HubContact => MarkKind::HubContact,
        EventKind::SkinExit => MarkKind::SkinExit,
        EventKind::Confirm => MarkKind::Confirm,
        EventKind::Coaching | EventKind::Fault | EventKind::Interrupted => return None,
    };
    Some(CurveMark {
        kind,
        t_s: event.t_s,
        advance_mm: event.x_m * 1e3,
        axial_n: forces.before_n(event),
        name: event.text.clone(),
    })
}
