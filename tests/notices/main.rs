//! Writes the notices that must travel with our programs: `notices OUT PROGRAM…`, from the root of the project.

use std::io::Write;
use std::process::ExitCode;

fn main() -> ExitCode {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [out, programs @ ..] = arguments.as_slice() else {
        return fail(2, "usage: notices OUT PROGRAM…, for example: notices THIRD-PARTY.txt stylet web-admin");
    };
    let programs: Vec<&str> = programs.iter().map(String::as_str).collect();
    match tests::notices::notices(&tests::metadata(), &programs) {
        Ok(text) => match std::fs::write(out, text) {
            Ok(()) => ExitCode::SUCCESS,
            Err(error) => fail(1, &format!("{out}: {error}")),
        },
        Err(why) => fail(1, &why),
    }
}

/// Says on standard error why there are no notices.
fn fail(status: u8, why: &str) -> ExitCode {
    // Standard error that cannot be written to leaves nobody to tell.
    let _ = writeln!(std::io::stderr(), "error: {why}");
    ExitCode::from(status)
}
