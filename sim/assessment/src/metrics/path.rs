//! The path of the tip and the shaft.

use law::Skin;
use nalgebra::{Point3, Vector3};

use super::MetricSheet;
use crate::absent::Absent;
use crate::attempt::{Attempt, Outcome};
use crate::motion::TipMotion;
use crate::signal::RATE_HZ;
use crate::sparc::{SPARC_HZ, spectral_arc_length};

/// Smallest turn that counts as a change of direction, in rad.
const REDIRECTED_RAD: f64 = 5.0 * std::f64::consts::PI / 180.0;

/// Angular speed below which a direction counts as held, in rad/s.
const HELD_RAD_PER_S: f64 = 5.0 * std::f64::consts::PI / 180.0;

pub(super) fn measure_path(attempt: &Attempt, sheet: &mut MetricSheet) {
    let (motion, intent) = (attempt.motion(), attempt.intent());
    sheet.put("path_length_mm", motion.map(|motion| path_length_mm(motion, |_| true)));
    sheet.put_anew("path_length_mm", intent.map(|intent| path_length_mm(intent, |_| true)));
    let inside =
        |of: Result<&TipMotion, Absent>, metric: &dyn Fn(&TipMotion) -> f64| attempt.inside().and(of.map(metric));
    sheet.put("path_in_tissue_mm", inside(motion, &path_in_tissue_mm));
    sheet.put_anew("path_in_tissue_mm", inside(intent, &path_in_tissue_mm));
    sheet.put("axis_travel_mm", motion.map(axis_travel_mm));
    sheet.put_anew("axis_travel_mm", intent.map(axis_travel_mm));
    sheet.put("sweep_area_mm2", inside(motion, &|motion| sweep_area_mm2(&attempt.bundle.scene.skin_shape, motion)));
    sheet.put("redirections", inside(motion, &redirections));
    sheet.put("path_deviation_sd_mm", path_deviation_sd_mm(attempt));
    sheet.put("smoothness_ldlj", smoothness_ldlj(attempt));
    sheet.put("smoothness_sparc", smoothness_sparc(attempt));
}

/// Returns whether both ends of the step to grid point `k` are in tissue.
fn step_inside(motion: &TipMotion, k: usize) -> bool {
    motion.inside[k - 1] && motion.inside[k]
}

fn path_length_mm(motion: &TipMotion, counts: impl Fn(usize) -> bool) -> f64 {
    let step = |k: usize| (motion.position(k) - motion.position(k - 1)).norm();
    (1..motion.len()).filter(|k| counts(*k)).map(step).sum::<f64>() * 1e3
}

fn path_in_tissue_mm(motion: &TipMotion) -> f64 {
    path_length_mm(motion, |k| step_inside(motion, k))
}

fn axis_travel_mm(motion: &TipMotion) -> f64 {
    let step = |k: usize| (motion.position(k) - motion.position(k - 1)).dot(&motion.axis(k)).abs();
    (1..motion.len()).map(step).sum::<f64>() * 1e3
}

fn sweep_area_mm2(skin: &Skin, motion: &TipMotion) -> f64 {
    let shaft_at = |k: usize| shaft_in_body(skin, motion.position(k), &motion.axis(k));
    let swept = |k: usize| {
        let ((entry, tip), (next_entry, next_tip)) = (shaft_at(k - 1), shaft_at(k));
        triangle_area_m2(entry, tip, next_tip) + triangle_area_m2(entry, next_tip, next_entry)
    };
    (1..motion.len()).filter(|k| step_inside(motion, *k)).map(swept).sum::<f64>() * 1e6
}

/// Returns the shaft inside the body: from its intersection with the skin to the tip.
///
/// It moves with the needle, while the entry that the simulation latched does not: a needle shifted
/// sideways sweeps a rectangle. Returns only the tip outside the body, and for a shaft that is too
/// nearly parallel to the skin to have a well-defined intersection.
fn shaft_in_body(skin: &Skin, tip_m: Point3<f64>, axis: &Vector3<f64>) -> (Point3<f64>, Point3<f64>) {
    let steep = axis.dot(&skin.outward(&tip_m)) < -0.05;
    let way_m = match skin {
        Skin::Flat => tip_m.z / axis.z,
        Skin::Sphere { .. } | Skin::Cylinder { .. } => skin.displacement_m(&tip_m, axis),
    };
    let entry_m = if skin.height_m(&tip_m) < 0.0 && steep { tip_m - axis * way_m } else { tip_m };
    (entry_m, tip_m)
}

fn triangle_area_m2(a: Point3<f64>, b: Point3<f64>, c: Point3<f64>) -> f64 {
    (b - a).cross(&(c - a)).norm() / 2.0
}

/// Counts how often the axis leaves the held direction; the next direction is the one in which it
/// is held again.
fn redirections(motion: &TipMotion) -> f64 {
    let turning_rad_per_s = motion.turning_rad_per_s();
    let mut held = None;
    let mut turning = false;
    let mut count = 0_u32;
    for k in (0..motion.len()).filter(|k| motion.inside[*k]) {
        let axis = motion.axis(k);
        let direction = *held.get_or_insert(axis);
        if !turning && axis.angle(&direction) > REDIRECTED_RAD {
            count += 1;
            turning = true;
        }
        if turning && turning_rad_per_s[k] < HELD_RAD_PER_S {
            held = Some(axis);
            turning = false;
        }
    }
    f64::from(count)
}

fn path_deviation_sd_mm(attempt: &Attempt) -> Outcome {
    attempt.inside()?;
    let motion = attempt.motion()?;
    let (entry_m, axis) = (attempt.bundle.exercise.entry_m(), attempt.bundle.exercise.axis());
    let samples = attempt.timeline.samples();
    let distance_m = |i: usize| (Point3::from(samples[i].position_m) - entry_m).cross(&axis).norm();
    let distances_m = attempt.timeline.even(distance_m);
    let in_tissue = || distances_m.iter().zip(&motion.inside).filter(|(_, inside)| **inside).map(|(d, _)| *d);
    let count = in_tissue().count() as f64;
    let mean_m = in_tissue().sum::<f64>() / count;
    let variance = in_tissue().map(|d| (d - mean_m) * (d - mean_m)).sum::<f64>() / count;
    Ok(variance.sqrt() * 1e3)
}

/// Returns the log dimensionless jerk (Balasubramanian and others, "On the analysis of movement
/// smoothness", 2015).
fn smoothness_ldlj(attempt: &Attempt) -> Outcome {
    attempt.inside()?;
    let motion = attempt.motion()?;
    let in_tissue = |k: &usize| motion.inside[*k];
    let (speed, jerk) = (motion.speed_m_per_s(), motion.jerk_m_per_s3());
    let peak = (0..motion.len()).filter(in_tissue).map(|k| speed[k]).fold(0.0, f64::max);
    let squares: f64 = (0..motion.len()).filter(in_tissue).map(|k| jerk[k] * jerk[k]).sum();
    let duration_s = (0..motion.len()).filter(in_tissue).count() as f64 / RATE_HZ;
    Ok(-libm::log(duration_s * duration_s * duration_s / (peak * peak) * squares / RATE_HZ))
}

/// Evaluates the time from the first moment in tissue to the last. The speed low-passed at 4 Hz has
/// almost no content above 25 Hz, so every fifth grid point is sufficient, and an hour fits in
/// memory.
fn smoothness_sparc(attempt: &Attempt) -> Outcome {
    attempt.inside()?;
    let intent = attempt.intent()?;
    let first = intent.inside.iter().position(|inside| *inside).ok_or(Absent::TooShort)?;
    let last = intent.inside.iter().rposition(|inside| *inside).ok_or(Absent::TooShort)?;
    let every = (RATE_HZ / SPARC_HZ) as usize;
    let speed: Vec<f64> = intent.speed_m_per_s()[first..=last].iter().step_by(every).copied().collect();
    spectral_arc_length(&speed).ok_or(Absent::TooShort)
}
