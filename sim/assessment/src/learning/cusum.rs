//! The CUSUM of failures: a sequential test between an acceptable and an unacceptable failure rate.

use super::{REACHED, check_share, count_steps};
use crate::statistics::NotComputable;

/// The failure rates that a CUSUM distinguishes, and its error probabilities.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct CusumParams {
    /// Acceptable failure rate, 0–1.
    pub p0: f64,
    /// Unacceptable failure rate, 0–1, above `p0`.
    pub p1: f64,
    /// Probability of calling an acceptable rate unacceptable, 0–1.
    pub alpha: f64,
    /// Probability of calling an unacceptable rate acceptable, 0–1.
    pub beta: f64,
}

/// A CUSUM: each failure adds 1 − s, each success subtracts s; after a crossing the count restarts.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Cusum {
    /// Amount that a success subtracts from the count.
    pub s: f64,
    /// Distance of the lower limit below the start.
    pub h0: f64,
    /// Distance of the upper limit above the start.
    pub h1: f64,
}

/// A limit that was crossed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Crossing {
    /// The lower limit: the failure rate is acceptable.
    Acceptable,
    /// The upper limit: the failure rate is unacceptable.
    Unacceptable,
}

/// The count after an attempt.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize)]
pub struct CusumPoint {
    /// The count since the start or the last crossing.
    pub count: f64,
    /// The limit that this attempt crossed; the next attempt starts from 0.
    pub crossed: Option<Crossing>,
}

impl Cusum {
    /// Computes P = ln(p1/p0), Q = ln((1−p0)/(1−p1)), s = Q/(P+Q), h0 = ln((1−α)/β)/(P+Q), h1 =
    /// ln((1−β)/α)/(P+Q).
    ///
    /// # Errors
    /// For a rate or an error outside 0–1, `p1` not above `p0`, or errors that sum to 1 or more.
    pub fn new(params: &CusumParams) -> Result<Self, NotComputable> {
        let CusumParams { p0, p1, alpha, beta } = *params;
        [p0, p1, alpha, beta].into_iter().try_for_each(check_share)?;
        if p1 <= p0 || alpha + beta >= 1.0 {
            return Err(NotComputable::OutOfRange);
        }
        let p = libm::log(p1 / p0);
        let q = libm::log((1.0 - p0) / (1.0 - p1));
        let h0 = libm::log((1.0 - alpha) / beta) / (p + q);
        let h1 = libm::log((1.0 - beta) / alpha) / (p + q);
        Ok(Self { s: q / (p + q), h0, h1 })
    }

    /// Returns the point after an attempt that started with `count`.
    #[must_use]
    pub fn step(&self, count: f64, failed: bool) -> CusumPoint {
        let count = if failed { count + 1.0 - self.s } else { count - self.s };
        let crossed = if count <= REACHED - self.h0 {
            Some(Crossing::Acceptable)
        } else if count >= self.h1 - REACHED {
            Some(Crossing::Unacceptable)
        } else {
            None
        };
        CusumPoint { count, crossed }
    }

    /// Returns the points of consecutive attempts; `true` is a failure.
    #[must_use]
    pub fn run(&self, failures: &[bool]) -> Vec<CusumPoint> {
        let mut count = 0.0;
        let step = |failed: &bool| {
            let point = self.step(count, *failed);
            count = if point.crossed.is_some() { 0.0 } else { point.count };
            point
        };
        failures.iter().map(step).collect()
    }

    /// Returns the number of consecutive successes until the count reaches the lower limit.
    #[must_use]
    pub fn successes_needed(&self, count: f64) -> u32 {
        count_steps(count + self.h0, self.s)
    }
}
