//! Fits of curves with known parameters: how often a 95 % interval contains the truth, how often
//! there is no interval, and wrong minima.

use std::path::{Path, PathBuf};

use documents::Patient;
use law::axial::{AxialSpec, ForceLaw};
use tissue::calibrate::{self, ParameterEstimate, ParameterStanding, QUANTITIES, Quantity};

use super::chart::{self, Chart};
use super::sheet::{self, ReportSheet};
use super::threads::each_seed;
use super::{Subject, calibrate_fits, calibrate_timed, measured_on, quantile};
use crate::clock;
use crate::error::BenchError;
use crate::progress::MeasurementProgress;
use trials::calibration::{Disturbance, Judged, Measurement, Origin, Trialled, sample, try_fit};

/// Number of curves of a group of random layers, of shipped scenes under a trocar, which take
/// seconds each, and of seven layers, which take a minute each. A shortened report divides these by
/// [`QUICK_PART`].
const CURVES: u64 = 240;
const SHIPPED_CURVES: u64 = 60;
const DEEP_CURVES: u64 = 24;
/// Number of timed curves: a dozen for every tissue and noise level.
const TIMED_CURVES: u64 = 144;
const QUICK_PART: u64 = 120;
/// First seed; no setting of the fit was tuned on these seeds.
pub(super) const FIRST_SEED: u64 = 2000;
/// Smallest share of intervals that must contain the truth, and largest share of a group's curves
/// that may end in an unreported wrong minimum.
const COVERAGE: f64 = 0.9;
const SILENT: f64 = 0.02;

/// A group of similar curves.
struct Group {
    name: &'static str,
    curves: u64,
    disturbance: Disturbance,
    from: From,
}

/// Source of a group's layers.
enum From {
    Random { tip_to_rim_m: f64 },
    Shipped(Vec<AxialSpec>),
}

/// The result of a curve: the fit compared with the truth, or an error.
struct CalibrationRow {
    group: &'static str,
    seed: u64,
    measurement: Measurement,
    layers: usize,
    seconds: f64,
    outcome: Result<Trialled, String>,
}

/// Counts how often a parameter's interval contained the truth.
#[derive(Default)]
pub(super) struct IntervalTally {
    held: usize,
    missed: usize,
    open: usize,
    kept: usize,
}

impl IntervalTally {
    pub fn count(&mut self, judged: &Judged) {
        match judged.is_held() {
            Some(true) => self.held += 1,
            Some(false) => self.missed += 1,
            None if judged.estimate.standing == ParameterStanding::Kept => self.kept += 1,
            None => self.open += 1,
        }
    }

    /// Returns the number of parameters that affect the curve.
    pub fn seen(&self) -> usize {
        self.given() + self.open
    }

    /// Returns the number of those that have an interval.
    pub fn given(&self) -> usize {
        self.held + self.missed
    }

    /// Returns the number of those that have none.
    pub fn open(&self) -> usize {
        self.open
    }

    /// Returns the share of intervals that contain the truth; `None` without an interval.
    pub fn coverage(&self) -> Option<f64> {
        let given = self.given();
        (given > 0).then(|| self.held as f64 / given as f64)
    }
}

impl CalibrationRow {
    fn trialled(&self) -> Option<&Trialled> {
        self.outcome.as_ref().ok()
    }

    fn is_silent(&self) -> bool {
        self.trialled().is_some_and(|trialled| trialled.is_silent)
    }
}

/// Fits the curves and writes `calibrate.{csv,md,svg}`, `calibrate-timed.csv` and
/// `calibrate-fits.svg`; returns the files written.
///
/// # Errors
/// On an I/O error, and, after the report has been written, if intervals of undisturbed curves
/// contain the truth too rarely or too many of their wrong minima are not reported.
pub fn measure(out: &Path, quick: bool) -> Result<Vec<PathBuf>, BenchError> {
    let curves = |group: &Group| if quick { group.curves / QUICK_PART } else { group.curves };
    let groups = groups()?;
    let timed_curves = if quick { TIMED_CURVES / QUICK_PART } else { TIMED_CURVES };
    let progress = MeasurementProgress::new(groups.iter().map(curves).sum::<u64>() + timed_curves, "curves");
    let mut rows = Vec::new();
    for group in &groups {
        rows.extend(at_once(group, curves(group), &progress)?);
    }
    let timed = calibrate_timed::fit_all(timed_curves, &progress)?;
    let [table, timed_table] = ["calibrate.csv", "calibrate-timed.csv"].map(|name| out.join(name));
    csv(&rows).write_csv(&table)?;
    calibrate_timed::csv(&timed).write_csv(&timed_table)?;
    let [picture, fits] = ["calibrate.svg", "calibrate-fits.svg"].map(|name| out.join(name));
    picture_of(&groups, &rows).draw(&picture)?;
    calibrate_fits::draw(&fits)?;
    let whole = format!(
        "{}{}\n![fits over curves](calibrate-fits.svg)\n",
        markdown(&groups, &rows, quick),
        calibrate_timed::markdown(&timed)
    );
    let text = sheet::write_text(out.join("calibrate.md"), &whole)?;
    let mut failed = failures(&groups, &rows, quick);
    failed.extend(calibrate_timed::failures(&timed).into_iter().filter(|_| !quick));
    if failed.is_empty() { Ok(vec![table, timed_table, text, picture, fits]) } else { Err(BenchError::Work(failed)) }
}

/// Fits the curves of a group in parallel; returns them in the order of their seeds.
fn at_once(group: &Group, curves: u64, progress: &MeasurementProgress) -> Result<Vec<CalibrationRow>, BenchError> {
    let fit = |seed| {
        let row = row(group, seed);
        progress.advance(1);
        row
    };
    Ok(each_seed(FIRST_SEED..FIRST_SEED + curves, fit)?.into_iter().flatten().collect())
}

fn groups() -> Result<Vec<Group>, BenchError> {
    let (mut trocars, mut needles) = (Vec::new(), Vec::new());
    for scene in dossier::read_shipped_scenes()? {
        let spec = scene.axial_spec(&Patient::nominal(&scene));
        if spec.law == ForceLaw::Version1 || calibrate::needs_times(&spec) {
            continue;
        }
        if spec.tip_to_rim_m > 0.0 { &mut trocars } else { &mut needles }.push(spec);
    }
    let random = |name, tip_to_rim_m, disturbance| {
        let from = From::Random { tip_to_rim_m };
        Group { name, curves: CURVES, disturbance, from }
    };
    let shipped = |name, curves, scenes| {
        let (disturbance, from) = (Disturbance::None, From::Shipped(scenes));
        Group { name, curves, disturbance, from }
    };
    Ok(vec![
        random("random layers, needle", 0.0, Disturbance::None),
        random("random layers, trocar", 0.002, Disturbance::None),
        shipped("shipped trocar scenes, changed", SHIPPED_CURVES, trocars),
        shipped("shipped needle scenes, changed", DEEP_CURVES, needles),
        random("needle, with drift", 0.0, Disturbance::Drift),
        random("needle, with outliers", 0.0, Disturbance::Outliers),
    ])
}

/// Fits a curve of a group; `None` if no scene is suitable.
fn row(group: &Group, seed: u64) -> Option<CalibrationRow> {
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
    Some(CalibrationRow { group: group.name, seed, measurement, layers: sampled.truth.layers.len(), seconds, outcome })
}

fn csv(rows: &[CalibrationRow]) -> ReportSheet {
    let mut sheet = ReportSheet::new([
        "group",
        "seed",
        "noise_n",
        "spacing_m",
        "withdraws",
        "layers",
        "drops",
        "converged",
        "wrong",
        "not_said",
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
            trialled.fit.peaks.iter().filter(|peak| peak.measured.is_some()).count().to_string(),
            trialled.fit.converged.to_string(),
            trialled.is_wrong.to_string(),
            trialled.is_silent.to_string(),
        ];
        for of_number in rows_of_numbers(&trialled.parameters) {
            sheet.row(of_curve.iter().cloned().chain(of_number));
        }
    }
    sheet
}

/// Returns layer, parameter, truth, value, interval, and whether the interval contains the truth,
/// for each parameter.
pub(super) fn rows_of_numbers(parameters: &[Judged]) -> impl Iterator<Item = [String; 7]> {
    let end = |number: Option<f64>| number.map_or_else(String::new, full);
    parameters.iter().map(move |judged| {
        let estimate = &judged.estimate;
        [
            (estimate.layer + 1).to_string(),
            estimate.quantity.words().to_owned(),
            full(judged.truth),
            full(estimate.value),
            end(estimate.interval.map(|interval| interval.low)),
            end(estimate.interval.map(|interval| interval.high)),
            judged.is_held().map_or_else(String::new, |held| held.to_string()),
        ]
    })
}

fn tally(rows: &[&CalibrationRow], quantity: Quantity) -> IntervalTally {
    let mut tally = IntervalTally::default();
    let judged = rows.iter().filter_map(|row| row.trialled()).flat_map(|trialled| &trialled.parameters);
    judged.filter(|judged| judged.estimate.quantity == quantity).for_each(|judged| tally.count(judged));
    tally
}

fn of_group<'r>(rows: &'r [CalibrationRow], group: &Group) -> Vec<&'r CalibrationRow> {
    rows.iter().filter(|row| row.group == group.name).collect()
}

fn markdown(groups: &[Group], rows: &[CalibrationRow], quick: bool) -> String {
    let mut text = format!(
        "# Calibration\n\n{}\n\nCurves of known layers, made by the force law in steps of 2 µm: a sample every 0.05, 0.1 or 0.2 mm, white noise \
         of 5, 10, 20 or 40 mN, the insertion alone or with the withdrawal. Random layers, one to four, are fitted from the curve \
         alone, and each makes a clear drop; a shipped scene's numbers are changed by up to a quarter, and the fit starts from the scene. Drift \
         is a wave of five times the noise, 5 to 20 mm long; outliers are one sample in a hundred, off by fifteen times the noise.\n",
        measured_on(Subject::Calibrate, quick)
    );
    text.push_str("\nResults. *Refused*: the fit reports that its residual is not noise, and gives no interval. *Wrong*: another \
         number of layers, a sum of squares above the truth's, or a number far outside its interval. *Said*: refused, or, where \
         the sum of squares alone is wrong, reported to have other assignments or boundaries that no drop shows; of the latter no \
         value has an interval.\n\n");
    text.push_str(&curves(groups, rows).markdown());
    text.push_str("\nOf the parameters, those of refused curves left out. *Held*: the share of 95 % intervals that hold the truth. *Not determined*: \
         the share of parameters with an effect on the curve that have no interval. *Without effect*: the curve does not depend on it.\n\n");
    text.push_str(&parameters(groups, rows).markdown());
    text.push_str("\n![width of the intervals](calibrate.svg)\n");
    text
}

fn curves(groups: &[Group], rows: &[CalibrationRow]) -> ReportSheet {
    let mut sheet = ReportSheet::new([
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
            count(&|trialled| trialled.is_wrong && !trialled.is_silent),
            rows.iter().filter(|row| row.is_silent()).count().to_string(),
            format!("{:.2}", quantile(&seconds, 0.5)),
            format!("{:.2}", quantile(&seconds, 1.0)),
        ]);
    }
    sheet
}

fn parameters(groups: &[Group], rows: &[CalibrationRow]) -> ReportSheet {
    let mut sheet = ReportSheet::new(["curves", "parameter", "intervals", "held", "not determined", "without effect"]);
    for group in groups {
        let rows = settled(&of_group(rows, group));
        for quantity in QUANTITIES {
            let tally = tally(&rows, quantity);
            if tally.seen() == 0 {
                continue;
            }
            let held = tally.coverage().map_or_else(|| "none given".to_owned(), percent);
            let open = percent(tally.open as f64 / tally.seen() as f64);
            let (name, given) = (quantity.words().to_owned(), tally.given().to_string());
            sheet.row([group.name.to_owned(), name, given, held, open, tally.kept.to_string()]);
        }
    }
    sheet
}

/// Selects the rows whose fit reports convergence.
fn settled<'r>(rows: &[&'r CalibrationRow]) -> Vec<&'r CalibrationRow> {
    rows.iter().copied().filter(|row| row.trialled().is_some_and(|trialled| trialled.fit.converged)).collect()
}

/// Returns the failed requirements on undisturbed curves. A shortened report has too few curves to
/// evaluate shares.
fn failures(groups: &[Group], rows: &[CalibrationRow], quick: bool) -> Vec<String> {
    let mut failed = Vec::new();
    for group in groups.iter().filter(|group| group.disturbance == Disturbance::None) {
        let rows = of_group(rows, group);
        let silent: Vec<String> = rows.iter().filter(|row| row.is_silent()).map(|row| row.seed.to_string()).collect();
        if !quick && silent.len() as f64 > SILENT * rows.len() as f64 {
            let (name, number, seeds) = (group.name, rows.len(), silent.join(", "));
            failed.push(format!("{name}: {} of {number} wrong minima were not said, seeds {seeds}", silent.len()));
        }
        let settled = settled(&rows);
        if !rows.is_empty() && settled.is_empty() {
            failed.push(format!("{}: no fit of {} has converged", group.name, rows.len()));
        }
        let may_be_open = matches!(group.from, From::Shipped(_));
        let uncovered = |quantity| uncovered(&tally(&settled, quantity), quantity, may_be_open);
        let broken = QUANTITIES.into_iter().filter_map(uncovered);
        failed.extend(broken.filter(|_| !quick).map(|why| format!("{}, {why}", group.name)));
    }
    failed
}

/// Returns why the intervals of a quantity are insufficient, if they are: too few contain the
/// truth, or none exists where required.
fn uncovered(tally: &IntervalTally, quantity: Quantity, may_be_open: bool) -> Option<String> {
    let name = quantity.words();
    match tally.coverage() {
        Some(share) if share < COVERAGE => {
            Some(format!("{name}: intervals hold the truth in {}; {} are asked for", percent(share), percent(COVERAGE)))
        }
        None if tally.seen() > 0 && !may_be_open => Some(format!("{name}: none of {} has an interval", tally.seen())),
        _ => None,
    }
}

/// Plots the width of the intervals of undisturbed random layers against the noise: the median of
/// half the width, relative to the value.
fn picture_of(groups: &[Group], rows: &[CalibrationRow]) -> Chart {
    let random = groups.iter().find(|group| matches!(group.from, From::Random { .. }));
    let rows = random.map_or_else(Vec::new, |group| settled(&of_group(rows, group)));
    let median = |quantity: Quantity, noise_n: f64| {
        let at_noise = rows.iter().filter(|row| row.measurement.noise_n.total_cmp(&noise_n).is_eq());
        let estimates = at_noise.filter_map(|row| row.trialled()).flat_map(|trialled| &trialled.parameters);
        let half = |judged: &Judged| {
            let ParameterEstimate { interval, value, .. } = &judged.estimate;
            interval.map(|interval| 50.0 * (interval.high - interval.low) / value.abs())
        };
        let halves: Vec<f64> =
            estimates.filter(|judged| judged.estimate.quantity == quantity).filter_map(half).collect();
        quantile(&halves, 0.5)
    };
    let curve = |quantity: Quantity| {
        let point = |noise_n: f64| (noise_n * 1e3, median(quantity, noise_n));
        let points = [0.005, 0.01, 0.02, 0.04].map(point).into_iter().filter(|point| point.1.is_finite()).collect();
        chart::ChartCurve { name: quantity.words().to_owned(), points }
    };
    let curves = QUANTITIES.map(curve).into_iter().filter(|curve| !curve.points.is_empty()).collect();
    Chart {
        title: "95 % intervals of random layers under a needle".to_owned(),
        x: "noise, mN".to_owned(),
        y: "half width, median, % of the value".to_owned(),
        curves,
        beside: Vec::new(),
        rings: Vec::new(),
    }
}

pub(super) fn percent(part: f64) -> String {
    format!("{:.1} %", 100.0 * part)
}

/// Formats a number with every digit.
pub(super) fn full(number: f64) -> String {
    format!("{number:?}")
}
