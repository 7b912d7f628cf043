//! `stylet score`: metrics, score and deductions of a recording.

use std::io::{self, Write};
use std::path::PathBuf;

use assessment::words::{deduction_in_words, failure_in_words};
use assessment::{AssessError, Assessment, Direction, Metric, Void, VoidAnswer};
use documents::ExerciseBundle;

use crate::exit::{Failure, Outcome};
use crate::{output, sources};

/// Score a recorded attempt: metrics, score and deductions
///
/// Everything is computed from the recording alone, with the exercise it contains or another one.
/// An attempt in which the device was lost, or the tissue's force did not reach the hand for more
/// than a tenth of the time in the body, is void: exit status 1.
#[derive(clap::Args)]
#[command(after_help = "Examples:\n  stylet score attempt.mcap\n  stylet score attempt.mcap --json | jq .score")]
pub struct ScoreArgs {
    /// The recording
    #[arg(value_name = "REC.mcap")]
    recording: PathBuf,
    /// Score with this exercise instead of the recorded one
    #[arg(long, value_name = "E.toml")]
    exercise: Option<PathBuf>,
    /// Print the result as JSON
    #[arg(long)]
    json: bool,
}

/// Runs the command.
pub fn run(args: &ScoreArgs) -> Outcome {
    let recording = sources::read_recording(&args.recording)?;
    let bundle = match &args.exercise {
        Some(path) => ExerciseBundle::read(path)?,
        None => sources::own_exercise(&args.recording, &recording)?,
    };
    let judged = match assessment::assess(&recording, &bundle) {
        Ok(judged) => judged,
        Err(AssessError::Void(why)) => return void(&why, args.json),
        Err(error) => return Err(Failure::refused(&args.recording, error)),
    };
    match args.json {
        true => output::print_json(&judged),
        false => output::print_buffered(|out| report(&bundle, &judged, out)),
    }
}

/// Prints a void attempt, which carries no information about the trainee.
fn void(why: &Void, as_json: bool) -> Outcome {
    match as_json {
        true => output::print_json(&VoidAnswer::from(why))?,
        false => output::print_buffered(|out| writeln!(out, "Void, does not count: {why}"))?,
    }
    Err(Failure::Found)
}

fn report(bundle: &ExerciseBundle, judged: &Assessment, out: &mut dyn Write) -> io::Result<()> {
    let (exercise, verdict) = (&bundle.exercise, if judged.passed { "passed" } else { "not passed" });
    writeln!(out, "{} ({})", exercise.title, exercise.id)?;
    writeln!(out, "Score {:.1} of 100, {verdict} (pass mark {})", judged.score, exercise.pass_mark)?;
    for failure in &judged.hard_fails {
        writeln!(out, "Failed regardless of the score: {}", failure_in_words(failure))?;
    }
    writeln!(out, "\n{:>8}  Rubric", "Points")?;
    for deduction in &judged.deductions {
        // Adding zero turns the −0 of a deduction of zero points into 0.
        let metric = named(&deduction.metric, deduction.version);
        writeln!(out, "{:>8.1}  {metric}: {}", 0.0 - deduction.points + 0.0, deduction_in_words(deduction))?;
    }
    writeln!(out, "\n{:>12} {:8}  Metric", "Value", "Unit")?;
    for metric in &judged.metrics {
        writeln!(out, "{:>12} {:8}  {}", shown(metric), metric.unit, described(metric))?;
    }
    writeln!(out, "\nSimulated competence; not a clinical claim. Thresholds are the exercise author's.")
}

/// The value at a readable precision, or "n/a".
fn shown(metric: &Metric) -> String {
    match metric.value {
        Some(value) if metric.applies => format!("{value:.3}"),
        _ => "n/a".to_owned(),
    }
}

/// Id, name and direction of improvement.
fn described(metric: &Metric) -> String {
    let better = match metric.direction {
        Direction::Lower => "lower is better",
        Direction::Higher => "higher is better",
        Direction::Range => "closer to 0 is better",
    };
    let named = named(&metric.id, metric.version);
    match metric.label.as_str() {
        "" => format!("{named} ({better})"),
        label => format!("{named} – {label} ({better})"),
    }
}

/// The id, followed by the version if it is not the first.
fn named(id: &str, version: u32) -> String {
    if version > 1 { format!("{id}, version {version}") } else { id.to_owned() }
}
