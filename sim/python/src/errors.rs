//! What goes wrong, as exceptions: `StyletError`, a `ValueError`, where input is wrong, and an `OSError` of Python's own where a file cannot
//! be read.

use std::fmt::Display;
use std::fs::File;
use std::io;
use std::path::Path;

use attempt::trajectory::TrajectoryError;
use pyo3::create_exception;
use pyo3::exceptions::{PyOSError, PyValueError};
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
        Some(number) => PyOSError::new_err((number, error.to_string(), file.to_owned())),
        None => PyOSError::new_err(format!("{file}: {error}")),
    }
}

/// Opens a file that the call names.
pub fn open_file(path: &Path) -> PyResult<File> {
    let name = path.display().to_string();
    let file = File::open(path).map_err(|error| report_disk(&name, &error))?;
    match file.metadata() {
        Ok(metadata) if metadata.is_dir() => Err(report_disk(&name, &io::ErrorKind::IsADirectory.into())),
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
