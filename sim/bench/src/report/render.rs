//! Rendering: frame time for every view and quality, on this machine's graphics adapter.

use std::path::{Path, PathBuf};

use render::frame::{DrawnPuncture, Frame, Stage, View};
use render::{Headless, Quality};

use super::chart::{Chart, ChartCurve};
use super::sheet::{self, ReportSheet};
use super::{Program, Subject, measured_on, quantile, specimen};
use crate::clock;
use crate::error::BenchError;
use crate::progress::MeasurementProgress;

/// Size of the pictures, in pixels.
pub const SIZE: [u32; 2] = [1280, 720];
/// Number of timed frames of each kind, after a warm-up frame.
const FRAMES: usize = 40;
const QUICK_FRAMES: usize = 2;
/// Target frame time with everything enabled, in ms: software, hardware.
const BARS_MS: [f64; 2] = [100.0, 4.0];

/// Frame times of one kind of picture.
struct FrameRow {
    what: &'static str,
    quality: Quality,
    median_ms: f64,
    p99_ms: f64,
}

/// Measures and writes `render.{csv,md,svg}`; returns the files written.
///
/// # Errors
/// If there is no graphics adapter, or on an I/O error.
pub fn measure(out: &Path, quick: bool, program: &dyn Program) -> Result<Vec<PathBuf>, BenchError> {
    let begun = clock::instant();
    let mut headless = Headless::new(Quality::Full).map_err(BenchError::work)?;
    let block = DrawnScene::block(program)?;
    headless.set_stage(&block.stage).map_err(BenchError::work)?;
    headless.draw(&block.frames[0].1, SIZE).map_err(BenchError::work)?;
    let start_s = begun.elapsed().as_secs_f64();
    let scenes = [block, DrawnScene::body(program)?];
    let rows = rows(&mut headless, &scenes, if quick { QUICK_FRAMES } else { FRAMES })?;
    let (table, plot) = (out.join("render.csv"), out.join("render.svg"));
    csv(&rows).write_csv(&table)?;
    chart(&rows).draw(&plot)?;
    let text = sheet::write_text(out.join("render.md"), &markdown(&rows, &headless, start_s, quick))?;
    Ok(vec![table, plot, text])
}

fn rows(headless: &mut Headless, scenes: &[DrawnScene], count: usize) -> Result<Vec<FrameRow>, BenchError> {
    let frames: usize = scenes.iter().map(|scene| scene.frames.len()).sum();
    let progress = MeasurementProgress::new((Quality::ALL.len() * frames) as u64, "render");
    let mut rows = Vec::new();
    for quality in Quality::ALL {
        headless.set_quality(quality);
        for DrawnScene { stage, frames } in scenes {
            headless.set_stage(stage).map_err(BenchError::work)?;
            for (what, frame) in frames {
                let times_ms = times(headless, frame, count)?;
                rows.push(FrameRow {
                    what,
                    quality,
                    median_ms: quantile(&times_ms, 0.5),
                    p99_ms: quantile(&times_ms, 0.99),
                });
                progress.set(rows.len() as u64);
            }
        }
    }
    Ok(rows)
}

/// Returns frame times in ms, each including its completion; the first frame, which may compile
/// shaders, is not counted.
fn times(headless: &mut Headless, frame: &Frame, count: usize) -> Result<Vec<f64>, BenchError> {
    headless.draw(frame, SIZE).map_err(BenchError::work)?;
    let mut times_ms = Vec::with_capacity(count);
    for _ in 0..count {
        let start = clock::instant();
        headless.draw(frame, SIZE).map_err(BenchError::work)?;
        times_ms.push(start.elapsed().as_secs_f64() * 1e3);
    }
    Ok(times_ms)
}

/// A shipped scene with structures and a field, on its nominal patient, with pictures that show
/// everything: needle in the tissue, tents, blood, guide.
struct DrawnScene {
    stage: Stage,
    frames: Vec<(&'static str, Frame)>,
}

impl DrawnScene {
    /// Creates a block of layers, in every view.
    fn block(program: &dyn Program) -> Result<Self, BenchError> {
        let bundle = specimen::read_anatomy_exercise()?;
        let stage = program.stage(&bundle, &specimen::make_nominal_specimen(&bundle)?)?;
        // A contactor at the lowest of the four boundaries, just before it ruptures.
        let whole = needle_in(&stage, &DrawnPush { depth_m: 0.0125, boundary: 3, force_n: 1.3 });
        let frames = vec![
            ("whole", whole.clone()),
            ("whole, body faded", Frame { fade: 0.7, ..whole.clone() }),
            ("tip", Frame { view: View::Tip, ..whole.clone() }),
            ("section", Frame { view: View::Section, ..whole }),
        ];
        Ok(Self { stage, frames })
    }

    /// Creates a patient with bones, whole and as a block.
    fn body(program: &dyn Program) -> Result<Self, BenchError> {
        let bundle = specimen::read_body_exercise()?;
        let stage = program.stage(&bundle, &specimen::make_nominal_specimen(&bundle)?)?;
        // A contactor at the ligamentum flavum, just before it ruptures.
        let whole = needle_in(&stage, &DrawnPush { depth_m: 0.0475, boundary: 4, force_n: 7.6 });
        let patient = Frame { view: View::Patient, closed: true, ..whole.clone() };
        let frames = vec![
            ("patient", patient.clone()),
            ("patient, body faded", Frame { fade: 0.7, ..patient }),
            ("whole, with bones", whole.clone()),
            ("whole, with bones, body faded", Frame { fade: 0.7, ..whole }),
        ];
        Ok(Self { stage, frames })
    }
}

/// A needle that pushes on a boundary.
struct DrawnPush {
    depth_m: f32,
    boundary: usize,
    force_n: f32,
}

/// Returns the picture of a needle inserted perpendicularly.
fn needle_in(stage: &Stage, push: &DrawnPush) -> Frame {
    let DrawnPush { depth_m, boundary, force_n } = *push;
    let opened = boundary as u32;
    let puncture = DrawnPuncture { axis: [0.0, 0.0, -1.0], depth_m, opened, blood: 0.7, ..DrawnPuncture::default() };
    let loads_n = (0..stage.field.loads).map(|load| if load == boundary { force_n } else { 0.0 }).collect();
    Frame {
        tip_m: [0.0, 0.0, -depth_m],
        orientation: [1.0, 0.0, 0.0, 0.0],
        entry_m: Some([0.0; 3]),
        punctures: vec![puncture],
        guide: true,
        loads_n,
        ..Frame::default()
    }
}

fn csv(rows: &[FrameRow]) -> ReportSheet {
    let mut sheet = ReportSheet::new(["view", "quality", "median_ms", "p99_ms"]);
    for FrameRow { what, quality, median_ms, p99_ms } in rows {
        sheet.row([what.to_string(), quality.name().to_owned(), format!("{median_ms:.3}"), format!("{p99_ms:.3}")]);
    }
    sheet
}

/// Plots the frame time against the quality level, best first.
fn chart(rows: &[FrameRow]) -> Chart {
    let curve = |first: &FrameRow| {
        let own = rows.iter().filter(|row| row.what == first.what).enumerate();
        ChartCurve {
            name: first.what.to_owned(),
            points: own.map(|(at, row)| ((at + 1) as f64, row.median_ms)).collect(),
        }
    };
    Chart {
        title: format!("A frame at {} × {}", SIZE[0], SIZE[1]),
        x: "step of quality, 1 full to 5 least".to_owned(),
        y: "median time, ms".to_owned(),
        curves: rows.iter().take_while(|row| row.quality == Quality::Full).map(curve).collect(),
        ..Chart::default()
    }
}

fn markdown(rows: &[FrameRow], headless: &Headless, start_s: f64, quick: bool) -> String {
    let mut sheet = ReportSheet::new(["view", "quality", "made of", "median", "p99"]);
    for FrameRow { what, quality, median_ms, p99_ms } in rows {
        let times = [median_ms, p99_ms].map(|ms| format!("{ms:.1} ms"));
        sheet.row([
            what.to_string(),
            quality.name().to_owned(),
            quality.in_words(),
            times[0].clone(),
            times[1].clone(),
        ]);
    }
    let adapter = headless.adapter();
    let bar_ms = if adapter.software { BARS_MS[0] } else { BARS_MS[1] };
    format!(
        "# Picture\n\n{}\n\nDrawn by {adapter}: {} × {} pixels, at most {} triangles, every frame waited for. The first four views are of a block of layers with a \
         vessel and bone, the others of a patient from numbers. From \
         nothing to the first frame: {start_s:.1} s. The bar on this kind of adapter is {bar_ms} ms at the median; the window \
         starts at the best quality that its adapter holds, and goes down a step rather than stutter.\n\n{}\n![time of a \
         frame](render.svg)\n",
        measured_on(Subject::Render, quick),
        SIZE[0],
        SIZE[1],
        headless.renderer().triangles(),
        sheet.markdown()
    )
}
