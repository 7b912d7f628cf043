//! `stylet verify`: compares a recording with its own re-simulation.

use std::path::PathBuf;

use attempt::verify::Verification;

use crate::exit::{Failure, Outcome};
use crate::{output, sources};

/// Re-simulate a recording's input and compare every recorded force and tent
///
/// Uses only the data in the file: the exercise, the scene and the drawn patient. Exits with status
/// 0 if every force and event is bit-identical, 1 if anything differs.
#[derive(clap::Args)]
#[command(after_help = "Example:\n  stylet verify attempt.mcap")]
pub struct VerifyArgs {
    /// The recording
    #[arg(value_name = "REC.mcap")]
    recording: PathBuf,
    /// Print the result as JSON
    #[arg(long)]
    json: bool,
}

/// Runs the command.
pub fn run(args: &VerifyArgs) -> Outcome {
    let recording = sources::read_recording(&args.recording)?;
    let verification = assessment::verify_own(&recording).map_err(|error| Failure::refused(&args.recording, error))?;
    match args.json {
        true => output::print_json(&verification)?,
        false => report(&verification)?,
    }
    if verification.exact() { Ok(()) } else { Err(Failure::Found) }
}

fn report(verification: &Verification) -> Outcome {
    let Verification { ticks, largest_deviation_n, at_s, channel, event_differences, tents, .. } = verification;
    if verification.exact() {
        return output::print_line(format_args!(
            "bit-identical: largest deviation 0 N over {ticks} ticks and {tents} steps of the field, events and \
             energies identical"
        ));
    }
    let place = if channel.is_empty() { String::new() } else { format!(" in {channel} at {at_s} s") };
    output::print_line(format_args!(
        "different: largest deviation {largest_deviation_n} N{place} over {ticks} ticks, {} mm in depth, \
         {event_differences} event differences; field: {} mm, {} steps differ; {} energy ledgers, {} pulses of \
         X-rays and {} ticks inside the body differ",
        verification.largest_depth_deviation_m * 1e3,
        verification.largest_tent_deviation_m * 1e3,
        verification.tent_differences,
        verification.ledger_differences,
        verification.pulse_differences,
        verification.inside_differences
    ))
}
