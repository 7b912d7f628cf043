//! A device that falters or is lost in the tissue: rendered force compared with the required force,
//! tick by tick.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use documents::ExerciseBundle;
use haptics::device::{Device, DeviceInfo};
use haptics::devices::scripted::{Fault, Scripted};
use haptics::mapping::{Home, Mapping, Pointing};
use haptics::safety::flags;
use haptics::servo::{Engine, Record, Setup, TickMoment};
use nalgebra::{Point3, Vector3};
use plotters::prelude::*;

use super::chart::{self, Drawn, FONT, SeriesLabelPosition, colour, key};
use super::sheet::{self, ReportSheet};
use super::{Subject, measured_on, specimen};
use crate::error::BenchError;

const TICK_HZ: f64 = 1000.0;
/// Speed of the handle, in m/s, and its starting height above the skin, in m.
const SPEED_M_PER_S: f64 = 0.005;
const APPROACH_M: f64 = 0.005;
/// Target depth of the exercise, in m.
const REACH_M: f64 = 0.03;
/// Number of readings of a run: seven seconds, 30 mm of tissue.
const READINGS: u32 = 7000;
const SIZE: (u32, u32) = (960, 420);

/// A fault of the device.
struct Mishap {
    name: &'static str,
    title: &'static str,
    fault: Fault,
    /// First affected reading, and number of affected readings.
    begins: u64,
    lasts: u64,
}

const MISHAPS: [Mishap; 2] = [
    Mishap { name: "hiccup", title: "the same reading for 200 ms", fault: Fault::Freeze, begins: 3000, lasts: 200 },
    Mishap { name: "lost", title: "the device is gone", fault: Fault::Disconnect, begins: 4000, lasts: u64::MAX },
];

/// A tick: time in s, depth in mm, required and rendered force in N.
struct Point {
    t_s: f64,
    depth_mm: f64,
    owed_n: f64,
    given_n: f64,
    flags: u32,
}

/// Runs each mishap and writes `hiccup.md` and a table and a plot of each; returns the files
/// written.
///
/// # Errors
/// On an I/O error.
pub fn measure(out: &Path, quick: bool) -> Result<Vec<PathBuf>, BenchError> {
    let bundle = specimen::read_training_exercise()?;
    let mut summary =
        ReportSheet::new(["mishap", "at, s", "force gone after, ms", "whole again after, s", "unfelt, s"]);
    let mut written = Vec::new();
    for mishap in &MISHAPS {
        let points = run(&bundle, mishap)?;
        let plot = out.join(format!("hiccup-{}.svg", mishap.name));
        chart::finish(picture(&plot, mishap, &points), &plot)?;
        let table = plot.with_extension("csv");
        ticks(&points).write_csv(&table)?;
        summary.row(summed_up(mishap, &points));
        written.extend([plot, table]);
    }
    let text = format!(
        "# A hiccup of the device in the tissue\n\n{}\n\nA scripted arm with the limits of a Touch goes into the training scene at \
         5 mm/s. Times are simulated, not measured: every machine gives the same.\n\n{}",
        measured_on(Subject::Hiccup, quick),
        summary.markdown()
    );
    written.push(sheet::write_text(out.join("hiccup.md"), &text)?);
    Ok(written)
}

/// Returns the limits of a Touch.
fn touch() -> DeviceInfo {
    DeviceInfo {
        name: "Touch".to_owned(),
        serial: None,
        max_force_n: 3.3,
        continuous_force_n: 0.88,
        max_stiffness_n_per_m: 400.0,
        workspace_m: [0.16, 0.12, 0.07],
        measures_orientation: true,
        is_virtual: false,
    }
}

fn run(bundle: &ExerciseBundle, mishap: &Mishap) -> Result<Vec<Point>, BenchError> {
    let specimen = specimen::make_nominal_specimen(bundle)?;
    let mut device =
        Scripted::new(SPEED_M_PER_S, TICK_HZ).as_device(touch()).with(mishap.fault, mishap.begins, mishap.lasts);
    let home = Home::above(Point3::origin(), -Vector3::z_axis(), APPROACH_M);
    let setup = Setup::new(
        Arc::clone(specimen.law()),
        Mapping::at_home(home, Pointing::Planned),
        device.info(),
        REACH_M,
        TICK_HZ,
    );
    let (mut engine, mut records, mut latest) = Engine::new(setup).map_err(BenchError::work)?;
    let mut points = Vec::new();
    for reading in 0..READINGS {
        let moment = TickMoment { now_s: f64::from(reading) / TICK_HZ, late_s: 0.0 };
        let Some(force_n) = engine.tick(device.read(), &moment, &|| moment.now_s) else { break };
        engine.wrote(device.write(&force_n));
        let owed_n = latest.read().map_or(0.0, |latest| latest.owed_n.norm());
        points.extend(std::iter::from_fn(|| records.pop()).map(|record| point(&record, owed_n)));
    }
    Ok(points)
}

fn point(record: &Record, owed_n: f64) -> Point {
    let norm_n = |force_n: [f32; 3]| Vector3::from(force_n).cast::<f64>().norm();
    Point {
        t_s: record.t_s,
        depth_mm: -record.position_m[2] * 1e3,
        owed_n,
        given_n: norm_n(record.device_n),
        flags: record.flags,
    }
}

fn ticks(points: &[Point]) -> ReportSheet {
    let mut sheet = ReportSheet::new(["t_s", "tip_depth_mm", "owed_n", "given_n", "flags"]);
    for Point { t_s, depth_mm, owed_n, given_n, flags } in points {
        sheet.row([
            format!("{t_s:.3}"),
            format!("{depth_mm:.3}"),
            format!("{owed_n:.4}"),
            format!("{given_n:.4}"),
            flags.to_string(),
        ]);
    }
    sheet
}

/// Returns a line of the report. A lost device ends the attempt, and the last force sent is zero.
fn summed_up(mishap: &Mishap, points: &[Point]) -> Vec<String> {
    let begins = mishap.begins as usize;
    let after = points.get(begins..).unwrap_or_default();
    let gone = after.iter().position(|point| point.given_n <= 0.0);
    let whole = |gone: usize| after.iter().skip(gone).position(|point| point.given_n > 0.98 * point.owed_n);
    let whole = gone.and_then(|gone| Some(gone + whole(gone)?));
    let unfelt = points.iter().filter(|point| point.flags & flags::UNFELT != 0).count();
    let seconds = |ticks: usize| format!("{:.2}", ticks as f64 / TICK_HZ);
    vec![
        mishap.name.to_owned(),
        seconds(begins),
        gone.map_or("at once: the attempt is over, and void".to_owned(), |ticks| ticks.to_string()),
        whole.map_or("never".to_owned(), seconds),
        seconds(unfelt),
    ]
}

fn picture(path: &Path, mishap: &Mishap, points: &[Point]) -> Drawn {
    let root = SVGBackend::new(path, SIZE).into_drawing_area();
    root.fill(&WHITE)?;
    let top_n = points.iter().fold(0.0_f64, |top, point| top.max(point.owed_n)) * 1.25;
    let mut canvas = ChartBuilder::on(&root)
        .caption(format!("{}, at {:.1} s in the tissue", mishap.title, mishap.begins as f64 / TICK_HZ), (FONT, 20))
        .margin(16)
        .x_label_area_size(46)
        .y_label_area_size(60)
        .build_cartesian_2d(0.0..f64::from(READINGS) / TICK_HZ, 0.0..top_n)?;
    canvas
        .configure_mesh()
        .light_line_style(TRANSPARENT)
        .bold_line_style(BLACK.mix(0.12))
        .x_desc("time, s")
        .y_desc("force on the hand, N")
        .label_style((FONT, 14))
        .axis_desc_style((FONT, 16))
        .draw()?;
    let every = || points.iter().step_by(4);
    let owed = every().map(|point| (point.t_s, point.owed_n));
    let given = every().map(|point| (point.t_s, point.given_n));
    canvas.draw_series(LineSeries::new(owed, colour(1).stroke_width(2)))?.label("owed by the tissue").legend(key(1));
    canvas.draw_series(LineSeries::new(given, colour(0).stroke_width(2)))?.label("given to the hand").legend(key(0));
    canvas
        .configure_series_labels()
        .position(SeriesLabelPosition::UpperLeft)
        .background_style(WHITE.mix(0.85))
        .label_font((FONT, 14))
        .draw()?;
    root.present()?;
    Ok(())
}
