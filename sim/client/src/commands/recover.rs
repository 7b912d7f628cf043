//! `stylet recover`: copies every valid message from a truncated or damaged recording.

use std::io::BufReader;
use std::path::PathBuf;

use recording::error::ReadError;
use recording::recover;

use crate::exit::{Failure, Outcome};
use crate::new_file::NewFile;
use crate::progress::Progress;
use crate::{output, sources};

/// Copy every valid message of a truncated or damaged recording into a new one
///
/// The input is not changed. The output is reopened and checked before it is renamed into place.
#[derive(clap::Args)]
#[command(after_help = "Example:\n  stylet recover cut.mcap --out fixed.mcap")]
pub struct RecoverArgs {
    /// The recording to read
    #[arg(value_name = "REC.mcap")]
    recording: PathBuf,
    /// The recording to write
    #[arg(long, value_name = "FIXED.mcap")]
    out: PathBuf,
    /// Replace the output if it exists
    #[arg(long)]
    force: bool,
    /// Print the result as JSON
    #[arg(long)]
    json: bool,
}

/// Runs the command.
pub fn run(args: &RecoverArgs) -> Outcome {
    let file = sources::open(&args.recording)?;
    let progress = Progress::new(file.metadata().map_or(0, |metadata| metadata.len()), "recovering");
    let source = BufReader::new(progress.watch(file));
    let mut fixed = NewFile::create(&args.out, args.force)?;
    let recovered = recover::recover(source, fixed.file()).map_err(|error| match error {
        ReadError::Io(error) => Failure::work(format_args!("{}: {error}", args.out.display())),
        error => Failure::refused(&args.recording, error),
    })?;
    drop(progress);
    fixed.keep()?;
    if args.json {
        return output::print_json(&recovered);
    }
    let damage = match recovered.damage.as_str() {
        "" => "the input was complete",
        damage => damage,
    };
    output::print_line(format_args!(
        "{}: {} messages, {} of them samples, out of {} bytes; {damage}",
        args.out.display(),
        recovered.messages,
        recovered.samples,
        recovered.bytes_read,
    ))
}
