//! Finds the time at which a metric was decided, where a replay opens from a lost point, and
//! describes an attempt at a time.

use assessment::Metric;
use attempt::{AttemptCurve, CurveMark, MarkKind};

use crate::{anatomy, format};

/// Returns the time, in s, that decided a metric. A metric of the attempt as a whole gets the first
/// contact of the needle with the skin.
#[must_use]
pub fn find_deciding_second(id: &str, metrics: &[Metric], curve: &AttemptCurve) -> f64 {
    let (base, part) = id.split_once('.').unwrap_or((id, ""));
    let found = match base {
        "depth_error_mm" | "tip_error_mm" | "confirmed" => last_of(curve, MarkKind::Confirm).or(deepest_second(curve)),
        "overshoot_mm" => deepest_second(curve),
        "entry_error_mm" | "angle_error_deg" | "skin_entries" => last_of(curve, MarkKind::Contact),
        "peak_force_n" => second_of_peak(curve, |_| true),
        "peak_force_layer_n" => second_in_layer(curve, part),
        "max_lateral_force_n" => layer_stretch(curve, part).map(|(from_s, _)| from_s),
        "rupture_force_n" | "over_insertion_mm" | "stop_time_s" => second_of_pop(base, part, metrics, curve),
        "reached" => first_through(curve, part, MarkKind::TipRupture).or(deepest_second(curve)),
        "rupture_energy_mj" | "cutting_energy_mj" | "friction_energy_mj" | "lateral_work_mj" => {
            layer_stretch(curve, part).map(|(from_s, _)| from_s)
        }
        "structure_hits" | "structure_clearance_mm" => {
            first_of(curve, MarkKind::StructureHit).or(deepest_second(curve))
        }
        "withdrawn" => last_of(curve, MarkKind::SkinExit).or(Some(curve.duration_s)),
        _ => None,
    };
    found.or(first_of(curve, MarkKind::Contact)).unwrap_or(0.0)
}

fn first_of(curve: &AttemptCurve, kind: MarkKind) -> Option<f64> {
    curve.marks.iter().find(|mark| mark.kind == kind).map(|mark| mark.t_s)
}

fn last_of(curve: &AttemptCurve, kind: MarkKind) -> Option<f64> {
    curve.marks.iter().rfind(|mark| mark.kind == kind).map(|mark| mark.t_s)
}

fn first_through(curve: &AttemptCurve, layer: &str, kind: MarkKind) -> Option<f64> {
    curve.marks.iter().find(|mark| mark.kind == kind && mark.name == layer).map(|mark| mark.t_s)
}

fn deepest_second(curve: &AttemptCurve) -> Option<f64> {
    curve.points.iter().max_by(|a, b| a.advance_mm.total_cmp(&b.advance_mm)).map(|point| point.t_s)
}

fn second_of_peak(curve: &AttemptCurve, within: impl Fn(f64) -> bool) -> Option<f64> {
    let points = curve.points.iter().filter(|point| within(point.t_s));
    points.max_by(|a, b| a.force_n.total_cmp(&b.force_n)).map(|point| point.t_s)
}

/// Returns the time span from the tip's first pressure on a layer to the rupture of the next one,
/// or to the end.
fn layer_stretch(curve: &AttemptCurve, layer: &str) -> Option<(f64, f64)> {
    let index = curve.bands.iter().position(|band| band.name == layer)?;
    let above = index.checked_sub(1).and_then(|above| curve.bands.get(above));
    let from_s = match above {
        Some(above) => first_through(curve, &above.name, MarkKind::TipRupture),
        None => first_of(curve, MarkKind::Contact),
    }?;
    let next = curve.bands.get(index + 1);
    let to_s = next.and_then(|next| first_through(curve, &next.name, MarkKind::TipRupture));
    Some((from_s, to_s.unwrap_or(curve.duration_s)))
}

fn second_in_layer(curve: &AttemptCurve, layer: &str) -> Option<f64> {
    let (from_s, to_s) = layer_stretch(curve, layer)?;
    second_of_peak(curve, |t_s| (from_s..=to_s).contains(&t_s))
}

/// Returns the time of the pop that a metric belongs to; for an unsplit metric, of the pop with the
/// largest split value.
fn second_of_pop(base: &str, part: &str, metrics: &[Metric], curve: &AttemptCurve) -> Option<f64> {
    let split = |metric: &&Metric| metric.id.strip_prefix(base).is_some_and(|rest| rest.starts_with('.'));
    let part = match part {
        "" => {
            let largest = metrics.iter().filter(split).filter(|metric| metric.value.is_some());
            let largest = largest.max_by(|a, b| a.value.unwrap_or(0.0).total_cmp(&b.value.unwrap_or(0.0)));
            largest?.id.split_once('.')?.1
        }
        part => part,
    };
    let (layer, contactor) = part.rsplit_once('.')?;
    let kind = if contactor == "rim" { MarkKind::RimRupture } else { MarkKind::TipRupture };
    first_through(curve, layer, kind)
}

/// Describes an attempt at a time: depth, force, layer and the latest event.
#[must_use]
pub fn say_moment(curve: &AttemptCurve, t_s: f64) -> String {
    let after = curve.points.iter().position(|point| point.t_s >= t_s);
    let Some(point) = after.and_then(|at| curve.points.get(at)).or(curve.points.last()) else {
        return tr!("Nothing was recorded.").to_owned();
    };
    let layer = curve.bands.iter().find(|band| (band.top_mm..band.bottom_mm).contains(&point.advance_mm));
    let place = layer.map_or_else(|| tr!("above the skin").to_owned(), |band| anatomy::say_structure(&band.name));
    let stands = tr!(
        "{depth} deep ({place}), force {force}.",
        depth = format::format_quantity(point.advance_mm, "mm"),
        place = place,
        force = format::format_quantity(point.force_n, "N")
    );
    let said = |mark: &CurveMark| {
        let what = format::as_sentence(&anatomy::say_event(mark.kind, &anatomy::say_structure(&mark.name)));
        tr!("{what}, {ago} before.", what = what, ago = format::format_span(t_s - mark.t_s))
    };
    // Addresses round times to 0.01 s, so an event may be up to 5 ms later than the time given.
    let last = curve.marks.iter().rfind(|mark| mark.t_s <= t_s + 0.005);
    last.map_or(stands.clone(), |mark| format!("{stands} {}", said(mark)))
}

#[cfg(test)]
mod tests {
    //! A lost point must lead to the time that decided it.

    use super::*;
    use crate::samples;

    fn second(id: &str) -> f64 {
        find_deciding_second(id, &samples::metrics(), &samples::curve())
    }

    fn mark(kind: MarkKind, layer: &str) -> f64 {
        first_through(&samples::curve(), layer, kind).expect("a mark")
    }

    #[test]
    fn each_metric_leads_to_its_own_second() {
        let near = |found: f64, wanted: f64| assert!((found - wanted).abs() < 1e-9, "{found} is not {wanted}");
        near(second("depth_error_mm"), 19.0);
        near(second("over_insertion_mm.fat.rim"), mark(MarkKind::RimRupture, "fat"));
        near(second("reached.muscle"), mark(MarkKind::TipRupture, "muscle"));
        near(second("entry_error_mm"), mark(MarkKind::Contact, "skin"));
        near(second("path_length_mm"), mark(MarkKind::Contact, "skin"));
        near(second("withdrawn"), 26.0);
        let peak = second("peak_force_n");
        let curve = samples::curve();
        let highest = curve.points.iter().map(|point| point.force_n).fold(0.0, f64::max);
        let there = curve.points.iter().find(|point| (point.t_s - peak).abs() < 1e-9).expect("a point");
        near(there.force_n, highest);
        let in_skin = second("peak_force_layer_n.skin");
        assert!(in_skin <= mark(MarkKind::TipRupture, "fat"), "{in_skin}");
    }

    #[test]
    fn the_largest_pop_is_found_by_its_split_value() {
        let mut metrics = samples::metrics();
        let wanted = [("over_insertion_mm.skin.tip", 0.4), ("over_insertion_mm.muscle.tip", 1.6)];
        metrics.extend(wanted.map(|(id, value)| samples::metric(id, Some(value))));
        let found = find_deciding_second("over_insertion_mm", &metrics, &samples::curve());
        assert!((found - mark(MarkKind::TipRupture, "muscle")).abs() < 1e-9, "{found}");
    }

    #[test]
    fn an_attempt_without_anything_begins_at_its_beginning() {
        let empty = AttemptCurve { points: vec![], marks: vec![], ..samples::curve() };
        assert!(find_deciding_second("depth_error_mm", &[], &empty).abs() < 1e-9);
        assert_eq!(say_moment(&empty, 3.0), "Nothing was recorded.");
    }

    #[test]
    fn a_moment_is_said_in_words() {
        let said = say_moment(&samples::curve(), 19.5);
        assert!(
            said.contains("21.9\u{a0}mm deep (muscle)") && said.contains("Position confirmed, 0.5\u{a0}s"),
            "{said}"
        );
    }
}
