//! Python exceptions: `StyletError`, a `ValueError`, for invalid input, and Python's own `OSError`
//! for file errors.

use std::fmt::Display;
use std::fs::File;
use std::io;
use std::path::Path;

use attempt::trajectory::TrajectoryError;
use pyo3::create_exception;
use pyo3::exceptions::{PyIsADirectoryError, PyOSError, PyValueError};
use pyo3::prelude::*;

create_exception!(
    stylet,
    StyletError,
    PyValueError,
    "Invalid input. The message names the place (file and line, or argument and index), the value and what is allowed."
);

/// Creates the exception for refused input.
pub fn refuse_input(why: impl Display) -> PyErr {
    StyletError::new_err(why.to_string())
}

/// Creates the exception for a refused file.
pub fn refuse_file(file: &str, why: impl Display) -> PyErr {
    refuse_input(format_args!("{file}: {why}"))
}

/// Creates the exception for an I/O error: the subclass of `OSError` for the error number.
pub fn report_disk(file: &str, error: &io::Error) -> PyErr {
    match error.raw_os_error() {
        Some(number) => {
            let says = error.to_string();
            // Python adds the number itself.
            let says = says.strip_suffix(&format!(" (os error {number})")).unwrap_or(&says);
            PyOSError::new_err((number, says.to_owned(), file.to_owned()))
        }
        None => PyOSError::new_err(format!("{file}: {error}")),
    }
}

/// Opens a file passed by the caller.
pub fn open_file(path: &Path) -> PyResult<File> {
    let name = path.display().to_string();
    let file = File::open(path).map_err(|error| report_disk(&name, &error))?;
    match file.metadata() {
        Ok(metadata) if metadata.is_dir() => {
            Err(PyIsADirectoryError::new_err(format!("{name}: is a folder; allowed: a file")))
        }
        Ok(_) => Ok(file),
        Err(error) => Err(report_disk(&name, &error)),
    }
}

/// Creates the exception for a refused or unreadable trajectory.
pub fn refuse_trajectory(error: &TrajectoryError) -> PyErr {
    match error {
        TrajectoryError::Unreadable { file, error } => report_disk(file, error),
        TrajectoryError::Refused { .. } => refuse_input(error),
    }
}
