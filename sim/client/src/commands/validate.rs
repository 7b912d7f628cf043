//! `stylet validate`: scenes beside published measurements.

use std::fs;
use std::path::{Path, PathBuf};

use ::bench::report::{SceneDossier, make_dossiers, make_shipped_dossiers, write_dossier_text, write_dossiers};
use documents::Scene;

use crate::exit::{Failure, Outcome};
use crate::{output, sources};

/// Hold scenes beside what others have measured
///
/// Every published figure that can be cited stands beside what a scene gives: inside, outside, one value without a spread, or not
/// comparable, and why; with its source, its DOI, and whether it was read or recalled. Nothing is tuned to pass. Prints Markdown;
/// with --out, dossier.md, dossier.csv and dossier.svg are written.
#[derive(clap::Args)]
#[command(after_help = "Examples:\n  \
    stylet validate --out dossier\n  \
    stylet validate curricula/scenes/epidural-71kg.toml")]
pub struct ValidateArgs {
    /// The scenes [default: every shipped one]
    #[arg(value_name = "SCENE.toml")]
    scenes: Vec<PathBuf>,
    /// Folder for the dossier; created if need be, an older one in it is replaced
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
}

/// Runs the command.
pub fn run(args: &ValidateArgs) -> Outcome {
    let dossiers = dossiers_of(&args.scenes)?;
    let Some(folder) = &args.out else {
        let text = write_dossier_text(&dossiers);
        return output::print_buffered(|out| write!(out, "{text}"));
    };
    fs::create_dir_all(folder).map_err(|error| Failure::refused(folder, format_args!("cannot be created: {error}")))?;
    for written in write_dossiers(&dossiers, folder)? {
        output::print_line(format_args!("{}", written.display()))?;
    }
    Ok(())
}

fn dossiers_of(files: &[PathBuf]) -> Result<Vec<SceneDossier>, Failure> {
    if files.is_empty() {
        return Ok(make_shipped_dossiers()?);
    }
    let scenes = files.iter().map(|file| read_scene(file)).collect::<Result<Vec<_>, _>>()?;
    Ok(make_dossiers(&scenes))
}

fn read_scene(file: &Path) -> Result<Scene, Failure> {
    Ok(documents::load::read_scene_text(file, &sources::read_text(file)?)?)
}
