//! The native half of the Python package `stylet`: thin calls into the functions that the commands
//! use. The other half, in `stylet/`, converts the returned bytes to numpy arrays and documents
//! them.
//!
//! Computations release Python's lock, and no reference to Python's memory is kept: columns are
//! copied in and out as bytes.

mod clock;
mod errors;
mod field;
mod force;
mod reading;
mod rows;
mod simulation;

use pyo3::prelude::*;

/// The module that the Python half imports.
#[pymodule]
#[pyo3(name = "_native")]
mod native {
    #[pymodule_export]
    use crate::errors::StyletError;
    #[pymodule_export]
    use crate::field::answer_field;
    #[pymodule_export]
    use crate::force::compute_force;
    #[pymodule_export]
    use crate::reading::{NativeRecording, read_recording};
    #[pymodule_export]
    use crate::simulation::simulate_exercise;
}
