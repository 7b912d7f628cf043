//! An oblique needle: every mesh of the volumetric model compared with the finest.

use tissue::volumetric::{self, Problem3, Volumetric};
use tissue::{FieldModel, relative_distance};

use super::cases::ReferenceLoad;
use super::{human_time, percent};
use crate::error::BenchError;
use crate::report::sheet::ReportSheet;
use crate::timing::{self, TimingEffort};

const TILT_DEG: f64 = 30.0;

/// A mesh with its solution and its times.
struct ObliqueRung {
    unknowns: usize,
    bytes: usize,
    axial_m: Vec<f64>,
    setup_s: f64,
    solve_s: f64,
}

/// Measures the load on the skin of lower_back.
///
/// # Errors
/// If the model refuses a mesh.
pub fn measure(loads: &[ReferenceLoad], quick: bool) -> Result<ReportSheet, BenchError> {
    let mut sheet = ReportSheet::new(["unknowns", "difference to the finest", "set-up", "re-solve", "memory"]);
    let Some(load) = loads.iter().find(|load| load.case == "lower_back" && load.depth_m <= 0.0) else {
        return Ok(sheet);
    };
    let question = Problem3 { tilt_rad: TILT_DEG.to_radians(), ..Problem3::flat(&load.problem) };
    let mut rungs = Vec::new();
    for at in 0..if quick { 2 } else { usize::MAX } {
        let (made, setup_s) = timing::once(|| volumetric::fit_rung(&question, at));
        let Some(model) = made else { break };
        rungs.push(ObliqueRung::new(load, model.map_err(BenchError::work)?, setup_s));
    }
    let Some((finest, coarser)) = rungs.split_last() else { return Ok(sheet) };
    for rung in coarser {
        sheet.row([
            rung.unknowns.to_string(),
            percent(relative_distance(&rung.axial_m, &finest.axial_m)),
            human_time(rung.setup_s),
            human_time(rung.solve_s),
            format!("{:.1} MB", rung.bytes as f64 / 1e6),
        ]);
    }
    let (unknowns, memory) = (finest.unknowns.to_string(), format!("{:.1} MB", finest.bytes as f64 / 1e6));
    sheet.row([unknowns, "–".to_owned(), human_time(finest.setup_s), human_time(finest.solve_s), memory]);
    Ok(sheet)
}

impl ObliqueRung {
    fn new(load: &ReferenceLoad, mut model: Volumetric, setup_s: f64) -> Self {
        let solve_s = timing::median_s(TimingEffort::SHORT, || model.solve(load.force_n));
        let axial_m = load.problem.axial_m(&model);
        Self { unknowns: model.unknowns(), bytes: model.bytes(), axial_m, setup_s, solve_s }
    }
}
