//! Learning curves: CUSUM and LC-CUSUM over passes and failures, what they say about a trainee, and when an exercise is mastered.

mod chain;
mod cusum;
mod lc_cusum;
mod mastery;
mod standing;

pub use cusum::{Crossing, Cusum, CusumParams, CusumPoint};
pub use lc_cusum::{LcCusum, LcCusumParams};
pub use mastery::{CurveRule, Mastery, Reached};
pub use standing::{LearningCurve, LearningPoint, Rule, Standing, learning_curve};

use crate::statistics::NotComputable;

/// A sum that reaches a line but for rounding has reached it.
const REACHED: f64 = 1e-9;

/// Straight steps of one length that a distance takes; 0 when it is covered already.
fn count_steps(distance: f64, step: f64) -> u32 {
    let steps = libm::ceil((distance - REACHED) / step);
    // In range: distances and steps are finite, and a step has a least size by the parameters' ranges.
    if steps > 0.0 { steps as u32 } else { 0 }
}

/// Refuses a share outside 0–1, its ends excluded.
fn check_share(value: f64) -> Result<(), NotComputable> {
    if value > 0.0 && value < 1.0 { Ok(()) } else { Err(NotComputable::OutOfRange) }
}
