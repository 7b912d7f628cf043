//! The command line: the commands, and one-line errors for usage errors.

use std::ffi::OsString;

use clap::error::ErrorKind;
use clap::{Parser, Subcommand};

#[cfg(feature = "reports")]
use crate::commands::bench;
use crate::commands::{
    anatomy, calibrate, check, doctor, export, field, force, outbox, pair, recover, render, schema, score, simulate,
    upload, validate, verify,
};
#[cfg(feature = "window")]
use crate::commands::{play, replay};
use crate::exit::{Failure, Outcome};
use crate::output;

/// Text below the list of commands.
const AFTER_HELP: &str = if cfg!(feature = "reports") {
    "Each command has its own help: stylet COMMAND --help"
} else {
    "Each command has its own help: stylet COMMAND --help\n\
     `stylet bench` is in programs that were built with: cargo build --release --package stylet --features reports"
};

/// Training for percutaneous needle puncture: simulate, record, score, deliver.
///
/// Exit status: 0 success; 1 the work failed or a check found something; 2 usage or input error.
#[derive(Parser)]
#[command(
    name = "stylet",
    version,
    arg_required_else_help = false,
    after_help = AFTER_HELP
)]
struct Cli {
    #[command(subcommand)]
    command: Command,
}

/// A command with its arguments.
#[derive(Subcommand)]
pub enum Command {
    #[cfg(feature = "window")]
    Play(play::PlayArgs),
    Simulate(simulate::SimulateArgs),
    Score(score::ScoreArgs),
    Verify(verify::VerifyArgs),
    #[cfg(feature = "window")]
    Replay(replay::ReplayArgs),
    Render(render::RenderArgs),
    Recover(recover::RecoverArgs),
    Export(export::ExportArgs),
    Check(check::CheckArgs),
    Schema(schema::SchemaArgs),
    Force(force::ForceArgs),
    Field(field::FieldArgs),
    Calibrate(calibrate::CalibrateArgs),
    Anatomy(anatomy::AnatomyArgs),
    Validate(validate::ValidateArgs),
    Upload(upload::UploadArgs),
    Outbox(outbox::OutboxArgs),
    Pair(pair::PairArgs),
    Doctor(doctor::DoctorArgs),
    #[cfg(feature = "reports")]
    Bench(bench::BenchArgs),
}

impl Command {
    /// Runs the command.
    pub fn run(&self) -> Outcome {
        match self {
            #[cfg(feature = "window")]
            Self::Play(args) => play::run(args),
            #[cfg(feature = "window")]
            Self::Replay(args) => replay::run(args),
            Self::Render(args) => render::run(args),
            Self::Simulate(args) => simulate::run(args),
            Self::Score(args) => score::run(args),
            Self::Verify(args) => verify::run(args),
            Self::Recover(args) => recover::run(args),
            Self::Export(args) => export::run(args),
            Self::Check(args) => check::run(args),
            Self::Schema(args) => schema::run(args),
            Self::Force(args) => force::run(args),
            Self::Field(args) => field::run(args),
            Self::Calibrate(args) => calibrate::run(args),
            Self::Anatomy(args) => anatomy::run(args),
            Self::Validate(args) => validate::run(args),
            Self::Upload(args) => upload::run(args),
            Self::Outbox(args) => outbox::run(args),
            Self::Pair(args) => pair::run(args),
            Self::Doctor(args) => doctor::run(args),
            #[cfg(feature = "reports")]
            Self::Bench(args) => bench::run(args),
        }
    }
}

/// Parses the command line. Help and version are printed here and end as [`Failure::ReaderGone`]:
/// quietly, with status 0.
pub fn parse(args: impl Iterator<Item = OsString>) -> Result<Command, Failure> {
    Cli::try_parse_from(args).map(|cli| cli.command).map_err(|error| match error.kind() {
        ErrorKind::DisplayHelp | ErrorKind::DisplayVersion => {
            // A closed pipe while help was printed is not an error.
            let _ = error.print();
            Failure::ReaderGone
        }
        _ => Failure::input(wrong_call(&error.render().to_string())),
    })
}

/// Clap explains usage errors over several lines; our errors are one line each, for logs and
/// scripts.
fn wrong_call(rendered: &str) -> String {
    let explained = rendered.split("\n\nUsage:").next().unwrap_or(rendered);
    let explained = explained.split("\n\nFor more information").next().unwrap_or(explained);
    let line = output::one_line(explained.trim_start_matches("error:"));
    format!("{line} (see --help)")
}

#[cfg(test)]
mod tests {
    use clap::CommandFactory;

    use super::{Cli, wrong_call};

    #[test]
    fn the_command_line_is_consistent() {
        Cli::command().debug_assert();
    }

    #[test]
    fn a_wrong_call_is_explained_on_one_line() {
        let rendered = "error: the following arguments were not provided:\n  --out <F>\n\nUsage: stylet x\n\nFor more";
        assert_eq!(wrong_call(rendered), "the following arguments were not provided: --out <F> (see --help)");
    }
}
