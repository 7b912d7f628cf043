//! Coupling: the error of the field's force compared with that of the law, against the rate of the
//! field.

use std::path::{Path, PathBuf};

use law::axial::AxialParams;
use tissue::follow::{HandOver, StraightInsertion, hand_over};

use super::chart::{Chart, ChartCurve};
use super::sheet::{self, ReportSheet};
use super::{Subject, measured_on, specimen};
use crate::error::BenchError;

const RATES_HZ: [f64; 8] = [15.0, 30.0, 60.0, 120.0, 240.0, 333.0, 500.0, 1000.0];
const SPEEDS_MM_PER_S: [f64; 3] = [2.0, 10.0, 30.0];
/// Depth of the insertions, in m.
const DEPTH_M: f64 = 0.03;
/// Amplitude of the tremor, in m, as of an intermediate hand.
const TREMOR_M: f64 = 1e-4;
/// Default rate of the field, in Hz.
const FIELD_HZ: f64 = 120.0;

/// An insertion at one rate.
struct CouplingRow {
    speed_mm_per_s: f64,
    tremor_mm: f64,
    rate_hz: f64,
    error: HandOver,
}

/// Measures the training scene and writes `coupling.{csv,md,svg}`; returns the files written.
///
/// # Errors
/// On an I/O error.
pub fn measure(out: &Path, quick: bool) -> Result<Vec<PathBuf>, BenchError> {
    let params = AxialParams::new(specimen::nominal_axial_spec(&specimen::read_training_exercise()?.scene))
        .map_err(BenchError::work)?;
    let mut rows = Vec::new();
    for speed_mm_per_s in SPEEDS_MM_PER_S {
        for tremor_m in [0.0, TREMOR_M] {
            let insertion = StraightInsertion { speed_m_per_s: speed_mm_per_s * 1e-3, depth_m: DEPTH_M, tremor_m };
            rows.extend(RATES_HZ.map(|rate_hz| CouplingRow {
                speed_mm_per_s,
                tremor_mm: tremor_m * 1e3,
                rate_hz,
                error: hand_over(&params, &insertion, rate_hz),
            }));
        }
    }
    let (table, plot) = (out.join("coupling.csv"), out.join("coupling.svg"));
    csv(&rows).write_csv(&table)?;
    chart(&rows).draw(&plot)?;
    let text = sheet::write_text(out.join("coupling.md"), &markdown(&rows, quick))?;
    Ok(vec![table, text, plot])
}

fn csv(rows: &[CouplingRow]) -> ReportSheet {
    let mut sheet = ReportSheet::new(["speed_mm_per_s", "tremor_mm", "field_hz", "held", "extrapolated", "forecast"]);
    for CouplingRow { speed_mm_per_s, tremor_mm, rate_hz, error } in rows {
        let HandOver { held, extrapolated, forecast } = error;
        sheet.row([*speed_mm_per_s, *tremor_mm, *rate_hz, *held, *extrapolated, *forecast].map(|n| format!("{n:?}")));
    }
    sheet
}

/// Plots the insertion at 10 mm/s without tremor.
fn chart(rows: &[CouplingRow]) -> Chart {
    let curve = |name: &str, of: fn(&HandOver) -> f64| {
        let steady = rows.iter().filter(|row| (row.speed_mm_per_s, row.tremor_mm) == (10.0, 0.0));
        ChartCurve { name: name.to_owned(), points: steady.map(|row| (row.rate_hz, 1e2 * of(&row.error))).collect() }
    };
    Chart {
        title: "Force that the field carries, training scene at 10 mm/s".to_owned(),
        x: "rate of the field, Hz".to_owned(),
        y: "rms error, % of the peak force".to_owned(),
        curves: vec![
            curve("held", |error| error.held),
            curve("extrapolated", |error| error.extrapolated),
            curve("forecast by the law", |error| error.forecast),
        ],
        ..Chart::default()
    }
}

fn markdown(rows: &[CouplingRow], quick: bool) -> String {
    let mut sheet = ReportSheet::new(["speed", "tremor of 10 Hz", "held", "extrapolated", "forecast by the law"]);
    for row in rows.iter().filter(|row| (row.rate_hz - FIELD_HZ).abs() < 0.5) {
        let [held, extrapolated, forecast] =
            [row.error.held, row.error.extrapolated, row.error.forecast].map(|error| format!("{:.3} %", 1e2 * error));
        let (speed, tremor) = (format!("{} mm/s", row.speed_mm_per_s), format!("{} mm", row.tremor_mm));
        sheet.row([speed, tremor, held, extrapolated, forecast]);
    }
    format!(
        "# Coupling\n\n{}\n\nThe force law runs at 1 kHz, the field beside it at its own rate. Error: rms over an insertion of \
         the training scene to 30 mm of the force that the field carries at each millisecond, as a share of the peak force. \
         *Held*: the last force taken; *extrapolated*: with its last rate of change; *forecast*: the law's closed form, run \
         ahead with the needle's last velocity, which knows when the next boundary gives way: what a field \
         beside the law should carry. The bar is 1 % at 120 Hz and 10 mm/s.\n\n## At 120 Hz\n\n{}\n![coupling](coupling.svg)\n",
        measured_on(Subject::Coupling, quick),
        sheet.markdown()
    )
}
