//! `stylet verify`: a recording against its own re-simulation.

use std::path::PathBuf;

use attempt::verify::{self, Verification};
use documents::Patient;
use tissue::Specimen;

use crate::exit::{Failure, Outcome};
use crate::{output, sources};

/// Re-simulate a recording's input and compare every recorded force and tent
///
/// Uses only what the file carries: the exercise, the scene and the patient drawn. Exit 0 when every force and event is
/// the same to the bit, 1 when anything differs.
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
    let bundle = sources::own_exercise(&args.recording, &recording)?;
    let patient = Patient { thickness_mm: recording.session.patient_thickness_mm.clone() };
    let (drawn, layers) = (patient.thickness_mm.len(), bundle.scene.layers.len());
    if drawn != layers {
        let why = format_args!("patient_thickness_mm has {drawn} values; {layers} are allowed, one per layer");
        return Err(Failure::refused(&args.recording, why));
    }
    let spec = bundle.recorded_spec(&patient, recording.session.judging);
    let specimen = Specimen::new(spec).map_err(|error| Failure::refused(&args.recording, error))?;
    let verification = verify::verify_recording(&recording, &specimen);
    match args.json {
        true => output::print_json(&verification)?,
        false => report(&verification)?,
    }
    if verification.exact() { Ok(()) } else { Err(Failure::Found) }
}

fn report(verification: &Verification) -> Outcome {
    let Verification { ticks, largest_deviation_n, at_s, channel, event_differences, tents, tent_differences, .. } =
        verification;
    if verification.exact() {
        return output::print_line(format_args!(
            "same to the bit: largest deviation 0 N over {ticks} ticks and {tents} steps of the field, events identical"
        ));
    }
    let place = if channel.is_empty() { String::new() } else { format!(" in {channel} at {at_s} s") };
    output::print_line(format_args!(
        "different: largest deviation {largest_deviation_n} N{place} over {ticks} ticks, {} mm in depth, {event_differences} event differences; \
         field: {} mm, {tent_differences} steps differ",
        verification.largest_depth_deviation_m * 1e3,
        verification.largest_tent_deviation_m * 1e3
    ))
}
