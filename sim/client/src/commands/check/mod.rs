//! `stylet check`: checks documents, their soundness, and the plan of their simulation.

mod plan;
mod report;
mod seeds;
mod tissue;

use std::path::{Path, PathBuf};

use assessment::appraise_rubric;
use documents::{Document, ExerciseBundle, Issue};
use plan::ScenePlan;
use report::FileReport;

use crate::exit::{Failure, Outcome};
use crate::output;

/// Validate scenes, exercises, curricula and instruments, and print the plan of their simulation
///
/// Lists every issue of every file with its line and column. Rejects unsound scenes, whose ruptures
/// would raise the force or the elastic energy, and prints the largest sound threshold. Prints the
/// layers, the spread between patients and the closed-form ruptures of each exercise, and the plan
/// of its tissue: model, unknowns, bytes, expected error, cost. If a planned path meets bone before
/// the target, prints the bone, the depth and the nearest free angle. Tests the rubric of each
/// exercise with an untouched needle, pricks, a lunge, and an attempt that is not confirmed or not
/// withdrawn: a rubric that gives points for these is a finding, as are lines that reward the worse
/// value and metrics that no rubric should use. Exits with status 0 without findings, otherwise 1.
#[derive(clap::Args)]
#[command(after_help = "Example:\n  stylet check curricula/scenes/*.toml curricula/lower-back-basics/course.toml")]
pub struct CheckArgs {
    /// The documents
    #[arg(value_name = "FILE", required = true)]
    files: Vec<PathBuf>,
    /// Check one exercise on a body with each patient of the seeds 1 to N, and list the seeds for
    /// which it can be done
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=1000))]
    seeds: Option<u32>,
    /// Print the result as JSON
    #[arg(long)]
    json: bool,
}

/// Runs the command.
pub fn run(args: &CheckArgs) -> Outcome {
    if let Some(missing) = args.files.iter().find(|file| !file.is_file()) {
        return Err(Failure::refused(missing, "cannot be read: no such file"));
    }
    if let Some(most) = args.seeds {
        return seeds::run(&args.files, most, args.json);
    }
    let reports: Vec<FileReport> = args.files.iter().map(|file| check(file)).collect();
    match args.json {
        true => output::print_json(&reports)?,
        false => output::print_buffered(|out| reports.iter().try_for_each(|report| report.write(out)))?,
    }
    for report in &reports {
        for plan in &report.plans {
            for warning in plan.warnings.iter().cloned().chain(plan.tissue.warning().map(|warning| warning.to_string()))
            {
                output::print_warning(format_args!("{}: {warning}", report.file));
            }
        }
    }
    for line in reports.iter().flat_map(|report| &report.issues) {
        output::print_error(line);
    }
    if reports.iter().all(|report| report.ok) { Ok(()) } else { Err(Failure::Found) }
}

fn check(file: &Path) -> FileReport {
    let name = file.display().to_string();
    let document = match documents::check_documents(file) {
        Err(refused) => return FileReport::refused(name, lines(&refused.issues)),
        Ok(document) => document,
    };
    let (kind, id, plans) = match &document {
        Document::Scene(scene) => ("scene", &scene.id, ScenePlan::of_scene(scene).map(|plan| vec![plan])),
        Document::Exercise(bundle) => {
            ("exercise", &bundle.exercise.id, ScenePlan::of_exercise(bundle).map(|plan| vec![plan]))
        }
        Document::Curriculum(curriculum, bundles) => {
            ("curriculum", &curriculum.id, bundles.iter().map(ScenePlan::of_exercise).collect())
        }
        Document::Instrument(instrument) => ("instrument", &instrument.id, Ok(Vec::new())),
    };
    match plans {
        Ok(plans) => FileReport::read(name, kind, id, plans, rubrics(file, &document)),
        Err(why) => FileReport::refused(name, vec![format!("{}: {why}", file.display())]),
    }
}

fn lines(issues: &[Issue]) -> Vec<String> {
    issues.iter().map(ToString::to_string).collect()
}

/// Issues of the rubrics of a document.
fn rubrics(file: &Path, document: &Document) -> Vec<String> {
    let of = |file: &Path, bundle: &ExerciseBundle| {
        let file = file.display().to_string();
        let remarks = appraise_rubric(bundle).map_err(|why| vec![format!("{file}: {why}")]);
        let issues =
            remarks.and_then(|remarks| bundle.place(&file, &remarks).map_err(|refused| lines(&refused.issues)));
        issues.map_or_else(|lines| lines, |issues| lines(&issues))
    };
    match document {
        Document::Exercise(bundle) => of(file, bundle),
        Document::Curriculum(curriculum, bundles) => {
            let exercises = curriculum.entries.iter().zip(bundles);
            exercises.flat_map(|(entry, bundle)| of(&documents::load::path_beside(file, &entry.file), bundle)).collect()
        }
        Document::Scene(_) | Document::Instrument(_) => Vec::new(),
    }
}
