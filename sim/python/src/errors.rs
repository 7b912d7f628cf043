//! What goes wrong, as exceptions: `StyletError`, a `ValueError`, where input is wrong, and an `OSError` of Python's own where a file cannot
//! be read.

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
    "Input that is refused. The message names the place (file and line, or argument and index), the value and what is allowed."
);

/// Input is refused, and why.
pub fn refuse_input(why: impl Display) -> PyErr {
    StyletError::new_err(why.to_string())
}

/// A file is refused, and why.
pub fn refuse_file(file: &str, why: impl Display) -> PyErr {
    refuse_input(format_args!("{file}: {why}"))
}

/// A file cannot be read or written: the subclass of `OSError` that belongs to the system's own number.
pub fn report_disk(file: &str, error: &io::Error) -> PyErr {
    match error.raw_os_error() {
        Some(number) => {
            let says = error.to_string();
            // Python puts the number in front itself.
            let says = says.strip_suffix(&format!(" (os error {number})")).unwrap_or(&says);
            PyOSError::new_err((number, says.to_owned(), file.to_owned()))
        }
        None => PyOSError::new_err(format!("{file}: {error}")),
    }
}

/// Opens a file that the call names.
pub fn open_file(path: &Path) -> PyResult<File> {
    let name = path.display().to_string();
    let file = File::open(path).map_err(|error| report_disk(&name, &error))?;
    match file.metadata() {
        Ok(metadata) if metadata.is_dir() => {
            Err(PyIsADirectoryError::new_err(format!("{name}: is a folder; a file is needed")))
        }
        Ok(_) => Ok(file),
        Err(error) => Err(report_disk(&name, &error)),
    }
}

/// A trajectory is refused, or its file cannot be read.
pub fn refuse_trajectory(error: &TrajectoryError) -> PyErr {
    match error {
        TrajectoryError::Unreadable { file, error } => report_disk(file, error),
        TrajectoryError::Refused { .. } => refuse_input(error),
    }
}
