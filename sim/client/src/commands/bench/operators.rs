//! Virtual hands at the shipped exercises: forces and overshoots of each preset, with their spread.

use std::path::{Path, PathBuf};

use mechanics::axial::Contactor;
use mechanics::operator::{Operator, Skill};
use mechanics::puncture::PunctureParams;
use mechanics::trials::{Performance, perform};
use scene::{ExerciseBundle, Patient};

use super::sheet::{self, Sheet};
use super::{What, measured_on, quantile, specimen};
use crate::exit::Failure;
use crate::progress::Progress;

/// Attempts of each preset at each exercise in a report, and in a shortened one.
const SEEDS: [u64; 2] = [40, 5];

/// What is measured of an attempt: a name with its unit, and how it is read from the attempt.
type Figure = (&'static str, fn(&ExerciseBundle, &Performance) -> Option<f64>);

const FIGURES: [Figure; 6] = [
    ("peak force N", |_, attempt| Some(attempt.peak_n)),
    ("overshoot of the skin mm", |bundle, attempt| Some(1e3 * attempt.overshoot_m(0, last(bundle))?)),
    ("largest overshoot mm", |_, attempt| {
        let lunges = attempt.lunges.iter().map(|lunge| 1e3 * lunge.overshoot_m);
        lunges.max_by(f64::total_cmp)
    }),
    ("beyond the target mm", |bundle, attempt| {
        Some((1e3 * attempt.furthest_m - bundle.exercise.target_depth_mm).max(0.0))
    }),
    ("error of depth mm", |bundle, attempt| Some((1e3 * attempt.confirmed_m? - bundle.exercise.target_depth_mm).abs())),
    ("time s", |_, attempt| Some(attempt.duration_s)),
];

/// A preset at an exercise.
struct Row {
    exercise: String,
    preset: &'static str,
    needle_mm: f64,
    furthest_mm: f64,
    /// Per figure: a tenth, the median, nine tenths.
    figures: Vec<[f64; 3]>,
}

/// Lets every preset perform every shipped exercise, and writes `operators.{csv,md}`; returns the files written.
///
/// # Errors
/// When the disk refuses, and, once the report is written, when a hand went in beyond its needle's hub.
pub fn measure(out: &Path, quick: bool) -> Result<Vec<PathBuf>, Failure> {
    let [whole, shortened] = SEEDS;
    let seeds = if quick { shortened } else { whole };
    let exercises = specimen::exercises()?;
    let progress = Progress::new(3 * exercises.len() as u64, "operators");
    let mut rows = Vec::new();
    for bundle in &exercises {
        let presets =
            [("novice", Skill::novice()), ("intermediate", Skill::intermediate()), ("expert", Skill::expert())];
        for (preset, skill) in presets {
            rows.push(row(bundle, (preset, &skill), seeds)?);
            progress.advance(1);
        }
    }
    let table = out.join("operators.csv");
    csv(&rows).write_csv(&table)?;
    let text = sheet::write_text(out.join("operators.md"), &markdown(&rows, seeds, quick))?;
    let beyond: Vec<String> = rows.iter().filter(|row| row.furthest_mm > row.needle_mm).map(said).collect();
    if beyond.is_empty() { Ok(vec![table, text]) } else { Err(Failure::Work(beyond)) }
}

fn said(row: &Row) -> String {
    let Row { exercise, preset, needle_mm, furthest_mm, .. } = row;
    format!("{exercise}: the {preset} went {furthest_mm} mm in with a needle of {needle_mm} mm")
}

/// The part of the needle whose pop at the skin is the last.
fn last(bundle: &ExerciseBundle) -> Contactor {
    if bundle.scene.needle.tip_to_rim_mm > 0.0 { Contactor::Rim } else { Contactor::Tip }
}

fn row(bundle: &ExerciseBundle, (preset, skill): (&'static str, &Skill), seeds: u64) -> Result<Row, Failure> {
    let attempts = (0..seeds).map(|seed| attempt(bundle, skill, seed)).collect::<Result<Vec<_>, _>>()?;
    let spread = |(_, of): &Figure| {
        let values: Vec<f64> = attempts.iter().filter_map(|attempt| of(bundle, attempt)).collect();
        [0.1, 0.5, 0.9].map(|share| quantile(&values, share))
    };
    Ok(Row {
        exercise: bundle.exercise.id.clone(),
        preset,
        needle_mm: bundle.scene.needle.length_mm,
        furthest_mm: attempts.iter().map(|attempt| 1e3 * attempt.furthest_m).fold(0.0, f64::max),
        figures: FIGURES.iter().map(spread).collect(),
    })
}

fn attempt(bundle: &ExerciseBundle, skill: &Skill, seed: u64) -> Result<Performance, Failure> {
    let spec = bundle.puncture_spec(&Patient::draw(&bundle.scene, seed));
    let params = PunctureParams::new(spec).map_err(Failure::work)?;
    let mut operator = Operator::skilled(skill, &bundle.plan(), seed);
    Ok(perform(&params, &mut operator, bundle.exercise.time_limit_s))
}

fn csv(rows: &[Row]) -> Sheet {
    let columns = FIGURES.iter().flat_map(|(name, _)| {
        ["tenth", "median", "nine_tenths"].map(|share| format!("{}_{share}", name.replace(' ', "_").to_lowercase()))
    });
    let head = ["exercise", "preset", "furthest_mm", "needle_mm"].map(str::to_owned);
    let mut sheet = Sheet::new(head.into_iter().chain(columns));
    for row in rows {
        let head =
            [row.exercise.clone(), row.preset.to_owned(), row.furthest_mm.to_string(), row.needle_mm.to_string()];
        sheet.row(head.into_iter().chain(row.figures.iter().flatten().map(f64::to_string)));
    }
    sheet
}

/// The expert's median peak at an exercise, in N.
fn expert_n(rows: &[Row], exercise: &str) -> f64 {
    let expert = rows.iter().find(|row| row.exercise == exercise && row.preset == "expert");
    expert.and_then(|row| row.figures.first()).map_or(f64::NAN, |[_, median, _]| *median)
}

fn markdown(rows: &[Row], seeds: u64, quick: bool) -> String {
    let head = ["exercise", "preset", "peak to the expert's"].into_iter();
    let mut sheet = Sheet::new(head.chain(FIGURES.iter().map(|(name, _)| *name)).chain(["furthest mm"]));
    for row in rows {
        let peak_n = row.figures.first().map_or(f64::NAN, |[_, median, _]| *median);
        let ratio = format!("{:.2}", peak_n / expert_n(rows, &row.exercise));
        let figures = row.figures.iter().map(|[low, median, high]| format!("{median:.1} ({low:.1} to {high:.1})"));
        let head = [row.exercise.clone(), row.preset.to_owned(), ratio].into_iter();
        sheet.row(head.chain(figures).chain([format!("{:.0} of {:.0}", row.furthest_mm, row.needle_mm)]));
    }
    format!(
        "# Virtual operators\n\n{}\n\n{seeds} attempts of each preset at each shipped exercise, by as many people on as many \
         patients: the median, and between which values eight of ten lie. Overshoot: furthest advance in the second after a boundary \
         gave way to the last part of the needle; the largest is that of any boundary. What the presets were fitted to, and what was \
         read for it, is told in `sim/mechanics/src/operator/mod.rs`: relaxed hands overshoot the skin by 5 to 14 mm, normal ones by 2 to \
         5 mm, braced ones by 0.8 to 1.5 mm (with the reference needle).\n\n\
         The peaks say less than people's do. A boundary gives way at its threshold, whoever pushes: where the hardest boundary lies \
         before the target, everybody meets the same peak, and only drag is left to tell hands apart. A novice's peak is higher where \
         overshooting meets a harder boundary behind the target.\n\n{}",
        measured_on(What::Operators, quick),
        sheet.markdown()
    )
}
