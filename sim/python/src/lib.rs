//! The native half of the Python package `stylet`: thin calls into the functions that the commands use. The other half, in `stylet/`,
//! makes numpy arrays of the bytes that come from here, and documents them.
//!
//! Nothing here holds Python's lock while it computes, and nothing keeps Python's memory: columns are copied in and out as bytes.

mod clock;
mod errors;
mod field;
mod force;
mod reading;
mod rows;
mod simulation;

use pyo3::prelude::*;

/// What the Python half imports.
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
