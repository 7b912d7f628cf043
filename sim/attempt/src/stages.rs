//! The stages of each boundary along the needle's path.

use recording::{Event, EventKind, Recording};
use serde::{Deserialize, Serialize};

use crate::insertion::deepest_insertion;
use crate::layers::LayerSpan;

/// Stage of a boundary, as named in the paper.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum BoundaryStage {
    /// The tip tents the boundary.
    I,
    /// The tip is through, the rim has not reached the boundary.
    II,
    /// The rim tents the boundary.
    III,
    /// The rim is through.
    IV,
}

impl BoundaryStage {
    /// All four, in order.
    pub const ALL: [Self; 4] = [Self::I, Self::II, Self::III, Self::IV];

    /// Returns the Roman numeral.
    #[must_use]
    pub fn numeral(self) -> &'static str {
        match self {
            Self::I => "I",
            Self::II => "II",
            Self::III => "III",
            Self::IV => "IV",
        }
    }

    /// Returns the name of the stage's class in drawings.
    #[must_use]
    pub fn class(self) -> &'static str {
        match self {
            Self::I => "one",
            Self::II => "two",
            Self::III => "three",
            Self::IV => "four",
        }
    }
}

/// A stage of a boundary over a section of the needle's path.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct StageSpan {
    /// The boundary, from 0: the upper face of that layer.
    pub boundary: usize,
    /// The stage.
    pub stage: BoundaryStage,
    /// Its beginning, in mm along the needle.
    pub from_mm: f64,
    /// Its end, in mm along the needle.
    pub to_mm: f64,
}

/// The deepest track, whose stages are reported.
struct DeepestTrack<'a> {
    ruptures: Vec<&'a Event>,
    deepest_mm: f64,
}

impl<'a> DeepestTrack<'a> {
    fn find(recording: &'a Recording) -> Self {
        let deepest = deepest_insertion(recording);
        let contacts = || recording.events.iter().filter(|e| e.kind == EventKind::Contact);
        let track = deepest.as_ref().map(|(insertion, _)| insertion.track);
        let of_track =
            |e: &&Event| contacts().rfind(|c| c.t_s <= e.t_s).map_or(Some(0), |c| c.track.or(Some(0))) == track;
        let ruptures = recording.events.iter().filter(|e| e.kind.contactor().is_some()).filter(of_track).collect();
        Self { ruptures, deepest_mm: deepest.map_or(0.0, |(_, x_m)| x_m * 1e3) }
    }

    /// Returns the advance at which the first rupture of a kind opened a boundary, in mm along the
    /// needle.
    fn opened_mm(&self, kind: EventKind, boundary: usize) -> Option<f64> {
        let opened = self.ruptures.iter().find(|e| e.kind == kind && e.boundary.map(|b| b as usize) == Some(boundary));
        opened.map(|e| e.x_m * 1e3)
    }
}

/// Returns the stages of every boundary along the deepest track.
pub(crate) fn span_stages(recording: &Recording, layers: &[LayerSpan], tip_to_rim_mm: f64) -> Vec<StageSpan> {
    let track = DeepestTrack::find(recording);
    let mut spans = Vec::new();
    for (boundary, layer) in layers.iter().enumerate() {
        span_boundary(boundary, layer.top_mm, &track, tip_to_rim_mm, &mut spans);
    }
    spans
}

/// Adds the stages of one boundary, each from the end of the one before. Stage II is empty if the
/// rim already tents when the tip breaks through, and II and III are absent on a needle without a
/// rim.
fn span_boundary(boundary: usize, top_mm: f64, track: &DeepestTrack<'_>, rim_mm: f64, spans: &mut Vec<StageSpan>) {
    let end_mm = track.deepest_mm;
    let tip_mm = track.opened_mm(EventKind::TipRupture, boundary);
    let rim_open_mm = track.opened_mm(EventKind::RimRupture, boundary);
    let single = rim_mm <= 0.0;
    let through_tip = tip_mm.unwrap_or(end_mm);
    let through_rim = if single { through_tip } else { rim_open_mm.unwrap_or(end_mm) };
    let rim_meets = (top_mm + rim_mm).clamp(through_tip, through_rim.max(through_tip));
    let mut add = |stage, from_mm: f64, to_mm: f64| {
        if to_mm > from_mm {
            spans.push(StageSpan { boundary, stage, from_mm, to_mm });
        }
    };
    add(BoundaryStage::I, top_mm, through_tip.min(end_mm));
    if tip_mm.is_some() {
        add(BoundaryStage::II, through_tip, rim_meets.min(end_mm));
        add(BoundaryStage::III, rim_meets, through_rim.min(end_mm));
        add(BoundaryStage::IV, through_rim, end_mm);
    }
}

#[cfg(test)]
mod tests {
    //! Fails if two tracks are mixed, or if there is a gap between stages.

    use super::*;

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
        let track = DeepestTrack { ruptures: vec![&tip, &rim], deepest_mm: 20.0 };
        let mut spans = Vec::new();
        span_boundary(0, 0.0, &track, 4.0, &mut spans);
        let told: Vec<_> = spans.iter().map(|s| (s.stage, s.from_mm, s.to_mm)).collect();
        assert_eq!(
            told,
            [
                (BoundaryStage::I, 0.0, 3.0),
                (BoundaryStage::II, 3.0, 4.0),
                (BoundaryStage::III, 4.0, 6.0),
                (BoundaryStage::IV, 6.0, 20.0)
            ]
        );
    }

    #[test]
    fn unopened_boundary_stays_in_stage_one_and_unreached_has_none() {
        let track = DeepestTrack { ruptures: vec![], deepest_mm: 2.0 };
        let mut spans = Vec::new();
        span_boundary(0, 0.0, &track, 2.0, &mut spans);
        span_boundary(1, 5.0, &track, 2.0, &mut spans);
        assert_eq!(spans, [StageSpan { boundary: 0, stage: BoundaryStage::I, from_mm: 0.0, to_mm: 2.0 }]);
    }

    #[test]
    fn a_needle_without_a_rim_goes_from_the_first_stage_to_the_last() {
        let tip = rupture(EventKind::TipRupture, 0, 3.0);
        let track = DeepestTrack { ruptures: vec![&tip], deepest_mm: 9.0 };
        let mut spans = Vec::new();
        span_boundary(0, 0.0, &track, 0.0, &mut spans);
        assert_eq!(spans.iter().map(|s| s.stage).collect::<Vec<_>>(), [BoundaryStage::I, BoundaryStage::IV]);
    }
}
