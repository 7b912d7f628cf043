//! How a command that tries something tells what it found.

use std::io::Write;
use std::process::ExitCode;

/// Says a line. Whoever started the command may have gone.
pub fn say(words: &str) {
    let _ = writeln!(std::io::stdout(), "{words}");
}

/// The exit status of a command by whether all was well; an error is said.
pub fn conclude(passed: anyhow::Result<bool>) -> ExitCode {
    match passed {
        Ok(true) => ExitCode::SUCCESS,
        Ok(false) => ExitCode::FAILURE,
        Err(error) => {
            say(&format!("error: {error:#}"));
            ExitCode::FAILURE
        }
    }
}
