//! How a command ends: 0 done, 1 the work failed or a check found something, 2 the call or its input was wrong.

use std::fmt::{self, Display};
use std::path::Path;

use attempt::trajectory::TrajectoryError;
use documents::DocumentError;

/// Why a command did not do what it was asked.
#[derive(Debug)]
pub enum Failure {
    /// The call or its input was wrong; each string is one line of standard error. Exit 2.
    Input(Vec<String>),
    /// The work failed; each string is one line of standard error. Exit 1.
    Work(Vec<String>),
    /// A check found something, and the report that says so is already printed. Exit 1.
    Found,
    /// Whoever read our output has gone, as `head` does: nothing is wrong. Exit 0.
    ReaderGone,
}

/// What every command returns.
pub type Outcome = Result<(), Failure>;

impl Failure {
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

impl Display for Failure {
    /// What went wrong, on one line.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Input(lines) | Self::Work(lines) => f.write_str(&lines.join("; ")),
            Self::Found => f.write_str("a check found something"),
            Self::ReaderGone => f.write_str("nobody reads the output any more"),
        }
    }
}

impl From<DocumentError> for Failure {
    fn from(error: DocumentError) -> Self {
        Self::Input(error.issues.iter().map(ToString::to_string).collect())
    }
}

impl From<TrajectoryError> for Failure {
    fn from(error: TrajectoryError) -> Self {
        Self::input(error)
    }
}
