//! `stylet play`: the interactive simulator in a window.

use std::fs;
use std::path::{Path, PathBuf};

use scene::{Document, ExerciseBundle};

use crate::commands::simulate::pseudonym;
use crate::devices::DeviceArgs;
use crate::exit::{Failure, Outcome};
use crate::live::{self, open};
use crate::new_file::create_folder;
use crate::outbox::Outbox;
use crate::output;
use crate::station::Pairing;
use crate::window::{self, Station};

/// Practise in a window
///
/// Every attempt is recorded. A recording that was cut off earlier, by a power failure for example, is made whole first.
#[derive(clap::Args)]
#[command(after_help = "Examples:\n  \
    stylet play curricula/lower-back-basics/1-feel-the-layers.toml\n  \
    stylet play curricula/lower-back-basics --device mouse\n  \
    stylet play exercise.toml --device operator:expert")]
pub struct Args {
    /// Exercises, curricula, or folders that hold them
    #[arg(value_name = "EXERCISE.toml", required = true)]
    exercises: Vec<PathBuf>,
    /// auto, mouse, gamepad, openhaptics, inverse3 or operator:NAME
    #[arg(long, value_name = "DEVICE", default_value = "auto")]
    device: open::Choice,
    /// Hide the planned line, entry and target
    #[arg(long)]
    free: bool,
    /// Pseudonym of the trainee, never a name: up to 64 letters, digits and -_.
    #[arg(long, value_name = "PSEUDONYM", default_value = "", hide_default_value = true, value_parser = pseudonym)]
    trainee: String,
    /// Draws the patient of the first attempt; each further attempt has the next
    #[arg(long, value_name = "N", default_value_t = 0)]
    seed: u64,
    /// Folder of the recordings
    #[arg(long, value_name = "DIR", default_value = "attempts")]
    recordings: PathBuf,
    #[command(flatten)]
    devices: DeviceArgs,
}

/// Runs the command.
pub fn run(args: &Args) -> Outcome {
    let exercises = exercises(&args.exercises)?;
    create_folder(&args.recordings)?;
    for recovered in live::recover_left_behind(&args.recordings)? {
        output::warning(format_args!("{}: was cut off, and is whole again", recovered.display()));
    }
    let pairing = Pairing::load()?;
    if pairing.is_some() {
        Outbox::open(None)?.take_up_drafts()?;
    }
    window::play(Station {
        exercises,
        pairing,
        device: args.device.clone(),
        devices: args.devices.clone(),
        folder: args.recordings.clone(),
        trainee: args.trainee.clone(),
        seed: args.seed,
        guided: !args.free,
    })
}

/// Every exercise of the files and folders that the call names, each once, in order.
fn exercises(paths: &[PathBuf]) -> Result<Vec<ExerciseBundle>, Failure> {
    let mut found: Vec<ExerciseBundle> = Vec::new();
    for path in paths {
        for bundle in in_path(path)? {
            if found.iter().all(|known| known.exercise.sha256 != bundle.exercise.sha256) {
                found.push(bundle);
            }
        }
    }
    match found.is_empty() {
        true => Err(Failure::input("no exercise found in what was named")),
        false => Ok(found),
    }
}

fn in_path(path: &Path) -> Result<Vec<ExerciseBundle>, Failure> {
    if path.is_dir() {
        return in_folder(path);
    }
    match scene::load::read(path)? {
        Document::Exercise(bundle) => Ok(vec![*bundle]),
        Document::Curriculum(_, bundles) => Ok(bundles),
        Document::Scene(_) => Err(Failure::refused(path, "is a scene; an exercise or a curriculum is needed")),
        Document::Instrument(_) => {
            Err(Failure::refused(path, "is an instrument; an exercise or a curriculum is needed"))
        }
    }
}

/// The exercises in a folder and below, by name. What is no exercise is passed over: courses and scenes lie beside them.
fn in_folder(folder: &Path) -> Result<Vec<ExerciseBundle>, Failure> {
    let listed = fs::read_dir(folder).map_err(|error| Failure::refused(folder, error))?;
    let mut paths: Vec<PathBuf> = listed.flatten().map(|entry| entry.path()).collect();
    paths.sort();
    let mut found = Vec::new();
    for path in paths {
        if path.is_dir() {
            found.extend(in_folder(&path)?);
        } else if path.extension().is_some_and(|extension| extension == "toml")
            && let Document::Exercise(bundle) = scene::load::read(&path)?
        {
            found.push(*bundle);
        }
    }
    Ok(found)
}
