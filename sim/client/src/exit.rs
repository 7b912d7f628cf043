//! How a command ends. Exit status: 0 success; 1 the work failed or a check found something; 2
//! usage or input error.

use std::fmt::{self, Display};
use std::path::Path;

use attempt::trajectory::TrajectoryError;
use documents::DocumentError;

/// Why a command ended without success.
#[derive(Debug)]
pub enum Failure {
    /// Usage or input error; each string is one line on standard error. Exit status 2.
    Input(Vec<String>),
    /// The work failed; each string is one line on standard error. Exit status 1.
    Work(Vec<String>),
    /// A check has findings, and its report is already printed. Exit status 1.
    Found,
    /// The reader of standard output has closed it, as `head` does, which is not an error. Exit
    /// status 0.
    ReaderGone,
}

/// The result of every command.
pub type Outcome = Result<(), Failure>;

impl Failure {
    /// A usage or input error.
    pub fn input(line: impl Display) -> Self {
        Self::Input(vec![line.to_string()])
    }

    /// A failure of the work itself.
    pub fn work(line: impl Display) -> Self {
        Self::Work(vec![line.to_string()])
    }

    /// A rejected input file, with the reason.
    pub fn refused(file: &Path, why: impl Display) -> Self {
        Self::input(format_args!("{}: {why}", file.display()))
    }
}

impl Display for Failure {
    /// Formats the failure on one line.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Input(lines) | Self::Work(lines) => f.write_str(&lines.join("; ")),
            Self::Found => f.write_str("a check found something"),
            Self::ReaderGone => f.write_str("the reader of the output is gone"),
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
