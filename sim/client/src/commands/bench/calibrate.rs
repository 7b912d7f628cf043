//! Fits of curves whose truth is known: how often a 95 % interval holds it, how often there is none, and wrong minima.

use std::path::{Path, PathBuf};

use mechanics::axial::AxialSpec;
use mechanics::calibrate::{QUANTITIES, Quantity, Standing};
use mechanics::trials::calibration::{Disturbance, Judged, Measurement, Origin, Trialled, sample, try_fit};
use scene::Patient;

use super::sheet::{self, Sheet};
use super::{What, measured_on, quantile, specimen};
use crate::clock;
use crate::exit::Failure;
use crate::progress::Progress;

/// Curves of a group; a shortened report has this part of them.
const CURVES: u64 = 240;
const QUICK_PART: u64 = 40;
/// The least share of intervals that must hold the truth.
const COVERAGE: f64 = 0.9;

/// Curves of one kind.
struct Group {
    name: &'static str,
    disturbance: Disturbance,
    from: From,
}

/// Where a group's layers come from.
enum From {
    Random { tip_to_rim_m: f64 },
    Shipped(Vec<AxialSpec>),
}

/// What came of a curve: the fit beside the truth, or why there is none.
struct Row {
    group: &'static str,
    seed: u64,
    measurement: Measurement,
    layers: usize,
    seconds: f64,
    outcome: Result<Trialled, String>,
}

/// How often a parameter's interval held the truth.
#[derive(Default)]
struct Tally {
    held: usize,
    missed: usize,
    open: usize,
    kept: usize,
}

impl Tally {
    fn count(&mut self, judged: &Judged) {
        match judged.is_held() {
            Some(true) => self.held += 1,
            Some(false) => self.missed += 1,
            None if judged.estimate.standing == Standing::Kept => self.kept += 1,
            None => self.open += 1,
        }
    }

    fn coverage(&self) -> f64 {
        self.held as f64 / (self.held + self.missed) as f64
    }
}

impl Row {
    fn trialled(&self) -> Option<&Trialled> {
        self.outcome.as_ref().ok()
    }

    fn is_silent(&self) -> bool {
        self.trialled().is_some_and(|trialled| trialled.is_wrong && trialled.fit.converged)
    }
}

/// Fits, and writes `calibrate.{csv,md}`; returns the files written.
///
/// # Errors
/// When the disk refuses, and, once the report is written, when intervals of undisturbed curves hold the truth too seldom or one of
/// their wrong minima was not said.
pub fn measure(out: &Path, quick: bool) -> Result<Vec<PathBuf>, Failure> {
    let curves = if quick { CURVES / QUICK_PART } else { CURVES };
    let groups = groups()?;
    let progress = Progress::new(groups.len() as u64 * curves, "curves");
    let mut rows = Vec::new();
    for group in &groups {
        for seed in 0..curves {
            rows.extend(row(group, seed));
            progress.advance(1);
        }
    }
    let table = out.join("calibrate.csv");
    csv(&rows).write_csv(&table)?;
    let text = sheet::write_text(out.join("calibrate.md"), &markdown(&groups, &rows, quick))?;
    let failed = failures(&groups, &rows, quick);
    if failed.is_empty() { Ok(vec![table, text]) } else { Err(Failure::Work(failed)) }
}

fn groups() -> Result<Vec<Group>, Failure> {
    let mut shipped = Vec::new();
    for scene in specimen::shipped()? {
        shipped.push(scene.axial_spec(&Patient::nominal(&scene)));
    }
    let random = |name, tip_to_rim_m, disturbance| Group { name, disturbance, from: From::Random { tip_to_rim_m } };
    Ok(vec![
        random("random layers, needle", 0.0, Disturbance::None),
        random("random layers, trocar", 0.002, Disturbance::None),
        Group { name: "shipped scenes, changed", disturbance: Disturbance::None, from: From::Shipped(shipped) },
        random("needle, with drift", 0.0, Disturbance::Drift),
        random("needle, with outliers", 0.0, Disturbance::Outliers),
    ])
}

/// A curve of a group; none where no scene serves.
fn row(group: &Group, seed: u64) -> Option<Row> {
    let measurement = Measurement::of_seed(seed, group.disturbance);
    let origin = match &group.from {
        // One to four layers, two dozen curves each: every noise, spacing and direction.
        From::Random { tip_to_rim_m } => {
            Origin::Blind { layers: (seed / 24 % 4 + 1) as usize, tip_to_rim_m: *tip_to_rim_m }
        }
        From::Shipped(scenes) => Origin::Changed(scenes.get(seed as usize % scenes.len())?),
    };
    let sampled = sample(origin, measurement, seed)?;
    let begun = clock::instant();
    let outcome = try_fit(&sampled).map_err(|why| why.to_string());
    let seconds = begun.elapsed().as_secs_f64();
    Some(Row { group: group.name, seed, measurement, layers: sampled.truth.layers.len(), seconds, outcome })
}

fn csv(rows: &[Row]) -> Sheet {
    let mut sheet = Sheet::new([
        "group",
        "seed",
        "noise_n",
        "spacing_m",
        "withdraws",
        "layers",
        "converged",
        "wrong",
        "layer",
        "parameter",
        "truth",
        "value",
        "low_95",
        "high_95",
        "holds",
    ]);
    for row in rows {
        let Some(trialled) = row.trialled() else { continue };
        let of_curve = [
            row.group.to_owned(),
            row.seed.to_string(),
            full(row.measurement.noise_n),
            full(row.measurement.spacing_m),
            row.measurement.withdraws.to_string(),
            row.layers.to_string(),
            trialled.fit.converged.to_string(),
            trialled.is_wrong.to_string(),
        ];
        for judged in &trialled.parameters {
            let estimate = &judged.estimate;
            let end = |number: Option<f64>| number.map_or_else(String::new, full);
            let of_number = [
                (estimate.layer + 1).to_string(),
                estimate.quantity.words().to_owned(),
                full(judged.truth),
                full(estimate.value),
                end(estimate.interval.map(|interval| interval.low)),
                end(estimate.interval.map(|interval| interval.high)),
                judged.is_held().map_or_else(String::new, |held| held.to_string()),
            ];
            sheet.row(of_curve.iter().cloned().chain(of_number));
        }
    }
    sheet
}

fn tally(rows: &[&Row], quantity: Quantity) -> Tally {
    let mut tally = Tally::default();
    let judged = rows.iter().filter_map(|row| row.trialled()).flat_map(|trialled| &trialled.parameters);
    judged.filter(|judged| judged.estimate.quantity == quantity).for_each(|judged| tally.count(judged));
    tally
}

fn of_group<'r>(rows: &'r [Row], group: &Group) -> Vec<&'r Row> {
    rows.iter().filter(|row| row.group == group.name).collect()
}

fn markdown(groups: &[Group], rows: &[Row], quick: bool) -> String {
    let mut text = format!(
        "# Calibration\n\n{}\n\nCurves of known layers, made by the force law in steps of 2 µm: a sample every 0.05, 0.1 or 0.2 mm, white noise \
         of 5, 10, 20 or 40 mN, the insertion alone or with the withdrawal. Random layers, one to four, are fitted from the curve \
         alone, and each makes a clear drop; a shipped scene's numbers are changed by up to a quarter, and the fit starts from the scene. Drift \
         is a wave of five times the noise, 5 to 20 mm long; outliers are one sample in a hundred, off by fifteen times the noise.\n",
        measured_on(What::Calibrate, quick)
    );
    text.push_str("\nWhat came of the curves. *Refused*: the fit says that its residual is not noise, and gives no interval. *Wrong*: another number of \
         layers, a sum of squares above the truth's, or a number far outside its interval.\n\n");
    text.push_str(&curves(groups, rows).markdown());
    text.push_str("\nOf the parameters, those of refused curves left out. *Held*: the share of 95 % intervals that hold the truth. *Not determined*: \
         the share of parameters with an effect on the curve that have no interval. *Without effect*: the curve does not depend on it.\n\n");
    text.push_str(&parameters(groups, rows).markdown());
    text
}

fn curves(groups: &[Group], rows: &[Row]) -> Sheet {
    let mut sheet = Sheet::new([
        "curves",
        "number",
        "no fit",
        "refused",
        "refused, right",
        "wrong, said",
        "wrong, not said",
        "median s",
        "longest s",
    ]);
    for group in groups {
        let rows = of_group(rows, group);
        let count = |is: &dyn Fn(&Trialled) -> bool| {
            rows.iter().filter_map(|row| row.trialled()).filter(|trialled| is(trialled)).count().to_string()
        };
        let seconds: Vec<f64> = rows.iter().map(|row| row.seconds).collect();
        sheet.row([
            group.name.to_owned(),
            rows.len().to_string(),
            rows.iter().filter(|row| row.outcome.is_err()).count().to_string(),
            count(&|trialled| !trialled.fit.converged),
            count(&|trialled| !trialled.fit.converged && !trialled.is_wrong),
            count(&|trialled| !trialled.fit.converged && trialled.is_wrong),
            rows.iter().filter(|row| row.is_silent()).count().to_string(),
            format!("{:.2}", quantile(&seconds, 0.5)),
            format!("{:.2}", quantile(&seconds, 1.0)),
        ]);
    }
    sheet
}

fn parameters(groups: &[Group], rows: &[Row]) -> Sheet {
    let mut sheet = Sheet::new(["curves", "parameter", "intervals", "held", "not determined", "without effect"]);
    for group in groups {
        let rows = settled(&of_group(rows, group));
        for quantity in QUANTITIES {
            let tally = tally(&rows, quantity);
            let (given, seen) = (tally.held + tally.missed, tally.held + tally.missed + tally.open);
            if seen == 0 {
                continue;
            }
            let held = if given > 0 { percent(tally.coverage()) } else { "–".to_owned() };
            let open = percent(tally.open as f64 / seen as f64);
            let name = quantity.words().to_owned();
            sheet.row([group.name.to_owned(), name, given.to_string(), held, open, tally.kept.to_string()]);
        }
    }
    sheet
}

/// Rows whose fit says that it has converged.
fn settled<'r>(rows: &[&'r Row]) -> Vec<&'r Row> {
    rows.iter().copied().filter(|row| row.trialled().is_some_and(|trialled| trialled.fit.converged)).collect()
}

/// What undisturbed curves must not show. A shortened report has too few intervals to judge their share.
fn failures(groups: &[Group], rows: &[Row], quick: bool) -> Vec<String> {
    let mut failed = Vec::new();
    for group in groups.iter().filter(|group| group.disturbance == Disturbance::None) {
        let rows = of_group(rows, group);
        for row in rows.iter().filter(|row| row.is_silent()) {
            failed.push(format!("{}, seed {}: a wrong minimum that was not said", group.name, row.seed));
        }
        for quantity in QUANTITIES {
            let tally = tally(&rows, quantity);
            if !quick && tally.coverage() < COVERAGE {
                let held = percent(tally.coverage());
                let (name, asked) = (quantity.words(), percent(COVERAGE));
                failed
                    .push(format!("{}, {name}: intervals hold the truth in {held}; {asked} are asked for", group.name));
            }
        }
    }
    failed
}

fn percent(part: f64) -> String {
    format!("{:.1} %", 100.0 * part)
}

/// Every digit.
fn full(number: f64) -> String {
    format!("{number:?}")
}
