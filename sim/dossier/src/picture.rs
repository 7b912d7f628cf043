//! Draws the dossier as SVG: a row for each figure, with the published range as a bar and a point
//! for each scene.

use std::fmt::Write as _;

use crate::compare::SceneDossier;
use crate::figures::{FIGURES, PublishedFigure, PublishedRange};
use crate::words::say_range;

/// Colours that colour-blind readers can distinguish (Okabe and Ito), without yellow, which is too
/// light on white.
const COLOURS: [&str; 8] = ["#0072B2", "#D55E00", "#009E73", "#CC79A7", "#56B4E9", "#E69F00", "#000000", "#808080"];
const INK: &str = "#3C3C3C";
const WIDTH: f64 = 960.0;
const HEIGHT_OF_ROW: f64 = 44.0;
/// Height of the title above the rows.
const TITLE: f64 = 44.0;
/// Height of the axis below the rows.
const AXIS: f64 = 46.0;
/// Height of a line of the legend, and the number of scenes on it.
const LEGEND_LINE: f64 = 26.0;
const SCENES_PER_LINE: usize = 4;
/// Left and right end of the axis.
const PLOT: (f64, f64) = (396.0, 944.0);
/// Smallest and largest ratio on the axis.
const SHOWN: (f64, f64) = (0.05, 20.0);
/// Ratios with a line and a label.
const MARKED: [f64; 3] = [0.1, 1.0, 10.0];

/// Returns the middle of the accepted range, and its ends divided by the middle. `None` if no values
/// are published.
fn bar_of(figure: &PublishedFigure) -> Option<(f64, f64, f64)> {
    match (figure.range.accepted(), figure.range) {
        (Some([low, high]), PublishedRange::Above(value) | PublishedRange::Distinguishable(value)) => {
            Some((value, low / value, high.min(SHOWN.1)))
        }
        (Some([low, high]), _) => {
            let middle = f64::midpoint(low, high);
            Some((middle, low / middle, high / middle))
        }
        (None, PublishedRange::Single(value)) => Some((value, 1.0, 1.0)),
        (None, _) => None,
    }
}

/// Draws the figures for which at least one scene has a value; every value is divided by the middle
/// of its accepted range.
#[must_use]
pub fn draw_dossier(dossiers: &[SceneDossier]) -> String {
    let compared = |place: &usize| dossiers.iter().any(|dossier| dossier.lines[*place].value.is_some());
    let shown: Vec<usize> = (0..FIGURES.len()).filter(compared).collect();
    let bottom = TITLE + HEIGHT_OF_ROW * shown.len() as f64;
    let height = bottom + AXIS + LEGEND_LINE * dossiers.len().div_ceil(SCENES_PER_LINE) as f64;
    let mut svg = format!(
        "<svg width=\"{WIDTH}\" height=\"{height}\" viewBox=\"0 0 {WIDTH} {height}\" xmlns=\"http://www.w3.org/2000/svg\" \
         font-family=\"sans-serif\" font-size=\"13\">\n<rect width=\"{WIDTH}\" height=\"{height}\" fill=\"#FFFFFF\"/>\n\
         <text x=\"{}\" y=\"24\" text-anchor=\"middle\" font-size=\"18\">What scenes give, over what is published</text>\n",
        0.5 * WIDTH
    );
    draw_axis(&mut svg, bottom);
    for (row, place) in shown.iter().enumerate() {
        draw_row(&mut svg, dossiers, *place, TITLE + HEIGHT_OF_ROW * (row as f64 + 0.5));
    }
    for (index, dossier) in dossiers.iter().enumerate() {
        let x = 20.0 + 235.0 * (index % SCENES_PER_LINE) as f64;
        let y = bottom + AXIS + LEGEND_LINE * (index / SCENES_PER_LINE) as f64;
        draw_point(&mut svg, index, x, y);
        draw_label(&mut svg, &dossier.scene, x + 10.0, y + 4.0);
    }
    svg.push_str("</svg>\n");
    svg
}

fn draw_axis(svg: &mut String, bottom: f64) {
    let (left, right) = PLOT;
    // Writing to a string cannot fail, here and below.
    let _ = writeln!(svg, "<path d=\"M{left} {bottom}H{right}\" stroke=\"#000000\"/>");
    for ratio in MARKED {
        let (x, label) = (place_of_ratio(ratio), bottom + 18.0);
        let _ = writeln!(svg, "<path d=\"M{x:.1} {TITLE}V{bottom}\" stroke=\"#000000\" stroke-opacity=\"0.12\"/>");
        let _ = writeln!(svg, "<text x=\"{x:.1}\" y=\"{label}\" text-anchor=\"middle\">× {ratio}</text>");
    }
}

/// Draws a figure: its label, its published range, and the point of each scene that has a value.
fn draw_row(svg: &mut String, dossiers: &[SceneDossier], place: usize, y: f64) {
    let figure = &FIGURES[place];
    let Some((middle, low, high)) = bar_of(figure) else { return };
    let (left, right, half) = (place_of_ratio(low) - 2.0, place_of_ratio(high) + 2.0, 0.28 * HEIGHT_OF_ROW);
    let (width, top, height) = (right - left, y - half, 2.0 * half);
    let _ = writeln!(
        svg,
        "<rect x=\"{left:.1}\" y=\"{top:.1}\" width=\"{width:.1}\" height=\"{height:.1}\" fill-opacity=\"0.22\"/>"
    );
    for (index, dossier) in dossiers.iter().enumerate() {
        let Some(value) = dossier.lines[place].value else { continue };
        let apart = (index as f64 - (dossiers.len() as f64 - 1.0) / 2.0) * 0.5 / dossiers.len() as f64;
        draw_point(svg, index, place_of_ratio(value / middle), y + HEIGHT_OF_ROW * apart);
    }
    draw_label(svg, figure.title, 16.0, y - 4.0);
    draw_label(svg, &say_range(figure), 16.0, y + 13.0);
}

/// Returns the position of a ratio on the logarithmic axis, clamped to its ends.
fn place_of_ratio(ratio: f64) -> f64 {
    let part = libm::log(ratio.clamp(SHOWN.0, SHOWN.1) / SHOWN.0) / libm::log(SHOWN.1 / SHOWN.0);
    PLOT.0 + part * (PLOT.1 - PLOT.0)
}

fn draw_point(svg: &mut String, index: usize, x: f64, y: f64) {
    let colour = COLOURS[index % COLOURS.len()];
    let _ = writeln!(svg, "<circle cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"4\" fill=\"{colour}\"/>");
}

fn draw_label(svg: &mut String, text: &str, x: f64, y: f64) {
    let text = text.replace('&', "&amp;").replace('<', "&lt;");
    let _ = writeln!(svg, "<text x=\"{x}\" y=\"{y}\" fill=\"{INK}\">{text}</text>");
}
