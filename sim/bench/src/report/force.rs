//! The force law: delay and excess force of a rupture at a tick rate and a speed, compared with the
//! closed form.

use std::path::{Path, PathBuf};

use law::Incidence;
use law::axial::{self, AxialInput, AxialParams, AxialScratch, AxialSpec, AxialState, Contactor};
use law::closed_form::{self, PredictedRupture};

use super::chart::{Chart, ChartCurve};
use super::fibres::{self, FibresReport};
use super::pace;
use super::sheet::{self, ReportSheet};
use super::{Subject, curve, encoder, measured_on, specimen};
use crate::error::BenchError;
use crate::progress::MeasurementProgress;
use trials::scenes::{ALL_OPTIONS, with_options};

const RATES_HZ: [f64; 6] = [100.0, 250.0, 500.0, 1000.0, 2000.0, 4000.0];
const SPEEDS_MM_PER_S: [f64; 7] = [1.0, 2.0, 5.0, 10.0, 20.0, 50.0, 100.0];
/// Number of offsets per case: the position of the first sample within a tick determines the delay
/// of a rupture.
const PHASES: u32 = 16;
/// Start of an insertion, and its end beyond the last rupture, in m of the tip's displacement.
const FROM_M: f64 = -0.001;
const BEYOND_M: f64 = 0.001;

/// Largest errors over all ruptures of both scenes.
#[derive(Clone, Copy, Default)]
struct Worst {
    late_m: f64,
    excess_n: f64,
    missing: usize,
}

/// One case of the grid.
struct Case {
    rate_hz: f64,
    speed_mm_per_s: f64,
    worst: Worst,
}

/// Measures and writes `force*.{csv,md,svg}`; returns the files written.
///
/// # Errors
/// On an I/O error.
pub fn measure(out: &Path, quick: bool) -> Result<Vec<PathBuf>, BenchError> {
    let [paper, training] = specimen::read_both_exercises()?;
    let specs = [specimen::nominal_axial_spec(&paper.scene), specimen::nominal_axial_spec(&training.scene)];
    let cases = grid(&specs, quick)?;
    let paces = [pace::measure(&specs[1], quick)?, pace::measure(&with_options(specs[1].clone(), ALL_OPTIONS), quick)?];
    let mut written = curve::draw(out, &[&paper.scene, &training.scene])?;
    let encoder::EncoderReport { written: of_encoder, markdown: on_an_encoder } = encoder::measure(out, &specs[1])?;
    written.extend(of_encoder);
    let FibresReport { written: of_fibres, markdown: of_edges } = fibres::measure(out, &training.scene)?;
    written.extend(of_fibres);
    let table = out.join("force-error.csv");
    sheet(&cases).write_csv(&table)?;
    let plot = out.join("force-error.svg");
    chart(&cases).draw(&plot)?;
    let pace = pace::markdown(specs[1].layers.len(), &paces[0], &paces[1]);
    let report = markdown(&measured_on(Subject::Force, quick), &cases, &pace) + &on_an_encoder + &of_edges;
    written.extend([table, plot, sheet::write_text(out.join("force.md"), &report)?]);
    Ok(written)
}

fn grid(specs: &[AxialSpec], quick: bool) -> Result<Vec<Case>, BenchError> {
    let progress = MeasurementProgress::new((SPEEDS_MM_PER_S.len() * RATES_HZ.len()) as u64, "force law");
    let phases = if quick { 1 } else { PHASES };
    let mut cases = Vec::new();
    for speed_mm_per_s in SPEEDS_MM_PER_S {
        for rate_hz in RATES_HZ {
            let mut worst = Worst::default();
            for spec in specs {
                for phase in 0..phases {
                    let offset = f64::from(phase) / f64::from(phases);
                    insert(spec, speed_mm_per_s * 1e-3 / rate_hz, rate_hz, offset, &mut worst)?;
                }
            }
            cases.push(Case { rate_hz, speed_mm_per_s, worst });
            progress.advance(1);
        }
    }
    Ok(cases)
}

/// Inserts by `advance_m` per tick, starting with an offset of a fraction of a tick, and updates
/// the largest errors.
fn insert(spec: &AxialSpec, advance_m: f64, rate_hz: f64, offset: f64, worst: &mut Worst) -> Result<(), BenchError> {
    let params = AxialParams::new(spec.clone()).map_err(BenchError::work)?;
    let (mut state, mut scratch) = (AxialState::new(&params), AxialScratch::new(&params));
    let exact = closed_form::predict_ruptures(spec);
    let end_m = exact.last().map_or(0.0, |last| last.x_m) + BEYOND_M;
    let ticks = ((end_m - FROM_M) / advance_m) as u32 + 1;
    let mut met = 0;
    for tick in 0..=ticks {
        let x_m = FROM_M + (f64::from(tick) + offset) * advance_m;
        let input = AxialInput { t_s: f64::from(tick) / rate_hz, x_m, incidence: Incidence::UPRIGHT };
        axial::step(&params, &mut state, &mut scratch, &input);
        // The order of ruptures within a tick may differ, so look each one up.
        for rupture in &scratch.ruptures {
            let same =
                |exact: &&PredictedRupture| (exact.contactor, exact.boundary) == (rupture.contactor, rupture.boundary);
            let Some(exact) = exact.iter().find(same) else { continue };
            met += 1;
            worst.late_m = worst.late_m.max(rupture.x_m - exact.x_m);
            worst.excess_n = worst.excess_n.max(rupture.force_n - threshold_n(spec, exact));
        }
    }
    worst.missing += exact.len() - met;
    Ok(())
}

/// Returns the force that opens a boundary, in N.
fn threshold_n(spec: &AxialSpec, rupture: &PredictedRupture) -> f64 {
    let layer = &spec.layers[rupture.boundary];
    match rupture.contactor {
        Contactor::Tip => layer.tip_rupture_n,
        Contactor::Rim => layer.rim_rupture_n,
    }
}

fn sheet(cases: &[Case]) -> ReportSheet {
    let mut sheet =
        ReportSheet::new(["tick_hz", "speed_mm_per_s", "late_mm", "one_tick_mm", "excess_force_n", "ruptures_missing"]);
    for Case { rate_hz, speed_mm_per_s, worst } in cases {
        let numbers = [*rate_hz, *speed_mm_per_s, worst.late_m * 1e3, speed_mm_per_s / rate_hz, worst.excess_n];
        sheet.row(numbers.map(|n| format!("{n}")).into_iter().chain([format!("{}", worst.missing)]));
    }
    sheet
}

fn chart(cases: &[Case]) -> Chart {
    let curves = SPEEDS_MM_PER_S.map(|speed| ChartCurve {
        name: format!("{speed} mm/s"),
        points: cases
            .iter()
            .filter(|case| case.speed_mm_per_s.total_cmp(&speed).is_eq())
            .map(|case| (case.rate_hz, case.worst.late_m * 1e3))
            .collect(),
    });
    Chart {
        title: "A rupture is late by at most one tick".to_owned(),
        x: "tick rate, Hz".to_owned(),
        y: "largest lateness of a rupture, mm".to_owned(),
        curves: curves.into(),
        ..Chart::default()
    }
}

fn markdown(measured_on: &str, cases: &[Case], pace: &str) -> String {
    let header = RATES_HZ.iter().map(|rate| format!("{rate} Hz"));
    let mut late = ReportSheet::new(std::iter::once("speed".to_owned()).chain(header));
    for of_speed in cases.chunks(RATES_HZ.len()) {
        let cell = |case: &Case| format!("{:.4} mm, {:.4} N", case.worst.late_m * 1e3, case.worst.excess_n);
        let speed = of_speed.first().map_or(0.0, |case| case.speed_mm_per_s);
        late.row(std::iter::once(format!("{speed} mm/s")).chain(of_speed.iter().map(cell)));
    }
    let missing: usize = cases.iter().map(|case| case.worst.missing).sum();
    format!(
        "# Force law\n\n{}\n\n## Error against tick rate and speed\n\nLargest lateness of a rupture (bound: one tick, \
         speed / rate) and largest force above its threshold, over all ruptures of the paper's and the training scene, \
         constant speed, {PHASES} offsets within a tick. Ruptures of the closed form \
         that did not come: {missing}.\n\n{}\n![lateness](force-error.svg)\n\n## Time per \
         tick\n\n{}\n## Force against depth at 2 mm/s\n\nDashed: the ruptures in closed form.\n\n![force against depth, \
         the paper's scene](force-depth-lower-back-paper.svg)\n![force against depth, the training \
         scene](force-depth-lower-back-training.svg)\n",
        measured_on,
        late.markdown(),
        pace
    )
}
