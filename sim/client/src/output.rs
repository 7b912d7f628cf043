//! The only module that prints. Results go to standard output, everything else to standard error.

use std::fmt::{Arguments, Display};
use std::io::{self, BufWriter, ErrorKind, Write};
use std::process::ExitCode;

use serde::Serialize;

use crate::exit::{Failure, Outcome};

/// Writes to a buffered, locked standard output.
pub fn print_buffered(write: impl FnOnce(&mut dyn Write) -> io::Result<()>) -> Outcome {
    let mut out = BufWriter::new(io::stdout().lock());
    write(&mut out).and_then(|()| out.flush()).map_err(|error| match error.kind() {
        ErrorKind::BrokenPipe => Failure::ReaderGone,
        _ => Failure::work(format_args!("standard output: {error}")),
    })
}

/// Prints one human-readable line.
pub fn print_line(text: Arguments<'_>) -> Outcome {
    print_buffered(|out| writeln!(out, "{text}"))
}

/// Prints one JSON value.
pub fn print_json(value: &impl Serialize) -> Outcome {
    let text = serde_json::to_string_pretty(value)
        .map_err(|error| Failure::work(format_args!("the result cannot be written as JSON: {error}")))?;
    print_line(format_args!("{text}"))
}

/// Prints an error on one line, even if it quotes line breaks.
pub fn print_error(text: impl Display) {
    print_to_stderr("error", text);
}

/// Prints a warning on one line, even if it quotes line breaks.
pub fn print_warning(text: impl Display) {
    print_to_stderr("warning", text);
}

fn print_to_stderr(kind: &str, text: impl Display) {
    let text = one_line(&text.to_string());
    // A failure to write to standard error cannot be reported.
    let _ = writeln!(io::stderr().lock(), "{kind}: {text}");
}

/// Joins the words of a text with single spaces and replaces control characters, so that it can
/// neither span lines nor move a terminal's cursor.
pub fn one_line(text: &str) -> String {
    let text: String = text.chars().map(|c| if c.is_control() { ' ' } else { c }).collect();
    text.split_whitespace().collect::<Vec<_>>().join(" ")
}

/// Prints the errors on standard error, and returns the exit status.
pub fn report_outcome(outcome: Outcome) -> ExitCode {
    let (lines, status) = match outcome {
        Ok(()) | Err(Failure::ReaderGone) => (Vec::new(), 0),
        Err(Failure::Found) => (Vec::new(), 1),
        Err(Failure::Work(lines)) => (lines, 1),
        Err(Failure::Input(lines)) => (lines, 2),
    };
    for line in &lines {
        print_error(line);
    }
    ExitCode::from(status)
}
