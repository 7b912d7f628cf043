//! Estimated error of a field compared with its true error, on random tissues.

use std::path::{Path, PathBuf};

use tissue::LoadKind;

use super::sheet::{self, ReportSheet};
use super::{Subject, measured_on, quantile};
use crate::error::BenchError;
use crate::progress::MeasurementProgress;
use trials::estimates::{DrawnTissue, JudgedEstimate, TOLERANCES, draw, measure as measure_one};

/// Number of random tissues in a report, and in a shortened one.
const SCENES: [u32; 2] = [1000, 10];

/// Largest allowed ratio of an error to its estimate.
const MOST_FACTOR: f64 = 3.0;

/// Smallest share of correct results among the fits that report that their tolerance is met.
const LEAST_TRUE: f64 = 0.995;

/// A random tissue with its result.
struct EstimateRow {
    drawn: DrawnTissue,
    found: JudgedEstimate,
}

impl EstimateRow {
    /// Returns whether the tolerance is reported as met but is not.
    fn broken(&self) -> bool {
        self.found.met && self.found.error() > self.drawn.tolerance
    }
}

/// Measures and writes `estimates.{csv,md}`; returns the files written.
///
/// # Errors
/// On an I/O error, and, after the report has been written, if a bound is exceeded.
pub fn measure(out: &Path, quick: bool) -> Result<Vec<PathBuf>, BenchError> {
    let [whole, shortened] = SCENES;
    let scenes = if quick { shortened } else { whole };
    let progress = MeasurementProgress::new(u64::from(scenes), "estimates");
    let mut rows = Vec::new();
    for number in 0..scenes {
        let drawn = draw(number);
        let found = measure_one(&drawn).map_err(BenchError::work)?;
        rows.push(EstimateRow { drawn, found });
        progress.advance(1);
    }
    let table = out.join("estimates.csv");
    csv(&rows).write_csv(&table)?;
    let text = sheet::write_text(out.join("estimates.md"), &markdown(&rows, quick))?;
    let broken = broken(&rows);
    if broken.is_empty() { Ok(vec![table, text]) } else { Err(BenchError::Work(broken)) }
}

/// Returns a line for each exceeded bound.
fn broken(rows: &[EstimateRow]) -> Vec<String> {
    let mut lines: Vec<String> = rows
        .iter()
        .filter(|row| row.found.factor() > MOST_FACTOR)
        .map(|row| {
            let (number, factor) = (row.drawn.number, row.found.factor());
            format!("random tissue {number}: the error is {factor:.1} times its estimate, the bound is {MOST_FACTOR}")
        })
        .collect();
    let (met, wrong) =
        (rows.iter().filter(|row| row.found.met).count(), rows.iter().filter(|row| row.broken()).count());
    if wrong as f64 > (1.0 - LEAST_TRUE) * met as f64 {
        lines.push(format!(
            "{wrong} of {met} tolerances are said to be met and are not; a share of {LEAST_TRUE} must be"
        ));
    }
    lines
}

fn csv(rows: &[EstimateRow]) -> ReportSheet {
    let mut sheet = ReportSheet::new([
        "scene",
        "layers",
        "load",
        "load_radius_mm",
        "radius_mm",
        "samples",
        "tolerance",
        "unknowns",
        "estimated_relative_error",
        "axial_error",
        "radial_error",
        "factor",
        "met",
    ]);
    for EstimateRow { drawn, found } in rows {
        let problem = &drawn.problem;
        let load = match problem.load.kind {
            LoadKind::Contactor { .. } => "contactor",
            LoadKind::Drag { .. } => "drag",
        };
        sheet.row([
            drawn.number.to_string(),
            problem.slab.layers.len().to_string(),
            load.to_owned(),
            format!("{:.3}", problem.load.radius_m * 1e3),
            format!("{:.2}", problem.slab.radius_m * 1e3),
            (problem.sample_r_m.len() * problem.sample_depth_m.len()).to_string(),
            drawn.tolerance.to_string(),
            found.unknowns.to_string(),
            format!("{:.3e}", found.estimated),
            format!("{:.3e}", found.axial),
            format!("{:.3e}", found.radial),
            format!("{:.3}", found.factor()),
            found.met.to_string(),
        ]);
    }
    sheet
}

fn markdown(rows: &[EstimateRow], quick: bool) -> String {
    let mut sheet =
        ReportSheet::new(["tolerance", "tissues", "met", "met by word alone", "largest error over estimate", "median"]);
    for tolerance in TOLERANCES {
        let of: Vec<&EstimateRow> =
            rows.iter().filter(|row| row.drawn.tolerance.total_cmp(&tolerance).is_eq()).collect();
        let factors: Vec<f64> = of.iter().map(|row| row.found.factor()).collect();
        sheet.row([
            format!("{} %", tolerance * 1e2),
            of.len().to_string(),
            of.iter().filter(|row| row.found.met).count().to_string(),
            of.iter().filter(|row| row.broken()).count().to_string(),
            format!("{:.2}", quantile(&factors, 1.0)),
            format!("{:.2}", quantile(&factors, 0.5)),
        ]);
    }
    format!(
        "# Estimates\n\n{}\n\nRandom tissues of one to six layers, moduli up to ten thousand times apart, Poisson ratios from 0.3 to \
         0.499, sheets from 0.02 mm, needles of 0.4 to 5 mm, pushed at boundaries and inside layers or dragged, each answered to a \
         tolerance. The error is the larger of the relative L2 errors of the axial and of the radial displacement over the samples, \
         against a mesh far finer than any that is chosen or judges. No error may be more than {MOST_FACTOR} times its estimate, and \
         of the tolerances said to be met {} % must be. Each is in `estimates.csv`; a number always draws the same tissue.\n\n{}",
        measured_on(Subject::Estimates, quick),
        LEAST_TRUE * 1e2,
        sheet.markdown()
    )
}
