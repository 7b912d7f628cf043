//! `stylet validate`: compares scenes with published measurements.

use std::fs;
use std::path::{Path, PathBuf};

use documents::Scene;
use dossier::{
    CURVE_AXES, CurveWords, describe_line, draw_dossier, draw_force_curve, make_dossiers, read_shipped_scenes,
    write_dossier_table, write_dossier_text,
};

use crate::exit::{Failure, Outcome};
use crate::{output, sources};

/// Compare scenes with published measurements
///
/// Compares every published figure that can be cited with the value of a scene: inside, outside, one
/// value without a spread, or not comparable, with the reason; with its source, its DOI, and
/// whether it was read or recalled. A figure judges scenes of the family of needles that it was
/// measured with. Prints Markdown; with --out, writes dossier.md, dossier.csv, dossier.svg and, for
/// each scene, its force against depth with the published ranges.
#[derive(clap::Args)]
#[command(after_help = "Examples:\n  \
    stylet validate --out dossier\n  \
    stylet validate curricula/scenes/epidural-71kg.toml")]
pub struct ValidateArgs {
    /// The scenes [default: all shipped ones]
    #[arg(value_name = "SCENE.toml")]
    scenes: Vec<PathBuf>,
    /// Folder for the dossier; created if it does not exist; an existing dossier in it is replaced
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
}

/// Runs the command.
pub fn run(args: &ValidateArgs) -> Outcome {
    let scenes = if args.scenes.is_empty() {
        read_shipped_scenes()?
    } else {
        args.scenes.iter().map(|file| read_scene(file)).collect::<Result<Vec<_>, _>>()?
    };
    let dossiers = make_dossiers(&scenes);
    let Some(folder) = &args.out else {
        let text = write_dossier_text(&dossiers);
        return output::print_buffered(|out| write!(out, "{text}"));
    };
    fs::create_dir_all(folder).map_err(|error| Failure::refused(folder, format_args!("cannot be created: {error}")))?;
    let mut text = format!("{}\n## Force against depth\n\n", write_dossier_text(&dossiers));
    text.push_str("Green and orange bars: the accepted range of a force, inside and outside; blue wedge: the published slope.\n\n");
    let words = CurveWords { axes: CURVE_AXES, name_layer: &str::to_owned, describe: &describe_line };
    for (scene, dossier) in scenes.iter().zip(&dossiers) {
        let name = format!("force-{}.svg", scene.id);
        write_file(&folder.join(&name), draw_force_curve(scene, &dossier.lines, &words))?;
        text.push_str(&format!("### {}\n\n![Force against depth of {}]({name})\n\n", scene.title, scene.id));
    }
    text.push_str("## All scenes\n\n![The scenes' values relative to the published ranges](dossier.svg)\n");
    write_file(&folder.join("dossier.md"), text)?;
    write_file(&folder.join("dossier.csv"), write_dossier_table(&dossiers).map_err(Failure::work)?)?;
    write_file(&folder.join("dossier.svg"), draw_dossier(&dossiers))
}

fn read_scene(file: &Path) -> Result<Scene, Failure> {
    Ok(documents::load::read_scene_text(file, &sources::read_text(file)?)?)
}

/// Writes a file and prints its path.
fn write_file(file: &Path, contents: impl AsRef<[u8]>) -> Outcome {
    fs::write(file, contents).map_err(|error| Failure::work(format_args!("{}: {error}", file.display())))?;
    output::print_line(format_args!("{}", file.display()))
}
