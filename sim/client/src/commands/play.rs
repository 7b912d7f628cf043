//! `stylet play`: the interactive simulator in a window.

use std::path::PathBuf;
use std::sync::Arc;

use assessment::staging::read_pseudonym;
use words::Language;

use crate::devices::DeviceArgs;
use crate::exit::Outcome;
use crate::live::history::History;
use crate::live::{self, open};
use crate::new_file::create_folder;
use crate::outbox::Outbox;
use crate::output;
use crate::settings::Settings;
use crate::shelf::Shelf;
use crate::station::{Pairing, StationKey};
use crate::window::{self, Station, WindowLanguage};

/// Practise in a window
///
/// Every attempt is recorded. Recordings that were interrupted earlier, for example by a power
/// failure, are recovered first.
#[derive(clap::Args)]
#[command(after_help = "Examples:\n  \
    stylet play curricula/lower-back-basics/1-feel-the-layers.toml\n  \
    stylet play curricula/lower-back-basics --device mouse\n  \
    stylet play exercise.toml --device operator:expert")]
pub struct PlayArgs {
    /// Exercises, curricula, or folders that contain them
    #[arg(value_name = "EXERCISE.toml", required = true)]
    exercises: Vec<PathBuf>,
    /// auto, mouse, gamepad, openhaptics, inverse3 or operator:NAME
    #[arg(long, value_name = "DEVICE", default_value = "auto")]
    device: open::DeviceChoice,
    /// Hide the planned line, entry and target
    #[arg(long)]
    free: bool,
    /// Pseudonym of the trainee, never a real name: up to 64 letters, digits and -_.
    #[arg(long, value_name = "PSEUDONYM", default_value = "", hide_default_value = true, value_parser = read_pseudonym)]
    trainee: String,
    /// Seed of the first attempt's patient; each further attempt uses the next number
    #[arg(long, value_name = "N", default_value_t = 0)]
    seed: u64,
    /// Folder for the recordings
    #[arg(long, value_name = "DIR", default_value = "attempts")]
    recordings: PathBuf,
    /// Language of the window: en or de; by default that of the signed-in user, otherwise the
    /// system's
    #[arg(long, value_name = "LANGUAGE")]
    language: Option<Language>,
    #[command(flatten)]
    devices: DeviceArgs,
}

/// Runs the command.
pub fn run(args: &PlayArgs) -> Outcome {
    let shelf = Shelf::open(&args.exercises)?;
    for broken in &shelf.broken {
        output::print_warning(format_args!("skipped: {}", broken.why));
    }
    create_folder(&args.recordings)?;
    for recovered in live::recover_left_behind(&args.recordings)? {
        output::print_warning(format_args!("{}: was truncated, and has been recovered", recovered.display()));
    }
    let (pairing, key) = (Pairing::load()?, StationKey::load()?.map(Arc::new));
    if pairing.is_some() {
        Outbox::open(None)?.take_up_drafts()?;
    }
    window::play(Station {
        shelf,
        history: History::of_folder(args.recordings.clone(), args.trainee.clone()),
        pairing,
        key,
        device: args.device.clone(),
        devices: args.devices.clone(),
        folder: args.recordings.clone(),
        trainee: args.trainee.clone(),
        seed: args.seed,
        guided: !args.free,
        language: WindowLanguage::new(args.language),
        settings: Settings::load()?,
    })
}
