//! A measured force–depth curve, cleared of samples that the quasistatic law cannot represent.

use super::CalibrateError;

/// Minimum number of samples for a fit.
pub const MIN_SAMPLES: usize = 12;
/// Maximum number of samples of a fit; a longer curve is thinned to this, which bounds the time.
const MOST_SAMPLES: usize = 2000;
/// A step back of less than this, in m, is noise of the depth or a held hand, not a withdrawal
/// (choice).
const BACK_M: f64 = 0.2e-3;

/// Depth of the tip and axial force along a slow insertion, with a withdrawal if there is one.
#[derive(Clone, Debug, PartialEq)]
pub struct Curve {
    /// Displacement of the tip from the skin, in m.
    pub(super) depth_m: Vec<f64>,
    /// Axial force, in N; positive pushes the needle out.
    pub(super) force_n: Vec<f64>,
    left_out: usize,
}

impl Curve {
    /// Makes a curve of (depth in m, force in N) in the order measured. Samples that neither
    /// advance nor withdraw by 0.2 mm are dropped: the law cuts only while it advances, so that a
    /// jittering depth would switch cutting on and off.
    ///
    /// # Errors
    /// If a number is not finite, if fewer than [`MIN_SAMPLES`] samples remain, or if fewer of them
    /// go deeper than all before.
    pub fn new(samples: &[(f64, f64)]) -> Result<Self, CalibrateError> {
        if let Some(row) = samples.iter().position(|(x, f)| !x.is_finite() || !f.is_finite()) {
            return Err(CalibrateError::NotFinite { row });
        }
        let moving = moving(samples);
        if moving.len() < MIN_SAMPLES {
            return Err(CalibrateError::TooFew { found: moving.len(), needed: MIN_SAMPLES });
        }
        let every = moving.len().div_ceil(MOST_SAMPLES);
        let kept = thinned(&moving, every);
        let curve = Self {
            depth_m: kept.iter().map(|sample| sample.0).collect(),
            force_n: kept.iter().map(|sample| sample.1).collect(),
            left_out: samples.len() - kept.len(),
        };
        match curve.front().len() {
            found @ ..MIN_SAMPLES => Err(CalibrateError::NoInsertion { found, needed: MIN_SAMPLES }),
            _ => Ok(curve),
        }
    }

    /// Number of samples in the fit.
    #[must_use]
    pub fn len(&self) -> usize {
        self.depth_m.len()
    }

    /// Always false: a curve has at least [`MIN_SAMPLES`] samples.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.depth_m.is_empty()
    }

    /// Number of dropped samples: noise of the depth, holds, and the thinning of a long curve.
    #[must_use]
    pub fn left_out(&self) -> usize {
        self.left_out
    }

    /// The maximum force, in N.
    #[must_use]
    pub fn peak_n(&self) -> f64 {
        self.force_n.iter().copied().fold(0.0, f64::max)
    }

    /// The greatest depth, in m.
    #[must_use]
    pub fn deepest_m(&self) -> f64 {
        self.depth_m.iter().copied().fold(0.0, f64::max)
    }

    /// Whether any part withdraws, which reveals friction.
    #[must_use]
    pub fn withdraws(&self) -> bool {
        self.depth_m.windows(2).any(|pair| pair[1] < pair[0])
    }

    /// Standard deviation of the force's noise, in N.
    #[must_use]
    pub fn noise_n(&self) -> f64 {
        noise_n(&self.force_n)
    }

    /// The same curve with every depth multiplied by a factor.
    #[must_use]
    pub fn stretched(&self, factor: f64) -> Self {
        Self { depth_m: self.depth_m.iter().map(|x| x * factor).collect(), ..self.clone() }
    }

    /// Indices of the samples that are deeper than all before them, in order: those of a first
    /// insertion.
    pub(super) fn front(&self) -> Vec<usize> {
        let mut deepest_m = f64::NEG_INFINITY;
        let deeper = |&at: &usize| {
            let is_deeper = self.depth_m[at] > deepest_m;
            deepest_m = deepest_m.max(self.depth_m[at]);
            is_deeper
        };
        (0..self.len()).filter(deeper).collect()
    }
}

/// Standard deviation of the noise of forces in the order measured, in N, from the median of
/// |second differences|: straight sections do not add to it and a few drops do not move it. A
/// second difference of white noise has √6 times its deviation.
pub(super) fn noise_n(force_n: &[f64]) -> f64 {
    const MEDIAN_TO_DEVIATION: f64 = 1.4826;
    let bend = |w: &[f64]| (w[0] - 2.0 * w[1] + w[2]).abs();
    let mut bends: Vec<f64> = force_n.windows(3).map(bend).collect();
    bends.sort_by(f64::total_cmp);
    let median = bends.get(bends.len() / 2).copied().unwrap_or(0.0);
    MEDIAN_TO_DEVIATION * median / 6.0_f64.sqrt()
}

/// Every `every`-th sample, and those at which the motion reverses: friction depends on the true
/// distance travelled.
fn thinned(samples: &[(f64, f64)], every: usize) -> Vec<(f64, f64)> {
    let turns = |at: usize| match at.checked_sub(1).and_then(|before| samples.get(before..=at + 1)) {
        Some(&[(before_m, _), (here_m, _), (behind_m, _)]) => (here_m - before_m) * (behind_m - here_m) < 0.0,
        _ => false,
    };
    let is_kept = |&(at, _): &(usize, &(f64, f64))| at % every == 0 || turns(at);
    samples.iter().enumerate().filter(is_kept).map(|(_, sample)| *sample).collect()
}

/// The samples that continue in the direction of the motion, which reverses when a step back
/// exceeds [`BACK_M`].
fn moving(samples: &[(f64, f64)]) -> Vec<(f64, f64)> {
    let mut kept: Vec<(f64, f64)> = samples.first().copied().into_iter().collect();
    let mut direction = 1.0;
    for sample in samples.iter().skip(1) {
        let Some(last) = kept.last() else { break };
        let ahead_m = (sample.0 - last.0) * direction;
        if ahead_m < -BACK_M {
            direction = -direction;
        }
        if !(-BACK_M..=0.0).contains(&ahead_m) {
            kept.push(*sample);
        }
    }
    kept
}
