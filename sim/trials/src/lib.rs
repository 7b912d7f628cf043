//! Test scenes, motions, generators of slabs and curves, independent references, and the hard cases
//! as data, for the tests of the simulator's crates and for the reports of `stylet bench`.
//!
//! The hard cases are those of physics section 8: for each model, a measured quantity and its
//! bound. Trials are data, so that the tests run the same measurements as the report. A trial
//! passes if its measurement is a number not above its bound; a trial that cannot be set up has no
//! measurement and fails. An input that a model must refuse is measured as 0 if it is refused and 1
//! if not.

mod axisymmetric;
pub mod calibration;
mod case;
pub mod estimates;
mod force_law;
mod hands;
pub mod lumps;
mod mass_spring;
pub mod needle;
pub mod scenes;
pub mod slabs;
mod soak;
pub mod timed_calibration;
mod volumetric;

use core::error::Error;

pub use force_law::lateness_m;
pub use hands::{Lunge, Performance, perform};
pub use soak::{Soaked, soak};

/// The result of a measurement: a number in the trial's unit, or an error.
pub type Measured = Result<f64, Box<dyn Error>>;

/// A trial: a property that must hold in a hard case, and its measurement.
#[derive(Clone, Copy, Debug)]
pub struct HardCaseTrial {
    /// The model it concerns.
    pub model: &'static str,
    /// Name within the model; that of the measuring function and of the test.
    pub name: &'static str,
    /// The hard case, as worded in physics section 8.
    pub case: &'static str,
    /// The measured quantity, in words.
    pub measures: &'static str,
    /// The largest value that passes, in `unit`.
    pub bound: f64,
    /// Unit of the bound and of the measured value; empty for a count or a ratio.
    pub unit: &'static str,
    /// Runs the measurement.
    pub measure: fn() -> Measured,
}

impl HardCaseTrial {
    /// Returns whether a measured value satisfies the bound; `false` for NaN.
    #[must_use]
    pub fn passes(&self, measured: f64) -> bool {
        measured <= self.bound
    }
}

/// Every trial of every model.
#[must_use]
pub fn all_trials() -> Vec<HardCaseTrial> {
    [force_law::trials(), axisymmetric::trials(), mass_spring::trials(), volumetric::trials()].concat()
}

/// Defines the list of a model's trials, each named after its measuring function.
macro_rules! trials {
    ($model:literal: $($name:path, $case:expr, $measures:literal, <= $bound:literal $unit:literal;)+) => {
        /// Returns the trials of this model.
        pub(super) fn trials() -> Vec<super::HardCaseTrial> {
            vec![$(super::HardCaseTrial {
                model: $model,
                name: stringify!($name),
                case: $case,
                measures: $measures,
                bound: $bound,
                unit: $unit,
                measure: $name,
            }),+]
        }
    };
}
use trials;

/// Returns the largest value; NaN if any value is NaN, which `f64::max` would ignore.
fn largest(values: impl IntoIterator<Item = f64>) -> f64 {
    values.into_iter().fold(f64::NEG_INFINITY, libm::fmaximum)
}
