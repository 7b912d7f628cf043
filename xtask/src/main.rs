//! Commands that maintain the tree: `xtask notices FILE PROGRAM…` writes the notices that must travel with programs, for this
//! platform or with `--target TRIPLE` for another.

use std::io::Write;
use std::process::ExitCode;

use xtask::{notices, read_metadata, read_metadata_for};

const USAGE: &str =
    "usage: xtask notices [--target TRIPLE] FILE PROGRAM…, for example: xtask notices THIRD-PARTY.txt stylet web-admin";

fn main() -> ExitCode {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let arguments: Vec<&str> = arguments.iter().map(String::as_str).collect();
    let (target, file, programs) = match arguments.as_slice() {
        ["notices", "--target", target, file, programs @ ..] => (Some(*target), file, programs),
        ["notices", file, programs @ ..] => (None, file, programs),
        _ => return fail(2, USAGE),
    };
    match write_notices(target, file, programs) {
        Ok(()) => ExitCode::SUCCESS,
        Err(why) => fail(1, &why),
    }
}

fn write_notices(target: Option<&str>, file: &str, programs: &[&str]) -> Result<(), String> {
    let metadata = target.map_or_else(|| read_metadata(""), |target| read_metadata_for(target, ""));
    let metadata = metadata.map_err(|error| error.to_string())?;
    let text = notices::notices(&metadata, programs)?;
    std::fs::write(file, text).map_err(|error| format!("{file}: {error}"))
}

/// Prints the reason on standard error.
fn fail(status: u8, why: &str) -> ExitCode {
    // There is no other place to report that standard error cannot be written to.
    let _ = writeln!(std::io::stderr(), "error: {why}");
    ExitCode::from(status)
}
