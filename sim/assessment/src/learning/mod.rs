//! Learning curves: CUSUM and LC-CUSUM over passes and failures, the resulting status of a trainee,
//! and mastery of an exercise.

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

/// Tolerance for rounding when a sum is compared with a limit.
const REACHED: f64 = 1e-9;

/// Returns the number of steps that cover a distance; 0 if it is covered already.
fn count_steps(distance: f64, step: f64) -> u32 {
    let steps = libm::ceil((distance - REACHED) / step);
    // In range: distances and steps are finite, and the parameters' ranges give a step a minimum
    // size.
    if steps > 0.0 { steps as u32 } else { 0 }
}

/// Refuses a value outside the open interval 0–1.
fn check_share(value: f64) -> Result<(), NotComputable> {
    if value > 0.0 && value < 1.0 { Ok(()) } else { Err(NotComputable::OutOfRange) }
}
