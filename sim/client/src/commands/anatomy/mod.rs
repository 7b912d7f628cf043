//! `stylet anatomy`: bodies for scenes.

mod body;
mod files;
mod import;

use clap::Subcommand;

use crate::exit::Outcome;

/// Make bodies for scenes, from parameters or from a segmentation
#[derive(clap::Args)]
pub struct AnatomyArgs {
    #[command(subcommand)]
    command: AnatomyCommand,
}

/// The subcommands of `stylet anatomy`.
#[derive(Subcommand)]
enum AnatomyCommand {
    Body(body::BodyArgs),
    Import(import::ImportArgs),
}

/// Runs the command.
pub fn run(args: &AnatomyArgs) -> Outcome {
    match &args.command {
        AnatomyCommand::Body(args) => body::run(args),
        AnatomyCommand::Import(args) => import::run(args),
    }
}
