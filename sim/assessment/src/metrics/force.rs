//! Forces on the hand.

use std::collections::BTreeMap;
use std::iter::Peekable;
use std::slice::Iter;

use ::attempt::{Insertion, raise_to_rupture_n};
use law::Skin;
use recording::{Contactor, Sample};

use super::MetricSheet;
use crate::absent::Absent;
use crate::attempt::{Attempt, Outcome, RecordedRupture};
use crate::signal::{RATE_HZ, derivative};

/// Time around a rupture in which the force rate is ignored, in s: the filter's response to the
/// drop has decayed by then.
const BESIDE_RUPTURE_S: f64 = 0.05;

pub(super) fn measure_force(attempt: &Attempt, sheet: &mut MetricSheet) {
    let axial_n = attempt.axial_n();
    sheet.put("force_impulse_ns", impulse_ns(attempt, &axial_n));
    sheet.put("force_rate_peak_n_per_s", rate_peak_n_per_s(attempt, &axial_n));
    let peaks_n = raise_before_ruptures(attempt, axial_n);
    put_largest(attempt, sheet, "peak_force_n", &peaks_n);
    let lateral_n = lateral_n(attempt);
    put_largest(attempt, sheet, "lateral_peak_n", &lateral_n);
    let layers = tip_layers(attempt);
    put_by_layer(attempt, sheet, "peak_force_layer_n", &layer_peaks_n(attempt, &layers, &peaks_n));
    put_by_layer(attempt, sheet, "max_lateral_force_n", &layer_peaks_n(attempt, &layers, &lateral_n));
}

/// Records the largest of a column of forces, in N, one for each sample.
fn put_largest(attempt: &Attempt, sheet: &mut MetricSheet, id: &str, column_n: &[f64]) {
    sheet.put(id, attempt.touched().map(|_| column_n.iter().copied().fold(0.0, f64::max)));
}

/// Records the peak in each layer, in N; absent for a layer that the tip has not reached.
fn put_by_layer(attempt: &Attempt, sheet: &mut MetricSheet, id: &str, peaks_n: &[Option<f64>]) {
    for (layer, peak_n) in attempt.bundle.scene.layers.iter().zip(peaks_n) {
        let outcome = attempt.touched().and_then(|_| peak_n.ok_or(absent_if_not_reached(attempt)));
        sheet.put_for(id, &layer.name, outcome);
    }
}

fn absent_if_not_reached(attempt: &Attempt) -> Absent {
    attempt.inside().err().unwrap_or(Absent::LayerNotReached)
}

/// Integrates the force with the trapezoidal rule.
fn impulse_ns(attempt: &Attempt, axial_n: &[f64]) -> Outcome {
    attempt.touched()?;
    let samples = attempt.timeline.samples();
    let pairs = samples.windows(2).zip(axial_n.windows(2));
    Ok(pairs.map(|(s, f)| (s[1].t_s - s[0].t_s) * (f[0] + f[1]) / 2.0).sum())
}

/// Returns the magnitude of the lateral force of each sample, in N.
fn lateral_n(attempt: &Attempt) -> Vec<f64> {
    let square = |s: &&Sample| s.lateral_n.iter().map(|n| f64::from(*n) * f64::from(*n)).sum::<f64>();
    attempt.timeline.samples().iter().map(square).map(f64::sqrt).collect()
}

/// Returns the peak rate of the force without its steps at ruptures, and only away from them: the
/// drop, and the filter's response to it, is not caused by the hand.
fn rate_peak_n_per_s(attempt: &Attempt, axial_n: &[f64]) -> Outcome {
    attempt.touched()?;
    attempt.motion()?;
    let steady_n = without_falls(attempt, axial_n);
    let rates = derivative(&attempt.timeline.smooth(|i| steady_n[i]));
    let time_s = |k: usize| attempt.timeline.start_s() + k as f64 / RATE_HZ;
    let away = |k: usize| {
        let next = attempt.ruptures.partition_point(|r| r.t_s < time_s(k) - BESIDE_RUPTURE_S);
        attempt.ruptures.get(next).is_none_or(|r| r.t_s > time_s(k) + BESIDE_RUPTURE_S)
    };
    rates
        .into_iter()
        .enumerate()
        .filter(|(k, _)| away(*k))
        .map(|(_, rate)| rate)
        .reduce(f64::max)
        .ok_or(Absent::TooShort)
}

fn without_falls(attempt: &Attempt, axial_n: &[f64]) -> Vec<f64> {
    let mut ruptures = attempt.ruptures.iter().peekable();
    let mut removed_n = 0.0;
    let mut last_n = axial_n.first().copied().unwrap_or(0.0);
    let steady = attempt.timeline.samples().iter().zip(axial_n).map(|(sample, force_n)| {
        let mut ruptured = false;
        while ruptures.next_if(|r| r.t_s <= sample.t_s).is_some() {
            ruptured = true;
        }
        removed_n += if ruptured { force_n - last_n } else { 0.0 };
        last_n = *force_n;
        force_n - removed_n
    });
    steady.collect()
}

/// Raises the sample before each rupture to the force just before it: the contactor's own force
/// from the event, and the other parts as last recorded. Otherwise the peak would depend on the
/// recording's rate.
fn raise_before_ruptures(attempt: &Attempt, mut axial_n: Vec<f64>) -> Vec<f64> {
    let samples = attempt.timeline.samples();
    for rupture in &attempt.ruptures {
        let Some(before) = samples.partition_point(|s| s.t_s < rupture.t_s).checked_sub(1) else { continue };
        axial_n[before] = raise_to_rupture_n(axial_n[before], samples[before], rupture.contactor, rupture.force_n);
    }
    axial_n
}

/// Returns the layer of the tip in each sample, as [`TipWay::layer`] determines it.
fn tip_layers(attempt: &Attempt) -> Vec<Option<usize>> {
    let mut tip = TipWay::new(attempt);
    attempt.ticks().map(|(sample, insertion)| insertion.and_then(|insertion| tip.layer(sample, insertion))).collect()
}

/// Returns the largest of a column of forces, in N, one for each sample, while the tip is in each
/// layer.
fn layer_peaks_n(attempt: &Attempt, layers: &[Option<usize>], column_n: &[f64]) -> Vec<Option<f64>> {
    let mut peaks: Vec<Option<f64>> = vec![None; attempt.thickness_m.len()];
    for (layer, force_n) in layers.iter().zip(column_n) {
        if let Some(peak) = layer.and_then(|layer| peaks.get_mut(layer)) {
            *peak = Some(peak.map_or(*force_n, |p: f64| p.max(*force_n)));
        }
    }
    peaks
}

/// Tracks the tip through the layers, sample by sample.
struct TipWay<'a> {
    skin: &'a Skin,
    thickness_m: &'a [f64],
    ruptures: Peekable<Iter<'a, RecordedRupture>>,
    /// Number of boundaries that the tip has opened, by track.
    opened: BTreeMap<u32, usize>,
}

impl<'a> TipWay<'a> {
    fn new(attempt: &'a Attempt) -> Self {
        Self {
            skin: &attempt.bundle.scene.skin_shape,
            thickness_m: &attempt.thickness_m,
            ruptures: attempt.ruptures.iter().peekable(),
            opened: BTreeMap::new(),
        }
    }

    /// Returns the layer whose boundary the tip tents, or in which it is; `None` without contact.
    fn layer(&mut self, sample: &Sample, insertion: &Insertion) -> Option<usize> {
        let opened = self.opened.entry(insertion.track).or_default();
        while let Some(rupture) = self.ruptures.next_if(|r| r.t_s <= sample.t_s) {
            if rupture.contactor == Contactor::Tip {
                *opened = (*opened).max(rupture.boundary + 1);
            }
        }
        if sample.tip_n > 0.0 {
            return Some(*opened);
        }
        let depth_m = insertion.incidence(self.skin).depth_m(f64::from(sample.depth_m));
        (depth_m > 0.0).then(|| self.layer_at(depth_m))
    }

    /// Returns the layer j with D_j < s ≤ D_{j+1}; below the last boundary, the last layer.
    fn layer_at(&self, depth_m: f64) -> usize {
        let mut bottom_m = 0.0;
        let below = self.thickness_m.iter().position(|thickness_m| {
            bottom_m += thickness_m;
            depth_m <= bottom_m
        });
        below.unwrap_or(self.thickness_m.len().saturating_sub(1))
    }
}
