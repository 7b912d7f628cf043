//! The learning-curve CUSUM: it starts from "not competent" and declares competence (Biau et al.
//! 2008, "Quantitative and individualized assessment of the learning curve using LC-CUSUM", British
//! Journal of Surgery 95).

use super::chain::Chain;
use super::{REACHED, check_share, count_steps};
use crate::statistics::NotComputable;

/// The failure rates that an LC-CUSUM distinguishes, and its error probability.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize)]
pub struct LcCusumParams {
    /// Acceptable failure rate, 0–1.
    pub p0: f64,
    /// Excess of the unacceptable failure rate, `p0` + `delta`, 0–1.
    pub delta: f64,
    /// Number of attempts for which the probability holds, 1–[`LcCusumParams::MOST_ATTEMPTS`].
    pub within: u32,
    /// Probability of declaring a trainee with the failure rate `p0` + `delta` competent, 0–1.
    pub probability: f64,
}

impl LcCusumParams {
    /// Maximum of `within`; the size of the chain grows with its square.
    pub const MOST_ATTEMPTS: u32 = 200;
}

/// An LC-CUSUM: S ← max(0, S + W), competent when S ≥ h.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct LcCusum {
    /// Increment after a success: ln((1−p0)/(1−p0−δ)).
    pub success: f64,
    /// Increment after a failure, below 0: ln(p0/(p0+δ)).
    pub failure: f64,
    /// The limit.
    pub h: f64,
}

impl LcCusum {
    /// Computes the weights from the rates and the limit from the exact chain: the smallest value
    /// that S can reach for which a trainee with the failure rate `p0` + `delta` is declared
    /// competent within `within` attempts with at most the given probability.
    ///
    /// # Errors
    /// For a rate or probability outside 0–1, for too many attempts, or if no value that S can
    /// reach is rare enough.
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

    /// Returns S after an attempt.
    #[must_use]
    pub fn step(&self, s: f64, failed: bool) -> f64 {
        (s + if failed { self.failure } else { self.success }).max(0.0)
    }

    /// Returns whether S has reached the limit.
    #[must_use]
    pub fn competent(&self, s: f64) -> bool {
        s >= self.h - REACHED
    }

    /// Returns the number of consecutive successes until S reaches the limit.
    #[must_use]
    pub fn successes_needed(&self, s: f64) -> u32 {
        count_steps(self.h - s, self.success)
    }
}
