//! The tissue: error against time for each model and reference case, with the planner's choice
//! marked.

mod cases;
mod growth;
mod oblique;
pub mod peers;

use std::path::{Path, PathBuf};

use cases::ReferenceLoad;
use peers::Peer;
use tissue::planner::{self, PlanRequest};
use tissue::volumetric::Problem3;
use tissue::{FieldModel, Judging, Model};

use super::chart::{Chart, ChartCurve};
use super::sheet::{self, ReportSheet};
use super::{Subject, head};
use crate::error::BenchError;
use crate::progress::MeasurementProgress;
use crate::timing::{self, TimingEffort, answer_s};

/// Tolerances requested from the planner.
const TOLERANCES: [f64; 4] = [0.05, 0.02, 0.01, 0.001];

const MODELS: [Model; 3] = [Model::Axisymmetric, Model::MassSpring, Model::Volumetric];

/// One mesh of one model for one load, or the planner's choice for that load.
pub struct FieldRow {
    case: &'static str,
    depth_m: f64,
    model: &'static str,
    /// The tolerance requested from the planner; `None` for a mesh of the sweep.
    tolerance: Option<f64>,
    unknowns: usize,
    bytes: usize,
    error: f64,
    estimate: Option<f64>,
    setup_s: f64,
    solve_s: f64,
    answer_s: f64,
}

impl FieldRow {
    fn is_surface_load_on(&self, case: &str) -> bool {
        self.case == case && self.depth_m <= 0.0
    }
}

/// The command-line option for the results of other solvers, as in the report's head.
pub const BESIDE: &str = " --peers field-peers.csv";

/// Measures and writes `field*.{csv,md,svg}`, with the results of other solvers in the same plots
/// and tables; returns the files written.
///
/// # Errors
/// On an I/O error.
pub fn measure(out: &Path, quick: bool, peers: &[Peer]) -> Result<Vec<PathBuf>, BenchError> {
    let loads = cases::all()?;
    let rows = sweep(&loads, quick)?;
    let table = out.join("field.csv");
    sheet(&rows).write_csv(&table)?;
    let mut written = vec![table];
    for case in cases::NAMES {
        for axis in [Axis::Time, Axis::Unknowns] {
            let plot = out.join(format!("field-{}-{case}.svg", axis.name()));
            Chart { beside: peers::curves(peers, case, axis), ..chart(&rows, case, axis) }.draw(&plot)?;
            written.push(plot);
        }
    }
    let oblique = oblique::measure(&loads, quick)?;
    let plot = out.join("field-growth.svg");
    growth::chart(&rows).draw(&plot)?;
    written.push(plot);
    let head = head::measured_by(Subject::Field, if peers.is_empty() { "" } else { BESIDE }, quick);
    written.push(sheet::write_text(out.join("field.md"), &markdown(&head, &rows, &oblique, peers))?);
    Ok(written)
}

/// Measures the planner's choice for every load, and every mesh of every model.
fn sweep(loads: &[ReferenceLoad], quick: bool) -> Result<Vec<FieldRow>, BenchError> {
    let progress = MeasurementProgress::new(loads.len() as u64, "tissue");
    let mut rows = Vec::new();
    for load in loads.iter().filter(|load| !quick || load.depth_m <= 0.0) {
        for tolerance in TOLERANCES {
            rows.push(chosen(load, tolerance)?);
        }
        // The other loads differ from the first only in depth: 3-D sweeps of them would take long
        // and show the same.
        let models = MODELS.into_iter().filter(|model| *model == Model::Axisymmetric || load.depth_m <= 0.0);
        for model in models {
            rows.extend(ladder(load, model, quick)?);
        }
        progress.advance(1);
    }
    Ok(rows)
}

fn chosen(load: &ReferenceLoad, tolerance: f64) -> Result<FieldRow, BenchError> {
    let wish = PlanRequest { model: None, tolerance, judging: Judging::default() };
    let question = Problem3::flat(&load.problem);
    let (planned, setup_s) = timing::once(|| planner::plan(&question, &wish));
    let planned = planned.map_err(BenchError::work)?;
    let estimate = Some(planned.estimated_relative_error);
    Ok(FieldRow { tolerance: Some(tolerance), estimate, ..row(load, planned.field, setup_s) })
}

/// Measures every mesh of a model's ladder; in a shortened report, the coarsest two.
fn ladder(load: &ReferenceLoad, model: Model, quick: bool) -> Result<Vec<FieldRow>, BenchError> {
    let mut rows = Vec::new();
    for at in 0..if quick { 2 } else { usize::MAX } {
        let (made, setup_s) = timing::once(|| planner::plan_rung(&load.problem, model, at));
        let Some(field) = made else { break };
        rows.push(row(load, field.map_err(BenchError::work)?, setup_s));
    }
    Ok(rows)
}

fn row(load: &ReferenceLoad, mut field: Box<dyn FieldModel>, setup_s: f64) -> FieldRow {
    let solve_s = timing::median_s(TimingEffort::SLOW, || field.solve(load.force_n));
    let error = load.error(field.as_ref());
    let answer_s = answer_s(field.as_mut(), &load.problem, load.force_n);
    FieldRow {
        case: load.case,
        depth_m: load.depth_m,
        model: field.model().name(),
        tolerance: None,
        unknowns: field.unknowns(),
        bytes: field.bytes(),
        error,
        estimate: None,
        setup_s,
        solve_s,
        answer_s,
    }
}

fn sheet(rows: &[FieldRow]) -> ReportSheet {
    let mut sheet = ReportSheet::new([
        "case",
        "load_depth_mm",
        "model",
        "planner_tolerance",
        "unknowns",
        "bytes",
        "relative_error",
        "estimated_relative_error",
        "setup_s",
        "solve_s",
        "answer_s",
    ]);
    let optional = |value: Option<f64>| value.map_or_else(String::new, |value| format!("{value:e}"));
    for row in rows {
        sheet.row([
            row.case.to_owned(),
            format!("{}", row.depth_m * 1e3),
            row.model.to_owned(),
            row.tolerance.map_or_else(String::new, |tolerance| tolerance.to_string()),
            row.unknowns.to_string(),
            row.bytes.to_string(),
            format!("{:e}", row.error),
            optional(row.estimate),
            format!("{:e}", row.setup_s),
            format!("{:e}", row.solve_s),
            format!("{:e}", row.answer_s),
        ]);
    }
    sheet
}

/// Horizontal axis of an error plot.
#[derive(Clone, Copy)]
pub enum Axis {
    /// Time of a solution, in ms: a re-solve, a step or, if nothing is factorised, all steps to
    /// rest.
    Time,
    /// Unknowns.
    Unknowns,
}

impl Axis {
    fn name(self) -> &'static str {
        match self {
            Self::Time => "time",
            Self::Unknowns => "convergence",
        }
    }

    /// Returns the position on the axis for a number of unknowns and a time in s.
    fn place(self, unknowns: usize, solve_s: f64) -> f64 {
        match self {
            Self::Time => solve_s * 1e3,
            Self::Unknowns => unknowns as f64,
        }
    }
}

/// Plots the error of every model for the load at the surface.
fn chart(rows: &[FieldRow], case: &str, axis: Axis) -> Chart {
    let of = |wanted: &dyn Fn(&&FieldRow) -> bool| {
        let shown = rows.iter().filter(|row| row.is_surface_load_on(case)).filter(wanted);
        shown.map(|row| (axis.place(row.unknowns, row.solve_s), row.error * 1e2)).collect()
    };
    let curves = MODELS.iter().map(|model| ChartCurve {
        name: model.name().to_owned(),
        points: of(&|row| row.tolerance.is_none() && row.model == model.name()),
    });
    let x = match axis {
        Axis::Time => "time of a re-solve, or of coming to rest, ms",
        Axis::Unknowns => "unknowns",
    };
    Chart {
        title: format!("Error of each model, {case}, load at the surface"),
        x: x.to_owned(),
        y: "relative error of the axial displacement, %".to_owned(),
        curves: curves.collect(),
        rings: vec![ChartCurve { name: "the planner's choice".to_owned(), points: of(&|row| row.tolerance.is_some()) }],
        ..Chart::default()
    }
}

/// Returns the table of the planner's choices.
fn chosen_sheet(rows: &[FieldRow]) -> ReportSheet {
    let mut sheet = ReportSheet::new([
        "case",
        "load at",
        "tolerance",
        "model",
        "unknowns",
        "error",
        "estimate",
        "set-up",
        "re-solve",
        "superposed",
        "memory",
    ]);
    for row in rows {
        let (Some(tolerance), Some(estimate)) = (row.tolerance, row.estimate) else { continue };
        let [setup, solve, answer] = [row.setup_s, row.solve_s, row.answer_s].map(human_time);
        sheet.row([
            row.case.to_owned(),
            format!("{} mm", row.depth_m * 1e3),
            format!("{} %", tolerance * 1e2),
            row.model.to_owned(),
            row.unknowns.to_string(),
            percent(row.error),
            percent(estimate),
            setup,
            solve,
            answer,
            format!("{:.2} MB", row.bytes as f64 / 1e6),
        ]);
    }
    sheet
}

/// Returns the table of every mesh for the load at the surface, with the results of other solvers.
fn swept_sheet(rows: &[FieldRow], peers: &[Peer]) -> ReportSheet {
    let mut sheet = ReportSheet::new(["case", "model", "unknowns", "error", "set-up", "re-solve", "superposed"]);
    for case in cases::NAMES {
        for row in rows.iter().filter(|row| row.tolerance.is_none() && row.is_surface_load_on(case)) {
            let [setup, solve, answer] = [row.setup_s, row.solve_s, row.answer_s].map(human_time);
            let (case, model, unknowns) = (row.case.to_owned(), row.model.to_owned(), row.unknowns.to_string());
            sheet.row([case, model, unknowns, percent(row.error), setup, solve, answer]);
        }
        peers.iter().filter(|peer| peer.case == case).for_each(|peer| sheet.row(peer.cells()));
    }
    sheet
}

pub(super) fn percent(share: f64) -> String {
    format!("{:.3} %", share * 1e2)
}

fn markdown(head: &str, rows: &[FieldRow], oblique: &ReportSheet, peers: &[Peer]) -> String {
    let pictures = cases::NAMES.map(|case| {
        format!(
            "![{case}, error against time](field-time-{case}.svg)\n![{case}, convergence](field-convergence-{case}.svg)"
        )
    });
    format!(
        "# Tissue\n\n{head}\n\nError: relative L2 error of the axial displacement over all samples, against finite elements \
         converged to 2e-5 (stiff_skin_soft_fat: 2e-4). Times: medians on one thread. *Re-solve*: a back-substitution; the \
         lattice comes to rest from where nothing has moved. *Superposed*: what a tick of the simulator pays, all samples. *Set-up* of a \
         choice is the whole search for it.\n\n## What the planner chooses\n\n{}\n## Every mesh, load at the \
         surface\n\nThe volumetric model on a quarter, between planes of symmetry. Refined, the lattice tends to \
         the answer of ν = 1/4, which is 3.2, 11.3 and 35.5 % off on the three cases, and may cross the right one on its way.\n\n{}\n{}\n\n## An oblique \
         needle\n\nlower_back met at 30°, half of it meshed; no other solver was measured on it. Against the finest \
         mesh.\n\n{}\n## Growth\n\nOn lower_back, load at the surface.\n\n{}\n![growth](field-growth.svg)\n\n## Beside \
         other solvers\n\n{}",
        chosen_sheet(rows).markdown(),
        swept_sheet(rows, peers).markdown(),
        pictures.join("\n"),
        oblique.markdown(),
        growth::markdown(rows),
        peers::markdown(rows, peers),
    )
}

/// Formats a time with a suitable unit.
pub(super) fn human_time(time_s: f64) -> String {
    match time_s {
        t if t < 1e-6 => format!("{:.0} ns", t * 1e9),
        t if t < 1e-4 => format!("{:.2} µs", t * 1e6),
        t if t < 1e-3 => format!("{:.0} µs", t * 1e6),
        t if t < 1.0 => format!("{:.2} ms", t * 1e3),
        t => format!("{t:.2} s"),
    }
}
