//! Why a report was not made.

use std::fmt::Display;
use std::path::Path;

use documents::DocumentError;

/// Why a report was not made, or what it found to be wrong.
#[derive(Debug)]
pub enum BenchError {
    /// The call or its input was wrong; each string is a line for people.
    Input(Vec<String>),
    /// The work failed, or a bound was exceeded; each string is a line for people.
    Work(Vec<String>),
}

impl BenchError {
    /// The call or its input was wrong.
    pub fn input(line: impl Display) -> Self {
        Self::Input(vec![line.to_string()])
    }

    /// The work failed.
    pub fn work(line: impl Display) -> Self {
        Self::Work(vec![line.to_string()])
    }

    /// An input file is refused, and why.
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
