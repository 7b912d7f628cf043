//! The only module that prints. Results go to standard output, everything else to standard error.

use std::fmt::{Arguments, Display};
use std::io::{self, BufWriter, ErrorKind, Write};
use std::process::ExitCode;

use serde::Serialize;

use crate::exit::{Failure, Outcome};

/// Prints through a buffered, locked standard output.
pub fn print_buffered(write: impl FnOnce(&mut dyn Write) -> io::Result<()>) -> Outcome {
    let mut out = BufWriter::new(io::stdout().lock());
    write(&mut out).and_then(|()| out.flush()).map_err(|error| match error.kind() {
        ErrorKind::BrokenPipe => Failure::ReaderGone,
        _ => Failure::work(format_args!("standard output: {error}")),
    })
}

/// Prints one line for people.
pub fn print_line(text: Arguments<'_>) -> Outcome {
    print_buffered(|out| writeln!(out, "{text}"))
}

/// Prints one JSON value for programs.
pub fn print_json(value: &impl Serialize) -> Outcome {
    let text = serde_json::to_string_pretty(value)
        .map_err(|error| Failure::work(format_args!("the result cannot be written as JSON: {error}")))?;
    print_line(format_args!("{text}"))
}

/// Says one thing that went wrong, on one line whatever it quotes.
pub fn print_error(text: impl Display) {
    print_to_stderr("error", text);
}

/// Says one thing the user should know, on one line whatever it quotes.
pub fn print_warning(text: impl Display) {
    print_to_stderr("warning", text);
}

fn print_to_stderr(kind: &str, text: impl Display) {
    let text = one_line(&text.to_string());
    // Standard error that cannot be written to leaves nobody to tell.
    let _ = writeln!(io::stderr().lock(), "{kind}: {text}");
}

/// Joins the words of a text with single spaces and leaves control characters out, so that it cannot span lines or
/// move a terminal's cursor.
pub fn one_line(text: &str) -> String {
    let text: String = text.chars().map(|c| if c.is_control() { ' ' } else { c }).collect();
    text.split_whitespace().collect::<Vec<_>>().join(" ")
}

/// Says on standard error what went wrong and turns the outcome into the exit status.
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
