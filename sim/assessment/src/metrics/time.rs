//! Time, idleness and actions.

use super::MetricSheet;
use crate::absent::Absent;
use crate::attempt::{Attempt, Outcome};
use crate::motion::TipMotion;
use crate::signal::RATE_HZ;

/// Speed below which the needle is idle, in m/s.
const IDLE_M_PER_S: f64 = 0.2e-3;
/// Speed below which the intended motion (low-passed at 4 Hz) is idle, in m/s.
const IDLE_INTENT_M_PER_S: f64 = 0.5e-3;
/// Speed above which a translational action is in progress, in m/s.
const MOVING_M_PER_S: f64 = 5e-3;
/// The same threshold in PerkTutor, in m/s.
const PERKTUTOR_M_PER_S: f64 = 50e-3;
/// Angular speed above which a rotational action is in progress, in rad/s.
const TURNING_RAD_PER_S: f64 = 50.0 * std::f64::consts::PI / 180.0;
/// Minimum duration of an action, in s.
const ACTION_S: f64 = 0.2;

pub(super) fn measure_times(attempt: &Attempt, sheet: &mut MetricSheet) {
    sheet.put("time_total_s", time_total_s(attempt));
    sheet.put("time_in_tissue_s", time_in_tissue_s(attempt));
    let (motion, intent) = (attempt.motion(), attempt.intent());
    let idle =
        |of: Result<&TipMotion, Absent>, below| attempt.inside().and(of.map(|motion| idle_fraction(motion, below)));
    sheet.put("idle_fraction", idle(motion, IDLE_M_PER_S));
    sheet.put_anew("idle_fraction", idle(intent, IDLE_INTENT_M_PER_S));
    sheet.put("translational_actions", motion.map(|motion| time_above(&motion.speed_m_per_s(), MOVING_M_PER_S)));
    let moves = intent.map(|intent| count_debounced(&intent.speed_m_per_s(), PERKTUTOR_M_PER_S));
    sheet.put_anew("translational_actions", moves);
    sheet.put("rotational_actions", motion.map(|motion| time_above(&motion.turning_rad_per_s(), TURNING_RAD_PER_S)));
    let turns = intent.map(|intent| count_debounced(&intent.turning_rad_per_s(), TURNING_RAD_PER_S));
    sheet.put_anew("rotational_actions", turns);
}

fn time_total_s(attempt: &Attempt) -> Outcome {
    if attempt.timeline.samples().len() < 2 { Err(Absent::TooShort) } else { Ok(attempt.timeline.duration_s()) }
}

/// A step across the skin counts half, which is accurate to half a tick.
fn time_in_tissue_s(attempt: &Attempt) -> Outcome {
    attempt.inside()?;
    let share = |depth_m: f32| if depth_m > 0.0 { 0.5 } else { 0.0 };
    let steps = attempt.timeline.samples().windows(2);
    Ok(steps.map(|s| (s[1].t_s - s[0].t_s) * (share(s[0].depth_m) + share(s[1].depth_m))).sum())
}

fn idle_fraction(motion: &TipMotion, below_m_per_s: f64) -> f64 {
    let speeds = motion.speed_m_per_s();
    let in_tissue = || speeds.iter().zip(&motion.inside).filter(|(_, inside)| **inside);
    in_tissue().filter(|(speed, _)| **speed < below_m_per_s).count() as f64 / in_tissue().count() as f64
}

/// Counts runs of grid points above a limit that are longer than [`ACTION_S`]; n points span n − 1
/// steps.
fn time_above(column: &[f64], above: f64) -> f64 {
    let runs = column.chunk_by(|a, b| (*a > above) == (*b > above));
    let long = |run: &&[f64]| run[0] > above && (run.len() - 1) as f64 / RATE_HZ > ACTION_S;
    runs.filter(long).count() as f64
}

/// Counts how often a column rises above a limit, as PerkTutor does: the state changes after the
/// other one has lasted longer than [`ACTION_S`], so that neither a twitch nor a short pause
/// counts.
fn count_debounced(column: &[f64], above: f64) -> f64 {
    let (mut active, mut lasts, mut count) = (false, 0_usize, 0_u32);
    for value in column {
        lasts = if (*value > above) == active { 0 } else { lasts + 1 };
        if lasts as f64 / RATE_HZ > ACTION_S {
            (active, lasts) = (!active, 0);
            count += u32::from(active);
        }
    }
    f64::from(count)
}
