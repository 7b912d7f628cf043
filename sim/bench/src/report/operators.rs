//! Virtual hands on the shipped exercises: forces, overshoots and scores of each preset, with their
//! spread.

use std::path::{Path, PathBuf};

use assessment::{Assessment, Tryout};
use documents::{ExerciseBundle, Patient};
use law::operator::{Operator, Skill};

use super::sheet::{self, ReportSheet};
use super::{Subject, measured_on, quantile, specimen};
use crate::error::BenchError;
use crate::progress::MeasurementProgress;

/// Number of attempts of each preset at each exercise in a report, and in a shortened one.
const SEEDS: [u64; 2] = [30, 5];

/// Smallest score of 100 that counts as perfect.
const PERFECT: f64 = 99.99;

/// A quantity of an attempt: name with unit, and function that reads it.
type Figure = (&'static str, fn(&ExerciseBundle, &Assessment) -> Option<f64>);

const FIGURES: [Figure; 7] = [
    ("peak force N", |_, judged| judged.value("peak_force_n")),
    ("overshoot of the skin mm", |bundle, judged| judged.value(&overshoot_of_the_skin(bundle))),
    ("largest overshoot mm", |_, judged| judged.value("over_insertion_mm")),
    ("beyond the target mm", |_, judged| judged.value("overshoot_mm")),
    ("error of depth mm", |_, judged| judged.value("depth_error_mm").map(f64::abs)),
    ("time s", |_, judged| judged.value("time_total_s")),
    ("score", |_, judged| Some(judged.score)),
];

/// The result of an attempt.
struct Performed {
    judged: Assessment,
    furthest_mm: f64,
}

/// A preset at an exercise.
#[derive(Clone)]
struct OperatorRow {
    exercise: String,
    preset: &'static str,
    needle_mm: f64,
    furthest_mm: f64,
    /// Number of attempts that passed, and that scored 100.
    passed: usize,
    perfect: usize,
    /// For each quantity: 10 % quantile, median, 90 % quantile.
    figures: Vec<[f64; 3]>,
}

/// Simulates every preset on every shipped exercise and writes `operators.{csv,md}`; returns the
/// files written.
///
/// # Errors
/// On an I/O error, and, after the report has been written, if a needle was inserted beyond its
/// hub.
pub fn measure(out: &Path, quick: bool) -> Result<Vec<PathBuf>, BenchError> {
    let [whole, shortened] = SEEDS;
    let seeds = if quick { shortened } else { whole };
    let exercises = specimen::read_shipped_exercises()?;
    let progress = MeasurementProgress::new(3 * exercises.len() as u64, "operators");
    let of = |bundle: &ExerciseBundle| -> Result<Vec<OperatorRow>, BenchError> {
        let presets =
            [("novice", Skill::novice()), ("intermediate", Skill::intermediate()), ("expert", Skill::expert())];
        let row = |(preset, skill): (&'static str, Skill)| {
            let row = row(bundle, preset, &skill, seeds);
            progress.advance(1);
            row
        };
        presets.into_iter().map(row).collect()
    };
    let rows = at_once(&exercises, &of)?;
    let table = out.join("operators.csv");
    csv(&rows).write_csv(&table)?;
    let text = sheet::write_text(out.join("operators.md"), &markdown(&rows, seeds, quick))?;
    let beyond: Vec<String> = rows.iter().filter(|row| row.furthest_mm > row.needle_mm).map(said).collect();
    if beyond.is_empty() { Ok(vec![table, text]) } else { Err(BenchError::Work(beyond)) }
}

fn said(row: &OperatorRow) -> String {
    let OperatorRow { exercise, preset, needle_mm, furthest_mm, .. } = row;
    format!("{exercise}: the {preset} went {furthest_mm} mm in with a needle of {needle_mm} mm")
}

/// Measures the exercises in parallel; returns them in their order.
fn at_once(
    exercises: &[ExerciseBundle],
    of: &(impl Fn(&ExerciseBundle) -> Result<Vec<OperatorRow>, BenchError> + Sync),
) -> Result<Vec<OperatorRow>, BenchError> {
    std::thread::scope(|scope| {
        let threads: Vec<_> = exercises.iter().map(|bundle| scope.spawn(move || of(bundle))).collect();
        let rows = threads.into_iter().map(|thread| thread.join().map_err(|_| BenchError::work("a thread stopped"))?);
        Ok(rows.collect::<Result<Vec<_>, _>>()?.concat())
    })
}

/// Returns the metric of the last pop at the skin.
fn overshoot_of_the_skin(bundle: &ExerciseBundle) -> String {
    let last = if bundle.scene.needle.tip_to_rim_mm > 0.0 { "rim" } else { "tip" };
    let skin = bundle.scene.layers.first().map_or("", |layer| layer.name.as_str());
    format!("over_insertion_mm.{skin}.{last}")
}

fn row(bundle: &ExerciseBundle, preset: &'static str, skill: &Skill, seeds: u64) -> Result<OperatorRow, BenchError> {
    let trials = (0..seeds).map(|seed| performed(bundle, skill, seed)).collect::<Result<Vec<_>, _>>()?;
    let spread = |(_, of): &Figure| {
        let values: Vec<f64> = trials.iter().filter_map(|trial| of(bundle, &trial.judged)).collect();
        [0.1, 0.5, 0.9].map(|share| quantile(&values, share))
    };
    Ok(OperatorRow {
        exercise: bundle.exercise.id.clone(),
        preset,
        needle_mm: bundle.scene.needle.length_mm,
        furthest_mm: trials.iter().map(|trial| trial.furthest_mm).fold(0.0, f64::max),
        passed: trials.iter().filter(|trial| trial.judged.passed).count(),
        perfect: trials.iter().filter(|trial| trial.judged.score > PERFECT).count(),
        figures: FIGURES.iter().map(spread).collect(),
    })
}

fn performed(bundle: &ExerciseBundle, skill: &Skill, seed: u64) -> Result<Performed, BenchError> {
    let tryout = Tryout::new(bundle, Patient::draw(&bundle.scene, seed)).map_err(BenchError::work)?;
    let recording = tryout.perform(&mut Operator::skilled(skill, &bundle.plan(), seed));
    let furthest_mm = recording.samples.iter().map(|sample| 1e3 * sample.x_m).fold(0.0, f64::max);
    Ok(Performed { judged: tryout.judge(&recording).map_err(BenchError::work)?, furthest_mm })
}

fn csv(rows: &[OperatorRow]) -> ReportSheet {
    let columns = FIGURES.iter().flat_map(|(name, _)| {
        ["tenth", "median", "nine_tenths"].map(|share| format!("{}_{share}", name.replace(' ', "_").to_lowercase()))
    });
    let head = ["exercise", "preset", "furthest_mm", "needle_mm", "passed", "perfect"].map(str::to_owned);
    let mut sheet = ReportSheet::new(head.into_iter().chain(columns));
    for row in rows {
        let counts = [row.passed.to_string(), row.perfect.to_string()];
        let lengths = [row.furthest_mm.to_string(), row.needle_mm.to_string()];
        let head = [row.exercise.clone(), row.preset.to_owned()].into_iter().chain(lengths).chain(counts);
        sheet.row(head.chain(row.figures.iter().flatten().map(f64::to_string)));
    }
    sheet
}

/// Returns the expert's median peak force at an exercise, in N.
fn expert_n(rows: &[OperatorRow], exercise: &str) -> f64 {
    let expert = rows.iter().find(|row| row.exercise == exercise && row.preset == "expert");
    expert.and_then(|row| row.figures.first()).map_or(f64::NAN, |[_, median, _]| *median)
}

fn markdown(rows: &[OperatorRow], seeds: u64, quick: bool) -> String {
    let head = ["exercise", "preset", "peak to the expert's"].into_iter();
    let mut sheet =
        ReportSheet::new(head.chain(FIGURES.iter().map(|(name, _)| *name)).chain(["passed", "perfect", "furthest mm"]));
    for row in rows {
        let peak_n = row.figures.first().map_or(f64::NAN, |[_, median, _]| *median);
        let ratio = format!("{:.2}", peak_n / expert_n(rows, &row.exercise));
        let figures = row.figures.iter().map(|[low, median, high]| format!("{median:.1} ({low:.1} to {high:.1})"));
        let head = [row.exercise.clone(), row.preset.to_owned(), ratio].into_iter();
        let counts = [row.passed, row.perfect].map(|count| count.to_string());
        let reach = format!("{:.0} of {:.0}", row.furthest_mm, row.needle_mm);
        sheet.row(head.chain(figures).chain(counts).chain([reach]));
    }
    format!(
        "# Virtual operators\n\n{}\n\n{seeds} attempts of each preset at each shipped exercise, by as many people on as many \
         patients: the median, and between which values eight of ten lie. Overshoot: furthest advance in the second after a \
         boundary gave way to the last part of the needle; the largest is that of any boundary. *Passed* and *perfect* count \
         attempts that pass, and that score 100. `sim/law/src/operator/mod.rs` describes what the presets were fitted to, and its \
         sources: relaxed hands overshoot the skin by 5 to 14 mm, normal ones by 2 to 5 mm, braced ones by 0.8 to 1.5 mm (with the \
         reference needle).\n\nThe peaks differ less than those of people. A boundary gives way at its threshold, whichever hand \
         pushes: where the hardest boundary lies before the target, all hands reach the same peak, and only drag distinguishes \
         them. A novice's peak is higher where overshooting meets a harder boundary behind the target, as at stop-in-the-fat, and \
         where the hardest boundary gives way at a dent, so that it withstands more the faster it is met: the ligamentum flavum of \
         the scenes made of a body.\n\n{}",
        measured_on(Subject::Operators, quick),
        sheet.markdown()
    )
}
