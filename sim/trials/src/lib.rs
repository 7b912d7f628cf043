//! Test scenes, motions, generators of slabs and curves, references by other means, and the hard cases as data: for the tests of the
//! simulator's crates and for the reports of `stylet bench`.
//!
//! The hard cases are those of physics section 8: for each model that a case concerns, what is measured, and the bound it must keep.
//! Trials are data, so that the tests run the same measurements as the report prints. A trial passes when what it
//! measures is a number and not above its bound; a trial that cannot be set up measures nothing and fails. What a model must refuse
//! is measured as 0 when it is refused and 1 when it is not.

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

/// What a measurement comes to: a number in the trial's unit, or why there is none.
pub type Measured = Result<f64, Box<dyn Error>>;

/// A hard case, one of the things that must hold in it, and how that is measured.
#[derive(Clone, Copy, Debug)]
pub struct HardCaseTrial {
    /// The model it concerns.
    pub model: &'static str,
    /// Its name within the model: that of the function that measures, and of the test.
    pub name: &'static str,
    /// The hard case, in the words of physics section 8.
    pub case: &'static str,
    /// What is measured, in words.
    pub measures: &'static str,
    /// The largest value that passes, in `unit`.
    pub bound: f64,
    /// Unit of the bound and of the measured value; empty for a count or a ratio.
    pub unit: &'static str,
    /// Measures it.
    pub measure: fn() -> Measured,
}

impl HardCaseTrial {
    /// Whether a measured value keeps the bound. What is not a number does not.
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

/// The list of a model's trials, each named by the function that measures it.
macro_rules! trials {
    ($model:literal: $($name:path, $case:expr, $measures:literal, <= $bound:literal $unit:literal;)+) => {
        /// The trials of this model.
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

/// The largest value; not a number as soon as one of them is not, which `f64::max` would hide.
fn largest(values: impl IntoIterator<Item = f64>) -> f64 {
    values.into_iter().fold(f64::NEG_INFINITY, libm::fmaximum)
}
