//! The curve of an attempt: what a page draws, made once when the attempt is scored.
//!
//! Reading a whole recording for each page view would cost far more than the page itself. A few hundred points keep
//! the shape: of each stretch of ticks the one of least and the one of greatest force survive, so no peak is lost.

use recording::{Event, EventKind, Recording, Sample, thin};
use scene::ExerciseBundle;
use serde::{Deserialize, Serialize};

/// Most points that a curve keeps.
pub const MAX_POINTS: usize = 800;

/// A layer as the needle crosses it, at rest, along the needle's axis.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Band {
    /// The layer's name.
    pub name: String,
    /// The layer's texture, which chooses its colour.
    pub texture: String,
    /// Where it begins, in mm along the needle.
    pub top_mm: f64,
    /// Where it ends, in mm along the needle.
    pub bottom_mm: f64,
}

/// One moment.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Point {
    /// Time since the start, in s.
    pub t_s: f64,
    /// Advance of the tip along its axis from the skin, in mm; negative above the skin.
    pub depth_mm: f64,
    /// Axial force on the hand, in N.
    pub force_n: f64,
}

/// What a mark stands for.
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
    /// The tip left the skin.
    SkinExit,
    /// The trainee confirmed the position.
    Confirm,
}

/// An event on the curve.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Mark {
    /// What happened.
    pub kind: MarkKind,
    /// When, in s since the start.
    pub t_s: f64,
    /// Where the tip was, in mm along its axis.
    pub depth_mm: f64,
    /// Force just before, in N.
    pub force_n: f64,
    /// Axial force on the hand at that moment, in N: the height of the mark on the curve.
    pub axial_n: f64,
    /// The layer or structure concerned, or empty.
    pub name: String,
}

/// How far a boundary has come, as the paper names it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Stage {
    /// The tip tents the boundary.
    I,
    /// The tip is through, the rim not yet there.
    II,
    /// The rim tents the boundary.
    III,
    /// The rim is through.
    IV,
}

impl Stage {
    /// All four, in order.
    pub const ALL: [Self; 4] = [Self::I, Self::II, Self::III, Self::IV];

    /// Roman numeral.
    #[must_use]
    pub fn numeral(self) -> &'static str {
        match self {
            Self::I => "I",
            Self::II => "II",
            Self::III => "III",
            Self::IV => "IV",
        }
    }

    /// The stage as a class of drawings.
    #[must_use]
    pub fn class(self) -> &'static str {
        match self {
            Self::I => "one",
            Self::II => "two",
            Self::III => "three",
            Self::IV => "four",
        }
    }

    /// What the stage means, in words.
    #[must_use]
    pub fn meaning(self) -> &'static str {
        match self {
            Self::I => tr!("the tip presses the boundary in"),
            Self::II => tr!("the tip is through, the rim not yet there"),
            Self::III => tr!("the rim presses the boundary in"),
            Self::IV => tr!("the rim is through"),
        }
    }
}

/// A stage of a boundary over a stretch of the needle's way.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct StageSpan {
    /// The boundary, from 0: the upper face of that layer.
    pub boundary: usize,
    /// The stage.
    pub stage: Stage,
    /// Where it began, in mm along the needle.
    pub from_mm: f64,
    /// Where it ended, in mm along the needle.
    pub to_mm: f64,
}

/// Everything the session page draws.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Curve {
    /// Layers from the surface down.
    pub bands: Vec<Band>,
    /// Moments in order of time, at most [`MAX_POINTS`].
    pub points: Vec<Point>,
    /// Events in order of time.
    pub marks: Vec<Mark>,
    /// Stages of each boundary along the deepest track.
    pub stages: Vec<StageSpan>,
    /// Depth asked for, in mm along the needle.
    pub target_depth_mm: f64,
    /// Length of the attempt, in s.
    pub duration_s: f64,
}

impl Curve {
    /// Makes the curve of a recorded attempt.
    #[must_use]
    pub fn of(recording: &Recording, bundle: &ExerciseBundle) -> Self {
        let track = DeepestTrack::find(recording);
        let bands = bands(recording, bundle, track.cos_angle);
        let stages = stages(&bands, &track, bundle.scene.needle.tip_to_rim_mm);
        Self {
            bands,
            points: thin(&recording.samples, MAX_POINTS).into_iter().map(point).collect(),
            marks: marks(recording),
            stages,
            target_depth_mm: bundle.exercise.target_depth_mm,
            duration_s: recording.samples.last().map_or(0.0, |s| s.t_s),
        }
    }
}

/// The track that went deepest: the one whose stages are told.
struct DeepestTrack<'a> {
    ruptures: Vec<&'a Event>,
    deepest_mm: f64,
    cos_angle: f64,
}

impl<'a> DeepestTrack<'a> {
    fn find(recording: &'a Recording) -> Self {
        let deepest = recording.samples.iter().max_by(|a, b| a.x_m.total_cmp(&b.x_m));
        let t_deepest_s = deepest.map_or(0.0, |s| s.t_s);
        let contacts = || recording.events.iter().filter(|e| e.kind == EventKind::Contact);
        let track = contacts().rfind(|e| e.t_s <= t_deepest_s).and_then(|e| e.track);
        let ruptures = recording
            .events
            .iter()
            .filter(|e| e.kind.contactor().is_some())
            .filter(|e| contacts().rfind(|c| c.t_s <= e.t_s).and_then(|c| c.track) == track)
            .collect();
        Self {
            ruptures,
            deepest_mm: deepest.map_or(0.0, |s| s.x_m * 1e3).max(0.0),
            cos_angle: deepest.map_or(1.0, cos_to_normal),
        }
    }

    /// Where the first rupture of a kind opened a boundary, in mm along the needle.
    fn opened_mm(&self, kind: EventKind, boundary: usize) -> Option<f64> {
        let opened = self.ruptures.iter().find(|e| e.kind == kind && e.boundary.map(|b| b as usize) == Some(boundary));
        opened.map(|e| e.x_m * 1e3)
    }
}

/// Cosine of the angle between the needle and the surface normal. The needle's +z points to the tip, so that the z
/// component of the turned axis is 1 − 2(x² + y²) and is −1 for a needle straight down.
fn cos_to_normal(sample: &Sample) -> f64 {
    let [x, y, ..] = sample.orientation;
    let cos = 2.0 * (x * x + y * y) - 1.0;
    // Below 0.2 (78°) no exercise is allowed; a broken orientation must not stretch the layers without bound.
    if cos.is_finite() { cos.clamp(0.2, 1.0) } else { 1.0 }
}

fn bands(recording: &Recording, bundle: &ExerciseBundle, cos_angle: f64) -> Vec<Band> {
    let drawn = &recording.session.patient_thickness_mm;
    let mut top_mm = 0.0;
    let mut bands = Vec::with_capacity(bundle.scene.layers.len());
    for (index, layer) in bundle.scene.layers.iter().enumerate() {
        let thickness_mm = drawn.get(index).copied().unwrap_or(layer.thickness_mm);
        let bottom_mm = top_mm + thickness_mm / cos_angle;
        bands.push(Band { name: layer.name.clone(), texture: layer.texture.clone(), top_mm, bottom_mm });
        top_mm = bottom_mm;
    }
    bands
}

fn point(sample: &Sample) -> Point {
    Point { t_s: round(sample.t_s), depth_mm: round(sample.x_m * 1e3), force_n: round(sample.axial_n()) }
}

/// Four decimals: a tenth of a micrometre and of a millinewton, far below a pixel, and a third of the bytes.
fn round(value: f64) -> f64 {
    (value * 1e4).round() / 1e4
}

fn marks(recording: &Recording) -> Vec<Mark> {
    recording.events.iter().filter_map(|event| mark(event, &recording.samples)).collect()
}

fn mark(event: &Event, samples: &[Sample]) -> Option<Mark> {
    let kind = match event.kind {
        EventKind::Contact => MarkKind::Contact,
        EventKind::TipRupture => MarkKind::TipRupture,
        EventKind::RimRupture => MarkKind::RimRupture,
        EventKind::StructureHit => MarkKind::StructureHit,
        EventKind::SkinExit => MarkKind::SkinExit,
        EventKind::Confirm => MarkKind::Confirm,
        EventKind::Coaching | EventKind::Fault | EventKind::Interrupted => return None,
    };
    let before = samples.partition_point(|s| s.t_s < event.t_s).saturating_sub(1);
    Some(Mark {
        kind,
        t_s: round(event.t_s),
        depth_mm: round(event.x_m * 1e3),
        force_n: round(event.force_n),
        axial_n: round(samples.get(before).map_or(event.force_n, Sample::axial_n)),
        name: event.text.clone(),
    })
}

fn stages(bands: &[Band], track: &DeepestTrack<'_>, tip_to_rim_mm: f64) -> Vec<StageSpan> {
    let mut spans = Vec::new();
    for (boundary, band) in bands.iter().enumerate() {
        stages_of(boundary, band.top_mm, track, tip_to_rim_mm, &mut spans);
    }
    spans
}

/// The stages of one boundary, each from where the one before ended. Stage II is empty where the rim already tents
/// when the tip breaks through, and II and III are absent on a needle without a rim.
fn stages_of(boundary: usize, top_mm: f64, track: &DeepestTrack<'_>, rim_mm: f64, spans: &mut Vec<StageSpan>) {
    let end_mm = track.deepest_mm;
    let tip_mm = track.opened_mm(EventKind::TipRupture, boundary);
    let rim_open_mm = track.opened_mm(EventKind::RimRupture, boundary);
    let single = rim_mm <= 0.0;
    let through_tip = tip_mm.unwrap_or(end_mm);
    let through_rim = if single { through_tip } else { rim_open_mm.unwrap_or(end_mm) };
    let rim_meets = (top_mm + rim_mm).clamp(through_tip, through_rim.max(through_tip));
    let mut add = |stage, from_mm: f64, to_mm: f64| {
        if to_mm > from_mm {
            spans.push(StageSpan { boundary, stage, from_mm: round(from_mm), to_mm: round(to_mm) });
        }
    };
    add(Stage::I, top_mm, through_tip.min(end_mm));
    if tip_mm.is_some() {
        add(Stage::II, through_tip, rim_meets.min(end_mm));
        add(Stage::III, rim_meets, through_rim.min(end_mm));
        add(Stage::IV, through_rim, end_mm);
    }
}

#[cfg(test)]
mod tests {
    //! A curve must keep what a trainee looks for: the peaks, the places of the ruptures and the stages between them.
    //! It could fail by dropping a peak while thinning, or by mixing two tracks.
    #![expect(clippy::float_cmp, reason = "the values are carried over, not computed")]

    use super::*;

    fn sample(t_s: f64, x_mm: f64, force_n: f32) -> Sample {
        Sample { t_s, x_m: x_mm * 1e-3, tip_n: force_n, orientation: [1.0, 0.0, 0.0, 0.0], ..Sample::default() }
    }

    fn rupture(kind: EventKind, boundary: u32, x_mm: f64) -> Event {
        Event {
            t_s: x_mm,
            kind,
            boundary: Some(boundary),
            x_m: x_mm * 1e-3,
            position_m: [0.0; 3],
            force_n: 1.0,
            dissipated_j: 0.0,
            track: None,
            structure: None,
            text: String::new(),
        }
    }

    #[test]
    fn a_boundary_passes_through_four_stages_without_gaps() {
        let (tip, rim) = (rupture(EventKind::TipRupture, 0, 3.0), rupture(EventKind::RimRupture, 0, 6.0));
        let track = DeepestTrack { ruptures: vec![&tip, &rim], deepest_mm: 20.0, cos_angle: 1.0 };
        let mut spans = Vec::new();
        stages_of(0, 0.0, &track, 4.0, &mut spans);
        let told: Vec<_> = spans.iter().map(|s| (s.stage, s.from_mm, s.to_mm)).collect();
        assert_eq!(told, [(Stage::I, 0.0, 3.0), (Stage::II, 3.0, 4.0), (Stage::III, 4.0, 6.0), (Stage::IV, 6.0, 20.0)]);
    }

    #[test]
    fn an_unopened_boundary_stays_in_stage_one_and_an_unreached_one_has_none() {
        let track = DeepestTrack { ruptures: vec![], deepest_mm: 2.0, cos_angle: 1.0 };
        let mut spans = Vec::new();
        stages_of(0, 0.0, &track, 2.0, &mut spans);
        stages_of(1, 5.0, &track, 2.0, &mut spans);
        assert_eq!(spans, [StageSpan { boundary: 0, stage: Stage::I, from_mm: 0.0, to_mm: 2.0 }]);
    }

    #[test]
    fn a_needle_without_a_rim_goes_from_the_first_stage_to_the_last() {
        let tip = rupture(EventKind::TipRupture, 0, 3.0);
        let track = DeepestTrack { ruptures: vec![&tip], deepest_mm: 9.0, cos_angle: 1.0 };
        let mut spans = Vec::new();
        stages_of(0, 0.0, &track, 0.0, &mut spans);
        assert_eq!(spans.iter().map(|s| s.stage).collect::<Vec<_>>(), [Stage::I, Stage::IV]);
    }

    #[test]
    fn a_needle_straight_down_has_cosine_one_and_a_broken_orientation_is_contained() {
        assert_eq!(cos_to_normal(&sample(0.0, 0.0, 0.0)), 1.0);
        let broken = Sample { orientation: [f64::NAN; 4], ..Sample::default() };
        assert_eq!(cos_to_normal(&broken), 1.0);
    }
}
