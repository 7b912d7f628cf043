//! Errors of making a report.

use std::fmt::Display;
use std::path::Path;

use documents::DocumentError;

/// A report was not made, or found an error.
#[derive(Debug)]
pub enum BenchError {
    /// The arguments or an input file are invalid; each string is one line of the message.
    Input(Vec<String>),
    /// The measurement failed, or a bound was exceeded; each string is one line of the message.
    Work(Vec<String>),
}

impl BenchError {
    /// Creates the error for invalid arguments or input.
    pub fn input(line: impl Display) -> Self {
        Self::Input(vec![line.to_string()])
    }

    /// Creates the error for a failed measurement.
    pub fn work(line: impl Display) -> Self {
        Self::Work(vec![line.to_string()])
    }

    /// Creates the error for a refused input file.
    pub fn refused(file: &Path, why: impl Display) -> Self {
        Self::input(format_args!("{}: {why}", file.display()))
    }
}

impl Display for BenchError {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let (Self::Input(lines) | Self::Work(lines)) = self;
        f.write_str(&lines.join("; "))
    }
}

impl From<DocumentError> for BenchError {
    fn from(error: DocumentError) -> Self {
        Self::Input(error.issues.iter().map(ToString::to_string).collect())
    }
}
