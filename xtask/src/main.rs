//! Commands that maintain the tree: `xtask notices FILE PROGRAM…` writes the notices that must travel with programs.

use std::io::Write;
use std::process::ExitCode;

use xtask::{notices, read_metadata};

const USAGE: &str = "usage: xtask notices FILE PROGRAM…, for example: xtask notices THIRD-PARTY.txt stylet web-admin";

fn main() -> ExitCode {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let arguments: Vec<&str> = arguments.iter().map(String::as_str).collect();
    let ["notices", file, programs @ ..] = arguments.as_slice() else { return fail(2, USAGE) };
    match write_notices(file, programs) {
        Ok(()) => ExitCode::SUCCESS,
        Err(why) => fail(1, &why),
    }
}

fn write_notices(file: &str, programs: &[&str]) -> Result<(), String> {
    let metadata = read_metadata("").map_err(|error| error.to_string())?;
    let text = notices::notices(&metadata, programs)?;
    std::fs::write(file, text).map_err(|error| format!("{file}: {error}"))
}

/// Prints the reason on standard error.
fn fail(status: u8, why: &str) -> ExitCode {
    // There is no other place to report that standard error cannot be written to.
    let _ = writeln!(std::io::stderr(), "error: {why}");
    ExitCode::from(status)
}
