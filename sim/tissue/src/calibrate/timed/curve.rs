//! A curve with times: insertion, holds, withdrawal, and a second insertion into the same track if
//! there is one.

use crate::calibrate::CalibrateError;
use crate::calibrate::curve::{Curve, noise_n};

/// Maximum number of samples of a fit; a longer curve is thinned to this, which bounds the time.
const MOST_SAMPLES: usize = 500;
/// A needle that travels less than this, in m, for at least this long, in s, is held (choice).
const HELD_M: f64 = 0.1e-3;
const HELD_S: f64 = 0.5;

/// A change of speed from one sample to the next by more than this fraction of the maximum counts
/// as a stop, start or reversal (choice).
const TURNED: f64 = 0.1;

/// One sample of a measured needle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TimedSample {
    /// Time, in s.
    pub t_s: f64,
    /// Displacement of the tip from the skin, in m.
    pub depth_m: f64,
    /// Axial force, in N; positive pushes the needle out.
    pub force_n: f64,
}

/// Depth and force over time.
#[derive(Clone, Debug, PartialEq)]
pub struct TimedCurve {
    pub(super) samples: Vec<TimedSample>,
    /// The same curve without times, which shows the drops.
    pub(super) insertion: Curve,
    /// Samples next to which the needle stops, starts or reverses: its speed there is unknown.
    pub(super) turns: Vec<bool>,
    left_out: usize,
}

impl TimedCurve {
    /// Makes a curve in the order measured. Samples are dropped only by thinning: a hold shows
    /// relaxation.
    ///
    /// # Errors
    /// If a number is not finite or a time does not increase, and the errors of [`Curve::new`].
    pub fn new(samples: &[TimedSample]) -> Result<Self, CalibrateError> {
        if let Some(row) = samples.iter().position(|sample| !sample.t_s.is_finite()) {
            return Err(CalibrateError::NotFinite { row });
        }
        if let Some(before) = samples.windows(2).position(|pair| pair[1].t_s <= pair[0].t_s) {
            return Err(CalibrateError::TimeStandsStill { row: before + 1, t_s: samples[before + 1].t_s });
        }
        let pairs: Vec<(f64, f64)> = samples.iter().map(|sample| (sample.depth_m, sample.force_n)).collect();
        let insertion = Curve::new(&pairs)?;
        let kept: Vec<TimedSample> = samples.iter().step_by(samples.len().div_ceil(MOST_SAMPLES)).copied().collect();
        Ok(Self { left_out: samples.len() - kept.len(), turns: find_turns(&kept), samples: kept, insertion })
    }

    /// Number of samples in the fit.
    #[must_use]
    pub fn len(&self) -> usize {
        self.samples.len()
    }

    /// Always false: a curve has samples.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.samples.is_empty()
    }

    /// Number of samples dropped by thinning.
    #[must_use]
    pub fn left_out(&self) -> usize {
        self.left_out
    }

    /// The maximum force, in N.
    #[must_use]
    pub fn peak_n(&self) -> f64 {
        self.insertion.peak_n()
    }

    /// Standard deviation of the force's noise, in N, from its second differences.
    #[must_use]
    pub fn noise_n(&self) -> f64 {
        let forces: Vec<f64> = self.samples.iter().map(|sample| sample.force_n).collect();
        noise_n(&forces)
    }

    /// The greatest distance between two consecutive samples, in m.
    pub(super) fn stride_m(&self) -> f64 {
        self.samples.windows(2).map(|pair| (pair[1].depth_m - pair[0].depth_m).abs()).fold(0.0, f64::max)
    }

    /// Whether the needle rests somewhere, which reveals relaxation.
    #[must_use]
    pub fn holds(&self) -> bool {
        self.samples.iter().enumerate().any(|(from, first)| {
            let rest = self.samples[from..].iter().take_while(|later| (later.depth_m - first.depth_m).abs() < HELD_M);
            rest.last().is_some_and(|last| last.t_s - first.t_s >= HELD_S)
        })
    }

    /// Whether any part withdraws, which reveals friction.
    #[must_use]
    pub fn withdraws(&self) -> bool {
        self.insertion.withdraws()
    }
}

fn find_turns(samples: &[TimedSample]) -> Vec<bool> {
    let speeds: Vec<f64> =
        samples.windows(2).map(|pair| (pair[1].depth_m - pair[0].depth_m) / (pair[1].t_s - pair[0].t_s)).collect();
    let greatest = speeds.iter().fold(0.0_f64, |greatest, speed| greatest.max(speed.abs()));
    let turns = speeds.windows(2).map(|pair| (pair[1] - pair[0]).abs() > TURNED * greatest);
    [false].into_iter().chain(turns).chain([false]).collect()
}
