//! The recorded motion on a uniform grid, from which all metrics of speed, path and rotation are
//! computed.

use nalgebra::{Point3, Quaternion, UnitQuaternion, Vector3};
use recording::Sample;

use crate::error::AssessError;
use crate::signal::{CUTOFF_HZ, RATE_HZ, derivative, low_pass};

/// Longest recording that is scored, in s; bounds the memory that a malicious time stamp can cause
/// to be allocated.
const LONGEST_S: f64 = 3600.0;

/// Minimum number of grid points for a derivative: 0.1 s.
const FEWEST_POINTS: usize = 26;

/// The usable samples in order of time: finite, with a unit quaternion and increasing time.
pub(crate) struct Timeline<'a> {
    samples: Vec<&'a Sample>,
}

impl<'a> Timeline<'a> {
    /// Collects the usable samples; gaps are interpolated linearly.
    pub(crate) fn new(samples: &'a [Sample]) -> Result<Self, AssessError> {
        let mut kept: Vec<&Sample> = Vec::with_capacity(samples.len());
        let usable = samples.iter().filter(|s| is_usable_sample(s));
        for sample in usable {
            if kept.last().is_none_or(|last| sample.t_s > last.t_s) {
                kept.push(sample);
            }
        }
        let timeline = Self { samples: kept };
        match timeline.duration_s() {
            _ if timeline.samples.is_empty() => Err(AssessError::NoSamples),
            duration_s if duration_s > LONGEST_S => Err(AssessError::TooLong { duration_s, longest_s: LONGEST_S }),
            _ => Ok(timeline),
        }
    }

    /// Returns the usable samples; at least one.
    pub(crate) fn samples(&self) -> &[&'a Sample] {
        &self.samples
    }

    /// Returns the time of the first sample, in s.
    pub(crate) fn start_s(&self) -> f64 {
        self.samples.first().map_or(0.0, |s| s.t_s)
    }

    /// Returns the time from the first sample to the last, in s.
    pub(crate) fn duration_s(&self) -> f64 {
        self.samples.last().map_or(0.0, |s| s.t_s) - self.start_s()
    }

    /// Returns the index of the last sample at or before a time; `None` before the first.
    pub(crate) fn index_at(&self, t_s: f64) -> Option<usize> {
        self.samples.partition_point(|s| s.t_s <= t_s).checked_sub(1)
    }

    /// Returns a quantity at a time, linear between samples, constant beyond the ends.
    pub(crate) fn at(&self, t_s: f64, quantity: impl Fn(&Sample) -> f64) -> f64 {
        let last = self.samples.len() - 1;
        let Some(i) = self.index_at(t_s) else { return quantity(self.samples[0]) };
        if i == last {
            return quantity(self.samples[last]);
        }
        let (a, b) = (self.samples[i], self.samples[i + 1]);
        let share = (t_s - a.t_s) / (b.t_s - a.t_s);
        quantity(a) + (quantity(b) - quantity(a)) * share
    }

    /// Resamples a quantity, given by sample index, to the uniform grid, linear between samples.
    pub(crate) fn even(&self, quantity: impl Fn(usize) -> f64) -> Vec<f64> {
        // A thousandth of a point compensates for the rounding of times such as 0.001 × 4 000.
        let points = (self.duration_s() * RATE_HZ + 1e-3) as usize + 1;
        let last = self.samples.len() - 1;
        let mut i = 0;
        (0..points)
            .map(|k| {
                let t_s = self.start_s() + k as f64 / RATE_HZ;
                while i < last && self.samples[i + 1].t_s <= t_s {
                    i += 1;
                }
                let next = (i + 1).min(last);
                let (a, b) = (self.samples[i].t_s, self.samples[next].t_s);
                let share = if next == i { 0.0 } else { (t_s - a) / (b - a) };
                quantity(i) + (quantity(next) - quantity(i)) * share
            })
            .collect()
    }

    /// Like [`Self::even`], low-passed at [`CUTOFF_HZ`], as required before every derivative.
    pub(crate) fn smooth(&self, quantity: impl Fn(usize) -> f64) -> Vec<f64> {
        self.behind(CUTOFF_HZ, quantity)
    }

    /// Like [`Self::even`], low-passed at a cut-off in Hz.
    fn behind(&self, cutoff_hz: f64, quantity: impl Fn(usize) -> f64) -> Vec<f64> {
        low_pass(&self.even(quantity), cutoff_hz)
    }
}

fn is_usable_sample(s: &Sample) -> bool {
    let norm_squared: f64 = s.orientation.iter().map(|q| q * q).sum();
    let wide = [s.t_s, s.x_m].into_iter().chain(s.position_m);
    let narrow = [s.depth_m, s.tip_n, s.rim_n, s.viscous_n, s.friction_n, s.cutting_n];
    let narrow = narrow.into_iter().chain(s.force_n).chain(s.lateral_n);
    // Also false if the norm is NaN.
    (norm_squared - 1.0).abs() < 1e-3 && wide.chain(narrow.map(f64::from)).all(f64::is_finite)
}

fn needle_axis_of([x, y, z, w]: [f64; 4]) -> Vector3<f64> {
    UnitQuaternion::from_quaternion(Quaternion::new(w, x, y, z)) * Vector3::z()
}

/// Low-passed motion at [`RATE_HZ`]: the actual motion at 20 Hz, or the intended motion at 4 Hz.
pub(crate) struct TipMotion {
    position_m: [Vec<f64>; 3],
    orientation: [Vec<f64>; 4],
    /// Axial displacement from the skin entry, in m.
    pub(crate) axial_m: Vec<f64>,
    /// Whether the tip's depth is above 0.
    pub(crate) inside: Vec<bool>,
}

impl TipMotion {
    /// Low-passes the motion at a cut-off in Hz; `None` if the recording is too short for a
    /// derivative.
    pub(crate) fn behind(cutoff_hz: f64, timeline: &Timeline) -> Option<Self> {
        let samples = timeline.samples();
        let depth_m = timeline.even(|i| f64::from(u8::from(samples[i].depth_m > 0.0)));
        if depth_m.len() < FEWEST_POINTS {
            return None;
        }
        let signs = hemisphere_signs(samples);
        Some(Self {
            position_m: std::array::from_fn(|axis| timeline.behind(cutoff_hz, |i| samples[i].position_m[axis])),
            orientation: std::array::from_fn(|part| {
                timeline.behind(cutoff_hz, |i| samples[i].orientation[part] * signs[i])
            }),
            axial_m: timeline.behind(cutoff_hz, |i| samples[i].x_m),
            inside: depth_m.into_iter().map(|share| share > 0.5).collect(),
        })
    }

    /// Returns the tip position at a grid point, in m.
    pub(crate) fn position(&self, k: usize) -> Point3<f64> {
        Point3::from(std::array::from_fn::<f64, 3, _>(|axis| self.position_m[axis][k]))
    }

    /// Returns the needle axis at a grid point, unit length.
    pub(crate) fn axis(&self, k: usize) -> Vector3<f64> {
        needle_axis_of(std::array::from_fn(|part| self.orientation[part][k]))
    }

    /// Returns the number of grid points.
    pub(crate) fn len(&self) -> usize {
        self.inside.len()
    }

    /// Returns the speed of the tip at each grid point, in m/s.
    pub(crate) fn speed_m_per_s(&self) -> Vec<f64> {
        euclidean_norms(self.position_m.iter().map(|column| derivative(column)))
    }

    /// Returns the jerk of the tip at each grid point, in m/s³.
    pub(crate) fn jerk_m_per_s3(&self) -> Vec<f64> {
        euclidean_norms(self.position_m.iter().map(|column| derivative(&derivative(&derivative(column)))))
    }

    /// Returns the angular speed of the needle, including roll, at each grid point, in rad/s:
    /// 2‖dq/dt‖ for a unit quaternion.
    pub(crate) fn turning_rad_per_s(&self) -> Vec<f64> {
        let halves = euclidean_norms(self.orientation.iter().map(|column| derivative(column)));
        halves.into_iter().map(|half| 2.0 * half).collect()
    }
}

/// Returns ±1 for each sample, so that neighbouring quaternions lie in one hemisphere: q and −q are
/// the same orientation.
fn hemisphere_signs(samples: &[&Sample]) -> Vec<f64> {
    let mut sign = 1.0;
    let mut previous: Option<&Sample> = None;
    samples
        .iter()
        .map(|&sample| {
            let dot = |p: &Sample| p.orientation.iter().zip(sample.orientation).map(|(a, b)| a * b).sum::<f64>();
            if previous.is_some_and(|p| dot(p) < 0.0) {
                sign = -sign;
            }
            previous = Some(sample);
            sign
        })
        .collect()
}

/// Returns the Euclidean norm of columns, point by point; only one component is in memory at a
/// time.
fn euclidean_norms(components: impl Iterator<Item = Vec<f64>>) -> Vec<f64> {
    let mut squares: Vec<f64> = Vec::new();
    for component in components {
        squares.resize(component.len(), 0.0);
        squares.iter_mut().zip(component).for_each(|(sum, value)| *sum += value * value);
    }
    squares.into_iter().map(f64::sqrt).collect()
}
