//! Growth of set-up and solve times with the number of unknowns: exponents fitted on lower_back,
//! load at the surface.

use super::{FieldRow, MODELS};
use crate::report::chart::{Chart, ChartCurve};
use crate::report::sheet::ReportSheet;

/// Returns number of unknowns and time, in s, of a model's meshes on lower_back.
fn points(rows: &[FieldRow], model: &str, time_s: impl Fn(&FieldRow) -> f64) -> Vec<(f64, f64)> {
    let meshes = rows.iter().filter(|row| row.is_surface_load_on("lower_back") && row.tolerance.is_none());
    meshes.filter(|row| row.model == model).map(|row| (row.unknowns as f64, time_s(row))).collect()
}

/// Returns the exponent p of time ∝ unknownsᵖ by least squares on logarithms; `None` with fewer
/// than three sizes.
fn exponent(points: &[(f64, f64)]) -> Option<f64> {
    let logs: Vec<(f64, f64)> = points.iter().map(|&(n, t)| (libm::log(n), libm::log(t))).collect();
    let count = logs.len() as f64;
    let (mean_n, mean_t) = logs.iter().fold((0.0, 0.0), |sum, log| (sum.0 + log.0 / count, sum.1 + log.1 / count));
    let spread: f64 = logs.iter().map(|log| (log.0 - mean_n) * (log.0 - mean_n)).sum();
    let slope: f64 = logs.iter().map(|log| (log.0 - mean_n) * (log.1 - mean_t)).sum();
    (points.len() >= 3 && spread > 0.0).then(|| slope / spread)
}

/// Returns the table of exponents.
pub fn markdown(rows: &[FieldRow]) -> String {
    let mut sheet = ReportSheet::new(["model", "sizes", "set-up ∝ unknowns^p, p", "re-solve or step ∝ unknowns^p, p"]);
    let shown = |p: Option<f64>| p.map_or_else(|| "–".to_owned(), |p| format!("{p:.2}"));
    for model in MODELS.map(|model| model.name()) {
        let (setup, solve) = (points(rows, model, |row| row.setup_s), points(rows, model, |row| row.solve_s));
        sheet.row([model.to_owned(), setup.len().to_string(), shown(exponent(&setup)), shown(exponent(&solve))]);
    }
    sheet.markdown()
}

/// Plots set-up and solve times against unknowns.
pub fn chart(rows: &[FieldRow]) -> Chart {
    let curve = |name: &str, what: &str, points: Vec<(f64, f64)>| ChartCurve {
        name: format!("{name}, {what}"),
        points: points.into_iter().map(|(n, t)| (n, t * 1e3)).collect(),
    };
    let curves = MODELS.iter().flat_map(|model| {
        let name = model.name();
        [
            curve(name, "set-up", points(rows, name, |row| row.setup_s)),
            curve(name, "re-solve or step", points(rows, name, |row| row.solve_s)),
        ]
    });
    Chart {
        title: "Growth on lower_back, load at the surface".to_owned(),
        x: "unknowns".to_owned(),
        y: "time, ms".to_owned(),
        curves: curves.collect(),
        ..Chart::default()
    }
}
