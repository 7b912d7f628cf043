//! Force against depth at 2 mm/s, with the closed-form ruptures: the figure of the paper.

use std::path::{Path, PathBuf};

use documents::Scene;
use law::Incidence;
use law::axial::{self, AxialInput, AxialParams, AxialScratch, AxialSpec, AxialState};
use law::closed_form;
use plotters::prelude::*;

use super::chart::{self, Drawn, FONT, INK, colour, key};
use super::sheet::ReportSheet;
use super::specimen;
use crate::error::BenchError;

const SPEED_M_PER_S: f64 = 0.002;
const TICK_HZ: f64 = 1000.0;
/// Depth shown beyond the last rupture, in mm.
const BEYOND_MM: f64 = 3.0;
const ABOVE_MM: f64 = 1.0;
const SIZE: (u32, u32) = (960, 540);

/// Displacement in mm, axial force and its elastic part in N.
type Point = (f64, f64, f64);

/// Plots each scene and writes the data as CSV; returns the files written.
///
/// # Errors
/// On an I/O error.
pub fn draw(out: &Path, scenes: &[&Scene]) -> Result<Vec<PathBuf>, BenchError> {
    let mut written = Vec::new();
    for scene in scenes {
        let spec = specimen::nominal_axial_spec(scene);
        let points = insertion(&spec)?;
        let plot = out.join(format!("force-depth-{}.svg", scene.id));
        chart::finish(picture(&plot, scene, &spec, &points), &plot)?;
        let table = plot.with_extension("csv");
        sheet(&points).write_csv(&table)?;
        written.extend([plot, table]);
    }
    Ok(written)
}

fn insertion(spec: &AxialSpec) -> Result<Vec<Point>, BenchError> {
    let params = AxialParams::new(spec.clone()).map_err(BenchError::work)?;
    let (mut state, mut scratch) = (AxialState::new(&params), AxialScratch::new(&params));
    let ticks = ((end_mm(spec) + ABOVE_MM) * 1e-3 / SPEED_M_PER_S * TICK_HZ) as u32;
    let point = |tick: u32| {
        let t_s = f64::from(tick) / TICK_HZ;
        let x_m = t_s * SPEED_M_PER_S - ABOVE_MM * 1e-3;
        let output =
            axial::step(&params, &mut state, &mut scratch, &AxialInput { t_s, x_m, incidence: Incidence::UPRIGHT });
        (x_m * 1e3, output.total_n(), output.tip_n + output.rim_n)
    };
    Ok((0..=ticks).map(point).collect())
}

fn end_mm(spec: &AxialSpec) -> f64 {
    closed_form::predict_ruptures(spec).last().map_or(0.0, |last| last.x_m * 1e3) + BEYOND_MM
}

fn sheet(points: &[Point]) -> ReportSheet {
    let mut sheet = ReportSheet::new(["x_mm", "force_n", "elastic_n"]);
    for (x, force, elastic) in points {
        sheet.row([x, force, elastic].map(|n| format!("{n:?}")));
    }
    sheet
}

fn picture(path: &Path, scene: &Scene, spec: &AxialSpec, points: &[Point]) -> Drawn {
    let root = SVGBackend::new(path, SIZE).into_drawing_area();
    root.fill(&WHITE)?;
    // Leave the upper third for the labels of the ruptures.
    let top_n = points.iter().fold(0.0_f64, |top, point| top.max(point.1)) * 1.45;
    let mut canvas = ChartBuilder::on(&root)
        .caption(format!("{}, constant 2 mm/s", scene.title), (FONT, 22))
        .margin(16)
        .x_label_area_size(46)
        .y_label_area_size(60)
        .build_cartesian_2d(-ABOVE_MM..end_mm(spec), 0.0..top_n)?;
    for Band { name, area, tint } in bands(scene, spec, top_n) {
        let square = move |(x, y)| Rectangle::new([(x + 3, y - 6), (x + 17, y + 6)], tint.filled());
        canvas.draw_series([area])?.label(name).legend(square);
    }
    canvas
        .configure_mesh()
        .disable_x_mesh()
        .light_line_style(TRANSPARENT)
        .bold_line_style(BLACK.mix(0.12))
        .x_desc("displacement of the tip from the skin, mm")
        .y_desc("axial force on the hand, N")
        .label_style((FONT, 14))
        .axis_desc_style((FONT, 16))
        .draw()?;
    for mark in marks(spec, top_n) {
        canvas.draw_series(DashedLineSeries::new(mark.line, 4, 4, INK.mix(0.6).stroke_width(1)))?;
        canvas.draw_series([Text::new(mark.label, mark.place, (FONT, 13).into_font().color(&INK))])?;
    }
    let shown = visible(points);
    let elastic = shown.iter().map(|&(x, _, elastic)| (x, elastic));
    let force = shown.iter().map(|&(x, force, _)| (x, force));
    canvas.draw_series(LineSeries::new(elastic, colour(1).stroke_width(1)))?.label("elastic part").legend(key(1));
    canvas.draw_series(LineSeries::new(force, colour(0).stroke_width(2)))?.label("axial force").legend(key(0));
    let legend = SeriesLabelPosition::MiddleRight;
    canvas
        .configure_series_labels()
        .position(legend)
        .background_style(WHITE.mix(0.9))
        .border_style(INK.mix(0.4))
        .label_font((FONT, 14))
        .draw()?;
    root.present()?;
    Ok(())
}

/// Returns the points at which a line bends. The picture's coordinates are whole pixels: a straight
/// segment drawn through all of its points would have steps, and ten times the bytes.
fn visible(points: &[Point]) -> Vec<Point> {
    /// Smallest change of either slope per tick that counts as a bend, in N.
    const BEND_N: f64 = 1e-6;
    let rise = |pair: &[Point]| (pair[1].1 - pair[0].1, pair[1].2 - pair[0].2);
    let mut shown: Vec<Point> = points.first().copied().into_iter().collect();
    let mut before = points.first_chunk::<2>().map_or((0.0, 0.0), |pair| rise(pair));
    for pair in points.windows(2) {
        let now = rise(pair);
        if (now.0 - before.0).abs() > BEND_N || (now.1 - before.1).abs() > BEND_N {
            shown.push(pair[0]);
            before = now;
        }
    }
    shown.extend(points.last());
    shown
}

/// A layer at its undeformed depth.
struct Band {
    name: String,
    area: Rectangle<(f64, f64)>,
    tint: RGBColor,
}

fn bands(scene: &Scene, spec: &AxialSpec, top_n: f64) -> Vec<Band> {
    let end_mm = end_mm(spec);
    let mut from_mm = 0.0;
    let mut bands = Vec::new();
    for (layer, met) in scene.layers.iter().zip(&spec.layers) {
        let to_mm = (from_mm + met.thickness_m * 1e3).min(end_mm);
        let tint = tint(&layer.texture);
        bands.push(Band {
            name: layer.name.clone(),
            area: Rectangle::new([(from_mm, 0.0), (to_mm, top_n)], tint.filled()),
            tint,
        });
        from_mm = to_mm;
    }
    bands
}

/// Returns a light colour for a tissue's texture.
fn tint(texture: &str) -> RGBColor {
    match texture {
        "skin" => RGBColor(252, 226, 210),
        "fat" => RGBColor(255, 246, 208),
        "muscle" => RGBColor(249, 220, 220),
        _ => RGBColor(226, 228, 240),
    }
}

/// A closed-form rupture: a dashed line with a label at its upper end.
struct Mark {
    line: [(f64, f64); 2],
    label: String,
    place: (f64, f64),
}

fn marks(spec: &AxialSpec, top_n: f64) -> Vec<Mark> {
    let ruptures = closed_form::predict_ruptures(spec);
    let marks = ruptures.iter().enumerate().map(|(index, rupture)| {
        let x_mm = rupture.x_m * 1e3;
        // Labels of neighbouring ruptures would overlap on one line: cycle through four heights.
        let height_n = top_n * (0.985 - 0.05 * (index % 4) as f64);
        let layer = &spec.layers[rupture.boundary].name;
        let label = format!("{layer}, {} {x_mm:.3} mm", rupture.contactor.name());
        Mark { line: [(x_mm, 0.0), (x_mm, height_n)], label, place: (x_mm + 0.1, height_n) }
    });
    marks.collect()
}
