//! `stylet check --seeds`: the patients on whom an exercise on a body can be done.

use std::path::{Path, PathBuf};

use assessment::appraise_rubric;
use documents::load::path_beside;
use documents::{Document, ExerciseBundle};
use serde::Serialize;
use toml::Table;

use crate::exit::{Failure, Outcome};
use crate::output;
use crate::progress::Progress;

/// A patient, and the reasons why the exercise cannot be done on it.
#[derive(Serialize)]
struct SeedReport {
    seed: u32,
    /// Findings of the check; empty if the exercise can be done.
    issues: Vec<String>,
}

/// Checks the one exercise of `files` with each patient of the seeds 1 to `most`.
pub fn run(files: &[PathBuf], most: u32, json: bool) -> Outcome {
    let [file] = files else { return Err(Failure::input("--seeds checks one exercise: name one file")) };
    let Document::Exercise(bundle) = documents::load::read_document(file)? else {
        return Err(Failure::refused(file, "not an exercise: --seeds checks one exercise"));
    };
    let texts = Texts::read(file, &bundle)?;
    let progress = Progress::new(u64::from(most), "checking");
    let mut reports = Vec::new();
    for seed in 1..=most {
        progress.set(u64::from(seed - 1));
        reports.push(SeedReport { seed, issues: texts.check(seed)? });
    }
    drop(progress);
    let good: Vec<String> =
        reports.iter().filter(|report| report.issues.is_empty()).map(|report| report.seed.to_string()).collect();
    if json {
        output::print_json(&reports)?;
    } else {
        for report in reports.iter().filter(|report| !report.issues.is_empty()) {
            output::print_line(format_args!("seed {}: {}", report.seed, report.issues.join("; ")))?;
        }
        output::print_line(format_args!("{} of {most} seeds can be done: {}", good.len(), good.join(", ")))?;
    }
    if good.is_empty() { Err(Failure::Found) } else { Ok(()) }
}

/// An exercise and its scene as written.
struct Texts {
    exercise: String,
    scene: Table,
}

impl Texts {
    fn read(file: &Path, bundle: &ExerciseBundle) -> Result<Self, Failure> {
        let read = |path: &Path| std::fs::read_to_string(path).map_err(|error| Failure::refused(path, error));
        let path = path_beside(file, &bundle.exercise.scene);
        let scene: Table = read(&path)?.parse().map_err(|error| Failure::refused(&path, error))?;
        if !scene.contains_key("anatomy") {
            return Err(Failure::refused(&path, "no [anatomy]: only a body has other patients"));
        }
        let mut exercise: Table = read(file)?.parse().map_err(|error| Failure::refused(file, error))?;
        // The pictures of a briefing are files next to the exercise, and show one patient only.
        exercise.remove("picture");
        Ok(Self { exercise: exercise.to_string(), scene })
    }

    /// Returns the findings of the check with another patient.
    fn check(&self, seed: u32) -> Result<Vec<String>, Failure> {
        let mut scene = self.scene.clone();
        if let Some(anatomy) = scene.get_mut("anatomy").and_then(toml::Value::as_table_mut) {
            anatomy.insert("seed".to_owned(), i64::from(seed).into());
        }
        let bundle = match ExerciseBundle::from_texts(&self.exercise, &scene.to_string()) {
            Ok(bundle) => bundle,
            Err(refused) => return Ok(reasons(&refused.issues)),
        };
        let unsound = bundle.unsound()?;
        if !unsound.is_empty() {
            return Ok(reasons(&unsound));
        }
        let remarks = appraise_rubric(&bundle).map_err(Failure::work)?;
        Ok(remarks.iter().map(|remark| format!("{}: {}", remark.field, remark.found)).collect())
    }
}

/// Returns issues without line and column, which refer to a generated document.
fn reasons(issues: &[documents::Issue]) -> Vec<String> {
    issues.iter().map(|issue| format!("{}: {}", issue.field, issue.found)).collect()
}
