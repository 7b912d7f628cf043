//! `stylet check`: documents, their soundness, and what simulating them comes to.

mod plan;
mod report;

use std::path::{Path, PathBuf};

use scene::Document;

use crate::exit::{Failure, Outcome};
use crate::output;
use report::FileReport;

/// Validate scenes, exercises and curricula, and print what simulating them comes to
///
/// Lists every issue of every file with its line and column. Refuses unsound scenes, whose ruptures would raise the
/// force or the elastic energy, and names the largest sound threshold. Prints the layers, the spread between patients and
/// the closed-form ruptures of each exercise. Exit 0 when all is well, 1 when anything was found.
#[derive(clap::Args)]
#[command(after_help = "Example:\n  stylet check curricula/scenes/*.toml curricula/lower-back-basics/course.toml")]
pub struct Args {
    /// The documents
    #[arg(value_name = "FILE", required = true)]
    files: Vec<PathBuf>,
    /// Print the result as JSON
    #[arg(long)]
    json: bool,
}

/// Runs the command.
pub fn run(args: &Args) -> Outcome {
    if let Some(missing) = args.files.iter().find(|file| !file.is_file()) {
        return Err(Failure::refused(missing, "cannot be read: no such file; a document is needed"));
    }
    let reports: Vec<FileReport> = args.files.iter().map(|file| check(file)).collect();
    match args.json {
        true => output::json(&reports)?,
        false => output::with(|out| reports.iter().try_for_each(|report| report.write(out)))?,
    }
    for line in reports.iter().flat_map(|report| &report.issues) {
        output::error(line);
    }
    if reports.iter().all(|report| report.ok) { Ok(()) } else { Err(Failure::Found) }
}

fn check(file: &Path) -> FileReport {
    let name = file.display().to_string();
    match scene::check(file) {
        Err(refused) => FileReport::refused(name, refused.issues.iter().map(ToString::to_string).collect()),
        Ok(Document::Scene(scene)) => FileReport::sound(name, "scene", &scene.id, vec![plan::Plan::of_scene(&scene)]),
        Ok(Document::Exercise(bundle)) => {
            FileReport::sound(name, "exercise", &bundle.exercise.id, vec![plan::Plan::of_exercise(&bundle)])
        }
        Ok(Document::Curriculum(curriculum, bundles)) => {
            let plans = bundles.iter().map(plan::Plan::of_exercise).collect();
            FileReport::sound(name, "curriculum", &curriculum.id, plans)
        }
    }
}
