//! Comparison of an attempt with experts, layer by layer: speed, force, and advance after the pop;
//! and the experts' median motion, from layer to layer, for drawing a ghost needle.

use assessment::statistics::quantile;
use attempt::{AttemptCurve, MarkKind};
use serde::Serialize;

use crate::scoring::corridor::FEWEST;

/// Fraction of the experts outside the band, on either side.
const OUTSIDE: f64 = 0.1;
/// Time after a pop in which the advance is measured, in s; the same as for the metric.
const AFTER_POP_S: f64 = 1.0;
/// Values within this distance of the band do not count as departures, as a fraction of the median.
const CLOSE: f64 = 0.1;
/// Number of steps per section of the median motion.
const STEPS: u32 = 24;

/// Quantity compared in a layer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Compared {
    /// Mean speed through the layer, in mm/s.
    Speed,
    /// Advance of the needle in the second after the tip broke through, in mm.
    AfterPop,
    /// Maximum force on the way through the layer, in N.
    Peak,
}

impl Compared {
    /// All quantities.
    pub const ALL: [Self; 3] = [Self::Speed, Self::AfterPop, Self::Peak];
}

/// A value in comparison with the experts' band.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BesideBand {
    /// Quantity.
    pub what: Compared,
    /// Value of this attempt.
    pub own: f64,
    /// 10th percentile of the experts.
    pub low: f64,
    /// Median of the experts.
    pub median: f64,
    /// 90th percentile of the experts.
    pub high: f64,
}

impl BesideBand {
    /// Returns the side on which the value departs from the band, if it does.
    #[must_use]
    pub fn departs(&self) -> Option<Departure> {
        let close = CLOSE * self.median.abs();
        match self.own {
            own if own > self.high + close => Some(Departure::Above),
            own if own < self.low - close => Some(Departure::Below),
            _ => None,
        }
    }
}

/// Side on which a value departs from the experts' band.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Departure {
    /// Above the band.
    Above,
    /// Below the band.
    Below,
}

/// Comparison of one layer with the experts.
#[derive(Clone, Debug, PartialEq)]
pub struct LayerBeside {
    /// Name of the layer.
    pub layer: String,
    /// Time at which the tip entered it, in s.
    pub from_s: f64,
    /// Quantities that could be compared.
    pub values: Vec<BesideBand>,
}

/// The insertion, by time.
struct TimedWay<'a> {
    /// Times and depths of the first contact, of the tip's entry into each layer, and of the
    /// turning point.
    crossings: Vec<Crossing>,
    curve: &'a AttemptCurve,
}

#[derive(Clone, Copy)]
struct Crossing {
    t_s: f64,
    advance_mm: f64,
}

impl<'a> TimedWay<'a> {
    fn of(curve: &'a AttemptCurve) -> Self {
        let mark = |kind: MarkKind, name: Option<&str>| {
            let found = curve.marks.iter().find(|mark| mark.kind == kind && name.is_none_or(|name| mark.name == name));
            found.map(|mark| Crossing { t_s: mark.t_s, advance_mm: mark.advance_mm })
        };
        let mut crossings: Vec<Crossing> = mark(MarkKind::Contact, None).into_iter().collect();
        if !crossings.is_empty() {
            crossings.extend(curve.bands.iter().map_while(|band| mark(MarkKind::TipRupture, Some(&band.name))));
        }
        let deepest = curve.points.iter().max_by(|a, b| a.advance_mm.total_cmp(&b.advance_mm));
        crossings.extend(deepest.map(|point| Crossing { t_s: point.t_s, advance_mm: point.advance_mm }));
        Self { crossings, curve }
    }

    /// Returns the section from one crossing to the next. The last section is comparable only
    /// between insertions that crossed the same number of boundaries.
    fn stretch(&self, index: usize, of: usize) -> Option<(Crossing, Crossing)> {
        let last = index + 2 == of;
        let comparable = if last { self.crossings.len() == of } else { self.crossings.len() > index + 2 };
        let (from, to) = (*self.crossings.get(index)?, *self.crossings.get(index + 1)?);
        (comparable && from.t_s < to.t_s && from.advance_mm < to.advance_mm).then_some((from, to))
    }

    /// Returns advance in mm and force in N at a time, by linear interpolation.
    fn at(&self, t_s: f64) -> Option<(f64, f64)> {
        let points = &self.curve.points;
        let after = points.partition_point(|point| point.t_s < t_s).min(points.len().checked_sub(1)?);
        let (from, to) = (points[after.saturating_sub(1)], points[after]);
        let share = if to.t_s > from.t_s { ((t_s - from.t_s) / (to.t_s - from.t_s)).clamp(0.0, 1.0) } else { 1.0 };
        let between = |a: f64, b: f64| a + share * (b - a);
        Some((between(from.advance_mm, to.advance_mm), between(from.force_n, to.force_n)))
    }

    fn value(&self, what: Compared, index: usize, of: usize) -> Option<f64> {
        let (from, to) = self.stretch(index, of)?;
        let within =
            |until_s: f64| self.curve.points.iter().filter(move |point| point.t_s >= from.t_s && point.t_s <= until_s);
        match what {
            Compared::Speed => Some((to.advance_mm - from.advance_mm) / (to.t_s - from.t_s)),
            Compared::AfterPop => {
                let farthest = within(from.t_s + AFTER_POP_S).map(|point| point.advance_mm);
                farthest.reduce(f64::max).map(|mm| (mm - from.advance_mm).max(0.0))
            }
            Compared::Peak => within(to.t_s).map(|point| point.force_n).reduce(f64::max),
        }
    }
}

/// Compares each layer that the tip entered with at least five experts who came as far. Empty if
/// there are fewer.
#[must_use]
pub fn compare_by_layer(shown: &AttemptCurve, experts: &[AttemptCurve]) -> Vec<LayerBeside> {
    let own = TimedWay::of(shown);
    let experts: Vec<TimedWay<'_>> = experts.iter().map(TimedWay::of).collect();
    let of = own.crossings.len();
    let beside = |index: usize, what: Compared| {
        let values: Vec<f64> = experts.iter().filter_map(|way| way.value(what, index, of)).collect();
        if values.len() < FEWEST {
            return None;
        }
        let at = |share| quantile(&values, share).ok();
        let (low, median, high) = (at(OUTSIDE)?, at(0.5)?, at(1.0 - OUTSIDE)?);
        Some(BesideBand { what, own: own.value(what, index, of)?, low, median, high })
    };
    // The first section ends at the skin; the others begin in a layer.
    let layers = shown.bands.iter().enumerate().take(of.saturating_sub(2));
    let made = layers.map(|(layer, band)| LayerBeside {
        layer: band.name.clone(),
        from_s: own.crossings[layer + 1].t_s,
        values: Compared::ALL.into_iter().filter_map(|what| beside(layer + 1, what)).collect(),
    });
    made.filter(|layer| !layer.values.is_empty()).collect()
}

/// An attempt that went farther than the experts, from the last boundary that they crossed, too.
#[derive(Clone, Debug, PartialEq)]
pub struct Overreach {
    /// The layer into which that boundary leads.
    pub layer: String,
    /// The layer in which the needle turned back, where it is another.
    pub deeper: Option<String>,
    /// When it went beyond nearly all of them, in s.
    pub from_s: f64,
    /// How far it went on from the boundary, in mm.
    pub own_mm: f64,
    /// A tenth of the experts turned back before, in mm from the boundary.
    pub low_mm: f64,
    /// A tenth of them turned back after.
    pub high_mm: f64,
}

/// How far an attempt went beyond where at least five experts turned back; nothing where it did not.
#[must_use]
pub fn find_overreach(shown: &AttemptCurve, experts: &[AttemptCurve]) -> Option<Overreach> {
    let own = TimedWay::of(shown);
    let experts: Vec<TimedWay<'_>> = experts.iter().map(TimedWay::of).collect();
    // The first crossing is the touch of the skin, and the last is where it turned back.
    let boundaries = 1..own.crossings.len().checked_sub(1)?;
    let crossed = |at: usize| experts.iter().filter(move |way| way.crossings.len() > at + 1);
    let at = boundaries.rev().find(|at| crossed(*at).count() >= FEWEST)?;
    let beyond = |way: &TimedWay<'_>| Some(way.crossings.last()?.advance_mm - way.crossings[at].advance_mm);
    let theirs: Vec<f64> = crossed(at).filter_map(beyond).collect();
    let (low_mm, high_mm) = (quantile(&theirs, OUTSIDE).ok()?, quantile(&theirs, 1.0 - OUTSIDE).ok()?);
    let own_mm = beyond(&own)?;
    let passed_mm = own.crossings[at].advance_mm + high_mm;
    let point = shown.points.iter().find(|point| point.advance_mm > passed_mm)?;
    let name = |band: usize| shown.bands.get(band).map(|band| band.name.clone());
    let deepest = own.crossings.len() - 3;
    let deeper = if deepest >= at { name(deepest) } else { None };
    let found = Overreach { layer: name(at - 1)?, deeper, from_s: point.t_s, own_mm, low_mm, high_mm };
    (own_mm > high_mm * (1.0 + CLOSE)).then_some(found)
}

/// The experts' median from a crossing of this attempt to the next.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct GhostStretch {
    /// Start time in this attempt, in s.
    pub from_s: f64,
    /// Time since the start in s, advance in mm within this attempt's layers, force in N.
    pub places: Vec<(f64, f64, f64)>,
}

/// Returns the experts' median motion, synchronized with this attempt at each layer. Empty if fewer
/// than five experts came as far.
#[must_use]
pub fn median_way(shown: &AttemptCurve, experts: &[AttemptCurve]) -> Vec<GhostStretch> {
    let own = TimedWay::of(shown);
    let experts: Vec<TimedWay<'_>> = experts.iter().map(TimedWay::of).collect();
    let of = own.crossings.len();
    let stretches = (0..of.saturating_sub(1)).map_while(|index| {
        let (from, to) = own.stretch(index, of)?;
        let ways: Vec<_> = experts.iter().filter_map(|way| Some((way, way.stretch(index, of)?))).collect();
        if ways.len() < FEWEST {
            return None;
        }
        let durations: Vec<f64> = ways.iter().map(|(_, (from, to))| to.t_s - from.t_s).collect();
        let lasts_s = quantile(&durations, 0.5).ok()?;
        let place = |step: u32| {
            let after_s = lasts_s * f64::from(step) / f64::from(STEPS);
            let found = ways.iter().filter_map(|(way, (begins, ends))| {
                let (advance_mm, force_n) = way.at((begins.t_s + after_s).min(ends.t_s))?;
                let share = (advance_mm - begins.advance_mm) / (ends.advance_mm - begins.advance_mm);
                Some((from.advance_mm + share.clamp(0.0, 1.0) * (to.advance_mm - from.advance_mm), force_n))
            });
            let (advances, forces): (Vec<f64>, Vec<f64>) = found.unzip();
            let round = |value: f64| (value * 1e3).round() / 1e3;
            Some((round(after_s), round(quantile(&advances, 0.5).ok()?), round(quantile(&forces, 0.5).ok()?)))
        };
        Some(GhostStretch { from_s: from.t_s, places: (0..=STEPS).filter_map(place).collect() })
    });
    stretches.collect()
}

#[cfg(test)]
mod tests {
    //! Checks that fewer than five experts are not shown, that layers of different thickness are
    //! not compared at equal depth, and that departures are detected.
    use attempt::{CurveMark, CurvePoint, LayerSpan};

    use super::*;

    /// An insertion at constant speed through skin at once, through fat of the given thickness, and
    /// 2 mm into the muscle.
    fn curve(fat_mm: f64, speed_mm_per_s: f64) -> AttemptCurve {
        let band =
            |name: &str, top_mm, bottom_mm| LayerSpan { name: name.into(), texture: name.into(), top_mm, bottom_mm };
        let lasts_s = (fat_mm + 2.0) / speed_mm_per_s;
        let point = |i: u32| {
            let t_s = lasts_s * f64::from(i) / 200.0;
            CurvePoint { t_s, advance_mm: t_s * speed_mm_per_s, force_n: 0.1 * speed_mm_per_s }
        };
        let mark = |kind, name: &str, advance_mm: f64| CurveMark {
            kind,
            t_s: advance_mm / speed_mm_per_s,
            advance_mm,
            axial_n: 1.0,
            name: name.into(),
        };
        AttemptCurve {
            bands: vec![band("fat", 0.0, fat_mm), band("muscle", fat_mm, 60.0)],
            points: (0..=200).map(point).collect(),
            marks: vec![
                mark(MarkKind::Contact, "fat", 0.0),
                mark(MarkKind::TipRupture, "fat", 0.5),
                mark(MarkKind::TipRupture, "muscle", fat_mm),
            ],
            stages: vec![],
            target_depth_mm: fat_mm + 2.0,
            duration_s: lasts_s,
        }
    }

    fn experts(count: u32) -> Vec<AttemptCurve> {
        (0..count).map(|i| curve(20.0 + f64::from(i), 4.0 + 0.1 * f64::from(i))).collect()
    }

    #[test]
    fn four_experts_are_not_shown_and_five_are() {
        let shown = curve(10.0, 4.0);
        assert!(compare_by_layer(&shown, &experts(4)).is_empty() && median_way(&shown, &experts(4)).is_empty());
        let layers = compare_by_layer(&shown, &experts(5));
        assert_eq!(layers.iter().map(|layer| layer.layer.as_str()).collect::<Vec<_>>(), ["fat", "muscle"]);
    }

    #[test]
    fn who_goes_faster_departs_and_who_goes_alike_does_not() {
        let speed = |own: f64| {
            let layers = compare_by_layer(&curve(10.0, own), &experts(5));
            layers[0].values.iter().find(|value| value.what == Compared::Speed).expect("a speed").departs()
        };
        assert_eq!([speed(4.2), speed(12.0), speed(1.0)], [None, Some(Departure::Above), Some(Departure::Below)]);
    }

    #[test]
    fn the_median_way_is_stretched_to_the_layers_that_are_shown() {
        let shown = curve(10.0, 8.0);
        let way = median_way(&shown, &experts(5));
        assert_eq!(way.len(), 3, "to the skin's opening, through fat, into muscle");
        let fat = &way[1];
        let (first, last) = (fat.places[0], fat.places[STEPS as usize]);
        assert!((first.1 - 0.5).abs() < 0.1 && (last.1 - 10.0).abs() < 0.3, "{fat:?}");
        assert!(last.0 > 4.0, "at the experts' own pace: {last:?}");
        assert!((fat.from_s - 0.5 / 8.0).abs() < 1e-6);
    }

    #[test]
    fn going_on_where_the_experts_turned_back_is_found() {
        let shown = curve(10.0, 4.0);
        assert_eq!(find_overreach(&shown, &experts(5)), None, "as far into the muscle as they");
        let short = |_: u32| {
            let mut expert = curve(20.0, 4.0);
            expert.points.retain(|point| point.advance_mm < 8.0);
            expert.marks.pop();
            expert
        };
        let experts: Vec<AttemptCurve> = (0..5).map(short).collect();
        let found = find_overreach(&shown, &experts).expect("through the fat, in which they stopped");
        assert_eq!((found.layer.as_str(), found.deeper.as_deref()), ("fat", Some("muscle")));
        assert!((found.own_mm - 11.5).abs() < 0.2 && (found.high_mm - 7.4).abs() < 0.2, "{found:?}");
        assert!((found.from_s - 2.0).abs() < 0.1, "{found:?}");
        assert_eq!(find_overreach(&shown, &experts[..4]), None, "four experts are not shown");
    }

    #[test]
    fn an_attempt_that_never_touched_has_nothing_beside_it() {
        let untouched = AttemptCurve { points: vec![], marks: vec![], ..curve(10.0, 4.0) };
        assert!(compare_by_layer(&untouched, &experts(5)).is_empty() && median_way(&untouched, &experts(5)).is_empty());
        assert_eq!(find_overreach(&untouched, &experts(5)), None);
    }
}
