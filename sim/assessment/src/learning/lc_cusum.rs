//! The learning-curve CUSUM: it starts from "not competent" and declares competence (Biau et al. 2008,
//! "Quantitative and individualized assessment of the learning curve using LC-CUSUM", British Journal of Surgery 95).

use super::chain::Chain;
use super::{REACHED, check_share, count_steps};
use crate::statistics::NotComputable;

/// What an LC-CUSUM tells apart, and how often it may be wrong.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize)]
pub struct LcCusumParams {
    /// Acceptable failure rate, 0–1.
    pub p0: f64,
    /// What makes a rate unacceptable: `p0` + `delta` is, 0–1.
    pub delta: f64,
    /// Attempts within which the probability holds, 1–[`LcCusumParams::MOST_ATTEMPTS`].
    pub within: u32,
    /// Probability of declaring somebody competent whose failure rate is `p0` + `delta`, 0–1.
    pub probability: f64,
}

impl LcCusumParams {
    /// The most attempts that `within` may be; the chain grows with its square.
    pub const MOST_ATTEMPTS: u32 = 200;
}

/// An LC-CUSUM: S ← max(0, S + W), competent when S ≥ h.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct LcCusum {
    /// What a success adds: ln((1−p0)/(1−p0−δ)).
    pub success: f64,
    /// What a failure adds, below 0: ln(p0/(p0+δ)).
    pub failure: f64,
    /// The limit.
    pub h: f64,
}

impl LcCusum {
    /// Weights from the rates; the limit from the exact chain: the smallest value that S can reach at which somebody
    /// with the failure rate `p0` + `delta` is declared competent within the stated attempts at most with the stated
    /// probability.
    ///
    /// # Errors
    /// For a rate or probability outside 0–1, for too many attempts, or when no value that S can reach is rare enough.
    pub fn new(params: &LcCusumParams) -> Result<Self, NotComputable> {
        let LcCusumParams { p0, delta, within, probability } = *params;
        [p0, delta, p0 + delta, probability].into_iter().try_for_each(check_share)?;
        if !(1..=LcCusumParams::MOST_ATTEMPTS).contains(&within) {
            return Err(NotComputable::OutOfRange);
        }
        let success = libm::log((1.0 - p0) / (1.0 - p0 - delta));
        let failure = libm::log(p0 / (p0 + delta));
        let chain = Chain::new(success, -failure, within);
        let needed = within as usize + 1;
        let found = needed - 1;
        let h = chain.limit(p0 + delta, probability).ok_or(NotComputable::TooFew { found, needed })?;
        Ok(Self { success, failure, h })
    }

    /// S after an attempt.
    #[must_use]
    pub fn step(&self, s: f64, failed: bool) -> f64 {
        (s + if failed { self.failure } else { self.success }).max(0.0)
    }

    /// True when S has reached the limit.
    #[must_use]
    pub fn competent(&self, s: f64) -> bool {
        s >= self.h - REACHED
    }

    /// Straight successes that take S to the limit.
    #[must_use]
    pub fn successes_needed(&self, s: f64) -> u32 {
        count_steps(self.h - s, self.success)
    }
}
