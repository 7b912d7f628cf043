//! The hard cases: the measurement of each trial and its bound.

use std::path::{Path, PathBuf};

use super::sheet::{self, ReportSheet};
use super::{Subject, measured_on};
use crate::error::BenchError;
use crate::progress::MeasurementProgress;
use trials::HardCaseTrial;

/// A shortened report contains only the trials of this model, because the deforming tissue takes
/// longer.
const QUICK_MODEL: &str = "force law";

/// A trial and its measurement, or an error message.
struct HardCaseRow {
    trial: HardCaseTrial,
    measured: Result<f64, String>,
}

impl HardCaseRow {
    fn passes(&self) -> bool {
        self.measured.as_ref().is_ok_and(|&measured| self.trial.passes(measured))
    }

    /// Formats the measurement, or returns the error message.
    fn measured(&self, digits: impl Fn(f64) -> String) -> String {
        self.measured.as_ref().map_or_else(Clone::clone, |&measured| digits(measured))
    }
}

/// Measures and writes `hard-cases.{csv,md}`; returns the files written.
///
/// # Errors
/// On an I/O error, and, after the report has been written, if a trial fails: each is named.
pub fn measure(out: &Path, quick: bool) -> Result<Vec<PathBuf>, BenchError> {
    let rows = try_all(quick);
    let table = out.join("hard-cases.csv");
    csv(&rows).write_csv(&table)?;
    let text = sheet::write_text(out.join("hard-cases.md"), &markdown(&rows, quick))?;
    let failed: Vec<String> = rows.iter().filter(|row| !row.passes()).map(describe).collect();
    if failed.is_empty() { Ok(vec![table, text]) } else { Err(BenchError::Work(failed)) }
}

fn try_all(quick: bool) -> Vec<HardCaseRow> {
    let mut chosen = trials::all_trials();
    chosen.retain(|trial| !quick || trial.model == QUICK_MODEL);
    let progress = MeasurementProgress::new(chosen.len() as u64, "hard cases");
    let mut rows = Vec::with_capacity(chosen.len());
    for trial in chosen {
        rows.push(HardCaseRow { trial, measured: (trial.measure)().map_err(|why| why.to_string()) });
        progress.advance(1);
    }
    rows
}

fn describe(row: &HardCaseRow) -> String {
    let HardCaseTrial { model, case, measures, bound, unit, .. } = row.trial;
    let measured = row.measured(full);
    format!("{case} ({model}): {measures}: {measured} {unit}, the bound is {bound} {unit}")
}

fn csv(rows: &[HardCaseRow]) -> ReportSheet {
    let mut sheet = ReportSheet::new(["case", "model", "trial", "measures", "bound", "measured", "unit", "pass"]);
    for row in rows {
        let HardCaseTrial { model, name, case, measures, bound, unit, .. } = row.trial;
        let (bound, measured) = (full(bound), row.measured(full));
        sheet.row([case, model, name, measures, &bound, &measured, unit, if row.passes() { "yes" } else { "no" }]);
    }
    sheet
}

fn markdown(rows: &[HardCaseRow], quick: bool) -> String {
    let mut sheet = ReportSheet::new(["case", "model", "what", "bound", "measured", "unit", "pass"]);
    for row in rows {
        let HardCaseTrial { model, case, measures, bound, unit, .. } = row.trial;
        let (bound, measured) = (short(bound), row.measured(short));
        sheet.row([case, model, measures, &bound, &measured, unit, if row.passes() { "yes" } else { "**no**" }]);
    }
    let failed = rows.iter().filter(|row| !row.passes()).count();
    let scope = if quick { format!(" Only the trials of the {QUICK_MODEL} were run.") } else { String::new() };
    format!(
        "# Hard cases\n\n{}{scope}\n\nA trial passes when what it measures is a number and at most its bound. What a model must \
         refuse measures 0 when it is refused, 1 when not. Trials: {}; failed: {failed}.\n\n{}",
        measured_on(Subject::HardCases, quick),
        rows.len(),
        sheet.markdown()
    )
}

/// Formats a number with four significant digits.
fn short(number: f64) -> String {
    let rounded = format!("{number:.3e}").parse().unwrap_or(number);
    full(rounded)
}

/// Formats a number with every digit, with an exponent instead of many zeros.
fn full(number: f64) -> String {
    format!("{number:?}")
}
