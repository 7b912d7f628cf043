//! Recordings: size, time to write a tick, speed of the simulation, time and memory to read and
//! score.

use std::fs::{self, File};
use std::io::{BufReader, BufWriter, Write};
use std::path::{Path, PathBuf};

use ::recording::write::SceneDrawing;
use ::recording::{Recording, Session, Writer};
use attempt::simulate::{self, Clock};
use documents::{ExerciseBundle, Patient};

use super::chart::{Chart, ChartCurve};
use super::motion::Rehearsal;
use super::sheet::{self, ReportSheet};
use super::{Subject, measured_on, quantile, specimen};
use crate::error::BenchError;
use crate::{clock, machine};

const TICK_HZ: f64 = 1000.0;
/// Duration of the attempt for which "× real time" is specified, in s.
const ATTEMPT_S: f64 = 30.0;
/// Duration of the recording that is read and scored, in s.
const LONG_S: f64 = 600.0;

/// All measurements.
struct MeasuredRecording {
    times_real_time: f64,
    bytes_per_s: f64,
    /// Time to write each tick, in µs, sorted.
    tick_us: Vec<f64>,
    long_s: f64,
    long_bytes: u64,
    read_s: f64,
    score_s: f64,
    peak_bytes: Option<u64>,
}

/// Measures and writes `recording.{csv,md,svg}`; returns the files written.
///
/// # Errors
/// On an I/O error.
pub fn measure(out: &Path, quick: bool) -> Result<Vec<PathBuf>, BenchError> {
    let share = if quick { 0.01 } else { 1.0 };
    let bundle = specimen::read_training_exercise()?;
    let scratch = tempfile::tempdir_in(out).map_err(|error| BenchError::refused(out, error))?;
    let file = scratch.path().join("attempt.mcap");
    let attempt_s = (ATTEMPT_S * share).max(1.0);
    let wall_s = simulate_into(&file, &bundle, attempt_s)?;
    let bytes = size(&file)?;
    let tick_us = time_writing(&file, &bundle)?;
    let long_s = (LONG_S * share).max(1.0);
    simulate_into(&file, &bundle, long_s)?;
    let long_bytes = size(&file)?;
    machine::reset_peak_memory();
    let (read_s, score_s) = read_and_score(&file)?;
    let measured = MeasuredRecording {
        times_real_time: attempt_s / wall_s,
        bytes_per_s: bytes as f64 / attempt_s,
        tick_us,
        long_s,
        long_bytes,
        read_s,
        score_s,
        peak_bytes: machine::peak_memory_bytes(),
    };
    report(out, &measured_on(Subject::Recording, quick), &measured)
}

/// Simulates and records an attempt of a duration in s; returns the wall time, in s.
fn simulate_into(path: &Path, bundle: &ExerciseBundle, length_s: f64) -> Result<f64, BenchError> {
    let specimen = specimen::make_nominal_specimen(bundle)?;
    let pace = Clock { tick_hz: TICK_HZ, time_limit_s: length_s };
    let mut hand = Rehearsal::new(bundle.exercise.plan(), length_s);
    let start = clock::instant();
    let mut file = create(path)?;
    let mut writer = writer(&mut file, &specimen::make_session(bundle, TICK_HZ), bundle, path)?;
    simulate::simulate(&specimen, &mut hand, &mut writer, &pace)
        .and_then(|_| writer.finish().map(drop))
        .map_err(|error| BenchError::work(format_args!("{}: {error}", path.display())))?;
    Ok(start.elapsed().as_secs_f64())
}

/// Begins a recording of an exercise.
fn writer<W: Write>(
    file: W,
    session: &Session,
    bundle: &ExerciseBundle,
    path: &Path,
) -> Result<Writer<BufWriter<W>>, BenchError> {
    let patient = Patient { thickness_mm: session.patient_thickness_mm.clone() };
    let drawing =
        SceneDrawing::from_spec(&bundle.scene.puncture_spec(&patient), bundle.scene.needle.diameter_mm * 0.5e-3);
    Writer::create(BufWriter::new(file), session, &assessment::attachments(bundle), &drawing)
        .map_err(|error| BenchError::work(format_args!("{}: {error}", path.display())))
}

fn open(path: &Path) -> Result<File, BenchError> {
    File::open(path).map_err(|error| BenchError::refused(path, error))
}

/// Writes the recording's ticks to a second file and times each; in µs, sorted.
fn time_writing(path: &Path, bundle: &ExerciseBundle) -> Result<Vec<f64>, BenchError> {
    let recording = read(path)?;
    let again = path.with_extension("again");
    let mut file = create(&again)?;
    let mut writer = writer(&mut file, &recording.session, bundle, &again)?;
    let mut tick_us = Vec::with_capacity(recording.samples.len());
    for sample in &recording.samples {
        let start = clock::instant();
        let wrote = writer.sample(sample);
        tick_us.push(start.elapsed().as_secs_f64() * 1e6);
        wrote.map_err(|error| BenchError::work(format_args!("{}: {error}", again.display())))?;
    }
    Ok(tick_us)
}

/// Reads and scores; returns the wall time of each, in s.
fn read_and_score(path: &Path) -> Result<(f64, f64), BenchError> {
    let start = clock::instant();
    let recording = read(path)?;
    let read_s = start.elapsed().as_secs_f64();
    let bundle = assessment::own_exercise(&recording).map_err(|error| BenchError::refused(path, error))?;
    assessment::assess(&recording, &bundle).map_err(|error| BenchError::refused(path, error))?;
    Ok((read_s, start.elapsed().as_secs_f64() - read_s))
}

fn read(path: &Path) -> Result<Recording, BenchError> {
    Recording::read(BufReader::new(open(path)?)).map_err(|error| BenchError::refused(path, error))
}

fn create(path: &Path) -> Result<File, BenchError> {
    File::create(path).map_err(|error| BenchError::work(format_args!("{}: {error}", path.display())))
}

fn size(path: &Path) -> Result<u64, BenchError> {
    fs::metadata(path).map(|metadata| metadata.len()).map_err(|error| BenchError::refused(path, error))
}

fn report(out: &Path, measured_on: &str, measured: &MeasuredRecording) -> Result<Vec<PathBuf>, BenchError> {
    let sheet = sheet(measured);
    let (table, plot) = (out.join("recording.csv"), out.join("recording.svg"));
    sheet.write_csv(&table)?;
    chart(&measured.tick_us).draw(&plot)?;
    let text = format!(
        "# Recording\n\n{}\n\nA tick is written at 1 kHz, with everything due on the slower topics; the share of a core is the \
         mean time per tick over 1 ms. Memory is the process's peak while it reads and scores.\n\n{}\n![time to write a \
         tick](recording.svg)\n",
        measured_on,
        sheet.markdown()
    );
    Ok(vec![table, plot, sheet::write_text(out.join("recording.md"), &text)?])
}

fn sheet(measured: &MeasuredRecording) -> ReportSheet {
    let ticks = &measured.tick_us;
    let mean_us = ticks.iter().sum::<f64>() / ticks.len().max(1) as f64;
    let long = format!("{:.0} s recording", measured.long_s);
    let mut sheet = ReportSheet::new(["what", "value", "unit", "bar"]);
    let mut row = |what: &str, value: f64, unit: &str, bar: &str| {
        sheet.row([what, &format!("{value:.2}"), unit, bar]);
    };
    row("simulate, everything recorded", measured.times_real_time, "× real time", "≥ 50");
    row("size", measured.bytes_per_s * 1e-3, "kB per second", "");
    row("size of 60 s", measured.bytes_per_s * 60e-6, "MB", "≤ 12");
    row("write a tick, median", quantile(ticks, 0.5), "µs", "");
    row("write a tick, p99", quantile(ticks, 0.99), "µs", "");
    row("write a tick, most", quantile(ticks, 1.0), "µs", "");
    row("write at 1 kHz", mean_us * 1e-3 * 100.0, "% of a core", "≤ 3");
    row(&format!("{long}, size"), measured.long_bytes as f64 * 1e-6, "MB", "");
    row(&format!("{long}, read"), measured.read_s, "s", "");
    row(&format!("{long}, score"), measured.score_s, "s", "");
    row(&format!("{long}, read and score"), measured.read_s + measured.score_s, "s", "≤ 2");
    if let Some(bytes) = measured.peak_bytes {
        row(&format!("{long}, peak memory"), bytes as f64 * 1e-6, "MB resident", "≤ 200");
    }
    sheet
}

/// Plots the share of ticks that take longer than a time.
fn chart(sorted_us: &[f64]) -> Chart {
    let ticks = sorted_us.len();
    // Skip neighbours that would be drawn on the same pixel, but never the slowest ticks.
    let shown = |index: &usize| index.is_multiple_of(100) || index + 100 > ticks;
    let points = (0..ticks).filter(shown).map(|index| (sorted_us[index], (ticks - index) as f64 / ticks as f64));
    Chart {
        title: "Time to write one tick".to_owned(),
        x: "time, µs".to_owned(),
        y: "share of ticks that take longer".to_owned(),
        curves: vec![ChartCurve { name: String::new(), points: points.collect() }],
        ..Chart::default()
    }
}
