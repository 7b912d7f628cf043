//! The experts' corridor: median and band of the experts' forces over the depth of an attempt,
//! aligned at the crossing of each layer.
//!
//! The thickness of layers differs between patients. Each section between two crossings is
//! therefore scaled to the corresponding section of the shown attempt, and forces are compared at
//! the same fraction of it.

use assessment::statistics::quantile;
use attempt::{AttemptCurve, MarkKind};

/// Text of the consent that the service proposes to an expert.
pub const WORDING: &str = "My own passed attempts may be part of the experts’ corridor, without my name, and only together with at least four \
     other experts. I can withdraw this consent at any time; from then on my attempts are excluded.";
/// Minimum number of experts to be shown: with fewer, an individual could be identified.
pub const FEWEST: usize = 5;
/// Fraction of the experts outside the band, on either side.
const OUTSIDE: f64 = 0.1;
/// Number of steps per section.
const STEPS: u32 = 16;

/// A point of the corridor.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CorridorPlace {
    /// Advance along the needle of the shown attempt, in mm.
    pub advance_mm: f64,
    /// 10th percentile of the experts' force, in N.
    pub low_n: f64,
    /// Median of the experts' force, in N.
    pub median_n: f64,
    /// 90th percentile of the experts' force, in N.
    pub high_n: f64,
}

/// The experts' corridor over an attempt.
#[derive(Clone, Debug, PartialEq)]
pub struct Corridor {
    /// Number of experts considered. A point may be based on fewer, but at least [`FEWEST`].
    pub experts: usize,
    /// Points, by depth.
    pub places: Vec<CorridorPlace>,
}

/// The insertion: crossings of the boundaries, and force.
struct NeedleWay {
    /// Depths of the first contact, of the rupture of each boundary by the tip, and of the turning
    /// point, in mm.
    crossings: Vec<f64>,
    /// Depth in mm and force in N, in order of time.
    points: Vec<(f64, f64)>,
}

impl NeedleWay {
    fn of(curve: &AttemptCurve) -> Self {
        let deepest = curve.points.iter().enumerate().max_by(|a, b| a.1.advance_mm.total_cmp(&b.1.advance_mm));
        let end = deepest.map_or(0, |(index, _)| index + 1);
        let opened = |name: &str| {
            let tip = curve.marks.iter().find(|mark| mark.kind == MarkKind::TipRupture && mark.name == name);
            tip.map(|mark| mark.advance_mm)
        };
        let mut crossings = vec![0.0];
        crossings.extend(curve.bands.iter().map_while(|band| opened(&band.name)));
        crossings.extend(deepest.map(|(_, point)| point.advance_mm));
        let points = curve.points[..end].iter().map(|point| (point.advance_mm, point.force_n)).collect();
        Self { crossings, points }
    }

    /// Returns the section from one crossing to the next. The last section ends at the turning
    /// point and is comparable only between insertions that crossed the same number of boundaries.
    fn stretch(&self, index: usize, of: usize) -> Option<(f64, f64)> {
        let last = index + 2 == of;
        let comparable = if last { self.crossings.len() == of } else { self.crossings.len() > index + 2 };
        let stretch = (*self.crossings.get(index)?, *self.crossings.get(index + 1)?);
        (comparable && stretch.0 < stretch.1).then_some(stretch)
    }

    /// Returns the force in N when the tip first reached a depth.
    fn force_n(&self, advance_mm: f64) -> Option<f64> {
        let at = self.points.iter().position(|(depth, _)| *depth >= advance_mm)?;
        let (to, force_n) = self.points[at];
        let Some(&(from, before_n)) = at.checked_sub(1).map(|before| &self.points[before]) else {
            return Some(force_n);
        };
        let share = if to > from { (advance_mm - from) / (to - from) } else { 1.0 };
        Some(before_n + share * (force_n - before_n))
    }
}

/// Returns the corridor over an attempt, from one curve per expert. `None` if fewer than [`FEWEST`]
/// are comparable.
#[must_use]
pub fn corridor(shown: &AttemptCurve, experts: &[AttemptCurve]) -> Option<Corridor> {
    let shown = NeedleWay::of(shown);
    let experts: Vec<NeedleWay> = experts.iter().map(NeedleWay::of).collect();
    let crossings = shown.crossings.len();
    let mut places = Vec::new();
    for index in 0..crossings.saturating_sub(1) {
        let Some((from, to)) = shown.stretch(index, crossings) else { break };
        for step in 0..=STEPS {
            let share = f64::from(step) / f64::from(STEPS);
            let force =
                |way: &NeedleWay| way.stretch(index, crossings).and_then(|(a, b)| way.force_n(a + share * (b - a)));
            let forces: Vec<f64> = experts.iter().filter_map(force).collect();
            places.extend(place(from + share * (to - from), &forces));
        }
    }
    (!places.is_empty()).then_some(Corridor { experts: experts.len(), places })
}

fn place(advance_mm: f64, forces_n: &[f64]) -> Option<CorridorPlace> {
    if forces_n.len() < FEWEST {
        return None;
    }
    let at = |share| quantile(forces_n, share).ok();
    Some(CorridorPlace { advance_mm, low_n: at(OUTSIDE)?, median_n: at(0.5)?, high_n: at(1.0 - OUTSIDE)? })
}

#[cfg(test)]
mod tests {
    //! Checks that fewer than five experts are not shown, and that layers of different thickness
    //! are not compared at equal depth.
    use attempt::{CurveMark, CurvePoint, LayerSpan};

    use super::*;

    /// The force rises to `peak_n` at a boundary that ruptures at `at_mm`, then is 1 N down to
    /// `end_mm`.
    fn curve(at_mm: f64, peak_n: f64, end_mm: f64) -> AttemptCurve {
        let band = LayerSpan { name: "skin".into(), texture: "skin".into(), top_mm: 0.0, bottom_mm: 50.0 };
        let force = |mm: f64| if mm <= at_mm { peak_n * mm / at_mm } else { 1.0 };
        let point = |i: u32| {
            let advance_mm = f64::from(i) * end_mm / 400.0;
            CurvePoint { t_s: f64::from(i), advance_mm, force_n: force(advance_mm) }
        };
        let mark =
            CurveMark { kind: MarkKind::TipRupture, t_s: 1.0, advance_mm: at_mm, axial_n: peak_n, name: "skin".into() };
        AttemptCurve {
            bands: vec![band],
            points: (0..=400).map(point).collect(),
            marks: vec![mark],
            stages: vec![],
            target_depth_mm: end_mm,
            duration_s: 1.0,
        }
    }

    #[test]
    fn four_experts_are_not_shown_and_five_are() {
        let shown = curve(4.0, 2.0, 20.0);
        let experts: Vec<AttemptCurve> = (0..5).map(|i| curve(2.0 + f64::from(i), 3.0, 18.0)).collect();
        assert_eq!(corridor(&shown, &experts[..4]), None);
        let made = corridor(&shown, &experts).expect("five are enough");
        assert_eq!(made.experts, 5);
    }

    #[test]
    fn peaks_are_compared_where_the_layer_opens_whatever_its_depth() {
        let shown = curve(10.0, 2.0, 20.0);
        let experts: Vec<AttemptCurve> = (0..9).map(|i| curve(2.0 + f64::from(i), 3.0, 30.0)).collect();
        let made = corridor(&shown, &experts).expect("nine are enough");
        let half = made.places.iter().find(|place| (place.advance_mm - 5.0).abs() < 1e-9).expect("half of the way");
        assert!((half.median_n - 1.5).abs() < 0.05 && half.high_n - half.low_n < 0.1, "{half:?}");
        let deep = made.places.last().expect("a last place");
        assert!((deep.advance_mm - 20.0).abs() < 1e-9 && (deep.median_n - 1.0).abs() < 1e-9, "{deep:?}");
    }

    #[test]
    fn an_attempt_that_never_touched_has_no_corridor() {
        let mut shown = curve(10.0, 2.0, 20.0);
        (shown.points, shown.marks) = (vec![], vec![]);
        let experts: Vec<AttemptCurve> = (0..9).map(|_| curve(5.0, 3.0, 30.0)).collect();
        assert_eq!(corridor(&shown, &experts), None);
    }
}
