//! `stylet replay`: shows a recording in a window, with timeline, plots and scrubbing.

use std::path::PathBuf;

use words::Language;

use crate::exit::Outcome;
use crate::window::WindowLanguage;
use crate::{sources, window};

/// Watch a recording in a window
#[derive(clap::Args)]
#[command(after_help = "Examples:\n  \
    stylet replay attempt.mcap\n  \
    stylet replay attempt.mcap --compare expert.mcap")]
pub struct ReplayArgs {
    /// The recording
    #[arg(value_name = "REC.mcap")]
    recording: PathBuf,
    /// A second recording, drawn as a ghost; the two are aligned by the layers that they passed
    #[arg(long, value_name = "REC2.mcap")]
    compare: Option<PathBuf>,
    /// Language of the window: en or de; by default the system's
    #[arg(long, value_name = "LANGUAGE")]
    language: Option<Language>,
}

/// Runs the command.
pub fn run(args: &ReplayArgs) -> Outcome {
    let recording = sources::read_recording(&args.recording)?;
    let other = args.compare.as_deref().map(sources::read_recording).transpose()?;
    window::watch(&args.recording, recording, other, WindowLanguage::new(args.language))
}
