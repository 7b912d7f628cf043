//! Depth and aim: entry, depth, and distance from the target.

use recording::Contactor;

use super::MetricSheet;
use crate::attempt::{Attempt, Outcome};

pub(super) fn measure_depth(attempt: &Attempt, sheet: &mut MetricSheet) {
    sheet.put("depth_error_mm", depth_error_mm(attempt));
    sheet.put("overshoot_mm", overshoot_mm(attempt));
    sheet.put("tip_error_mm", tip_error_mm(attempt));
    sheet.put("entry_error_mm", entry_error_mm(attempt));
    sheet.put("angle_error_deg", angle_error_deg(attempt));
    sheet.put("skin_entries", skin_entries(attempt));
}

fn depth_error_mm(attempt: &Attempt) -> Outcome {
    Ok(attempt.confirmed()?.x_m * 1e3 - attempt.bundle.exercise.target_depth_mm)
}

fn overshoot_mm(attempt: &Attempt) -> Outcome {
    attempt.touched()?;
    let deepest_m = attempt.timeline.samples().iter().map(|s| s.x_m).fold(f64::NEG_INFINITY, f64::max);
    Ok((deepest_m * 1e3 - attempt.bundle.exercise.target_depth_mm).max(0.0))
}

fn tip_error_mm(attempt: &Attempt) -> Outcome {
    Ok((attempt.confirmed()?.tip_m - attempt.bundle.exercise.target_m()).norm() * 1e3)
}

fn entry_error_mm(attempt: &Attempt) -> Outcome {
    let insertion = attempt.insertion_at(attempt.confirmed()?.t_s)?;
    Ok((insertion.entry_m - attempt.bundle.exercise.entry_m()).norm() * 1e3)
}

fn angle_error_deg(attempt: &Attempt) -> Outcome {
    let axis = attempt.insertion_at(attempt.confirmed()?.t_s)?.axis;
    let planned = attempt.bundle.exercise.axis();
    // The arc tangent resolves small angles; the arc cosine loses half of its digits there.
    Ok(libm::atan2(axis.cross(&planned).norm(), axis.dot(&planned)).to_degrees())
}

/// The tip opens the first boundary once per track; re-entering an open track is not a new
/// puncture.
fn skin_entries(attempt: &Attempt) -> Outcome {
    attempt.touched()?;
    Ok(attempt.ruptures.iter().filter(|r| r.boundary == 0 && r.contactor == Contactor::Tip).count() as f64)
}
