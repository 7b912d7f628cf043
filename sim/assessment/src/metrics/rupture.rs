//! Metrics of ruptures: the force before, the advance after, and the time to stop.

use recording::Contactor;

use super::{Id, MetricSheet};
use crate::absent::Absent;
use crate::attempt::{Attempt, Outcome, RecordedRupture};
use crate::signal::{RATE_HZ, derivative};

/// Time after a rupture in which the advance is measured, in s.
const WATCHED_S: f64 = 1.0;

/// Axial speed at which the needle counts as stopped, in m/s.
const STOPPED_M_PER_S: f64 = 0.5e-3;

/// A needle is at rest while its advance stays within this band, in m, for this time, in s.
const BAND_M: f64 = 0.1e-3;
const STANDS_S: f64 = 0.2;

pub(super) fn measure_ruptures(attempt: &Attempt, sheet: &mut MetricSheet) {
    put_largest(attempt, sheet, Id::first("rupture_force_n"), &|rupture| Ok(rupture.force_n));
    put_largest(attempt, sheet, Id::first("over_insertion_mm"), &|rupture| Ok(over_insertion_mm(attempt, rupture)));
    let speeds = attempt.motion().map(|motion| derivative(&motion.axial_m));
    let stop = |rupture: &RecordedRupture| stop_time_s(attempt, speeds.as_ref().map_err(|absent| *absent)?, rupture);
    put_largest(attempt, sheet, Id::first("stop_time_s"), &stop);
    let stands = find_standstills(attempt);
    let stop = |rupture: &RecordedRupture| stands_after_s(attempt, stands.as_ref().map_err(|absent| *absent)?, rupture);
    put_largest(attempt, sheet, Id::second("stop_time_s"), &stop);
}

/// Records the largest value over all ruptures, and over those of each boundary and contactor.
fn put_largest(attempt: &Attempt, sheet: &mut MetricSheet, id: Id<'_>, of: &dyn Fn(&RecordedRupture) -> Outcome) {
    sheet.enter(id, largest_over_ruptures(attempt, of, |_| true));
    let rim = attempt.bundle.scene.needle.tip_to_rim_mm > 0.0;
    for (i, layer) in attempt.bundle.scene.layers.iter().enumerate() {
        for contactor in [Contactor::Tip, Contactor::Rim].into_iter().take(1 + usize::from(rim)) {
            let suffix = format!("{}.{}", layer.name, contactor.name());
            let outcome = largest_over_ruptures(attempt, of, |r| r.boundary == i && r.contactor == contactor);
            sheet.enter(id.by(&suffix), outcome);
        }
    }
}

/// Returns the largest value over the chosen ruptures; if one of them has none, there is no result.
fn largest_over_ruptures(
    attempt: &Attempt,
    of: &dyn Fn(&RecordedRupture) -> Outcome,
    chosen: impl Fn(&RecordedRupture) -> bool,
) -> Outcome {
    attempt.inside()?;
    let values: Result<Vec<f64>, Absent> = attempt.ruptures.iter().filter(|r| chosen(r)).map(of).collect();
    values?.into_iter().reduce(f64::max).ok_or(Absent::NoRupture)
}

/// If the recording ends earlier, the advance is measured up to its end.
fn over_insertion_mm(attempt: &Attempt, rupture: &RecordedRupture) -> f64 {
    let samples = attempt.timeline.samples();
    let until_s = rupture.t_s + WATCHED_S;
    let from = samples.partition_point(|s| s.t_s < rupture.t_s);
    let watched = samples[from..].iter().take_while(|s| s.t_s <= until_s).map(|s| s.x_m);
    let furthest_m = watched.fold(attempt.timeline.at(until_s, |s| s.x_m), f64::max);
    (furthest_m - rupture.x_m).max(0.0) * 1e3
}

/// Returns the time from the rupture until the speed, linear between grid points, falls to the
/// limit. A needle that reverses has stopped in between, even if at no grid point.
fn stop_time_s(attempt: &Attempt, speed_m_per_s: &[f64], rupture: &RecordedRupture) -> Outcome {
    let since_s = rupture.t_s - attempt.timeline.start_s();
    let from = (since_s * RATE_HZ).ceil().max(0.0) as usize;
    if speed_m_per_s.get(from).is_some_and(|speed| speed.abs() < STOPPED_M_PER_S) {
        return Ok((from as f64 / RATE_HZ - since_s).max(0.0));
    }
    let mut steps = speed_m_per_s.windows(2).enumerate().skip(from);
    let stop = steps.find_map(|(k, step)| {
        let (before, after) = (step[0].abs(), step[1] * step[0].signum());
        let share = (before - STOPPED_M_PER_S) / (before - after);
        (after < STOPPED_M_PER_S).then_some((k as f64 + share) / RATE_HZ)
    });
    stop.map(|stop_s| stop_s - since_s).ok_or(Absent::NeverStopped)
}

/// Returns for each grid point whether the needle is at rest from there on: the largest and
/// smallest advance during the following time differ by at most the band. Points without enough
/// time after them count as moving.
fn find_standstills(attempt: &Attempt) -> Result<Vec<bool>, Absent> {
    let advance_m = &attempt.intent()?.axial_m;
    let within = |window: &[f64]| {
        let ends = window.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), m| (a.min(*m), b.max(*m)));
        ends.1 - ends.0 <= BAND_M
    };
    Ok(advance_m.windows((STANDS_S * RATE_HZ) as usize + 1).map(within).collect())
}

fn stands_after_s(attempt: &Attempt, stands: &[bool], rupture: &RecordedRupture) -> Outcome {
    let since_s = rupture.t_s - attempt.timeline.start_s();
    let from = (since_s * RATE_HZ).ceil().max(0.0) as usize;
    let stop = stands.iter().enumerate().skip(from).find(|(_, stands)| **stands);
    stop.map(|(k, _)| (k as f64 / RATE_HZ - since_s).max(0.0)).ok_or(Absent::NeverStopped)
}
