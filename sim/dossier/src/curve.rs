//! Draws a scene's force against depth as SVG, with the published bands in it.

use std::fmt::Write as _;

use documents::{NeedleFamily, Scene};
use phrase::sentence;

use crate::compare::{Agreement, DossierLine, WAY_M};
use crate::insertion::{ProbeInsertion, ProbeMoment, insert_to, insertion_speed_m_per_s, layers_alone};
use crate::quantity::MeasuredQuantity;

const WIDTH: f64 = 720.0;
const HEIGHT: f64 = 300.0;
/// Left, top, right and bottom of the plot's frame.
const FRAME: [f64; 4] = [52.0, 30.0, 704.0, 250.0];
/// Least and greatest way that is drawn, and the way beyond the last boundary, in m.
const LEAST_M: f64 = 50e-3;
const MOST_M: f64 = 100e-3;
const BEYOND_M: f64 = 10e-3;
/// Number of columns of the curve; each draws the least and the greatest force in it.
const COLUMNS: usize = 600;

/// The published model of the lumbar epidural profile, patient of 71.1 kg: ends of each segment in mm
/// and the coefficients of its polynomial in the way within the segment in mm, in N
/// (EpiduralSimulator.cpp of nitsanti/Epidural-Simulator-Code).
const PROFILE: [(f64, f64, [f64; 4]); 8] = [
    (0.0, 13.92, [0.0235, 0.0116, -0.0046, 0.0025]),
    (13.92, 17.15, [6.0372, 0.4516, -0.5287, 0.0]),
    (17.15, 19.37, [1.9736, 0.8287, 0.1078, 0.0]),
    (19.37, 20.0, [4.354, -2.2543, 0.2902, 0.0]),
    (20.0, 23.18, [4.4062, 0.9598, 0.0, 0.0]),
    (23.18, 41.18, [7.467, 0.0, 0.0, 0.0]),
    (41.18, 44.79, [7.467, 1.5029, -0.0583, 0.0]),
    (44.79, 48.38, [12.133, -0.1693, -0.1177, 0.0]),
];
/// The scene that is fitted to the profile.
const PROFILED: &str = "epidural-71kg";

/// Returns the profile's force at a depth in mm, in N; 0 behind the ligamentum flavum.
#[must_use]
pub fn profile_force_n(depth_mm: f64) -> f64 {
    let segment = PROFILE.iter().find(|(from_mm, to_mm, _)| (*from_mm..*to_mm).contains(&depth_mm));
    segment.map_or(0.0, |(from_mm, _, polynomial)| {
        polynomial.iter().rev().fold(0.0, |force_n, coefficient| force_n * (depth_mm - from_mm) + coefficient)
    })
}

/// The words of a plot, in the reader's language.
#[derive(Clone, Copy)]
pub struct CurveWords<'a> {
    /// Labels of the axes: displacement and force.
    pub axes: [&'a str; 2],
    /// Name of a layer.
    pub name_layer: &'a dyn Fn(&str) -> String,
    /// What was published and the scene's value, for a pointer that rests on a range.
    pub describe: &'a dyn Fn(&DossierLine) -> String,
}

/// The labels of the axes, as sentences.
pub const CURVE_AXES: [&str; 2] = [sentence!("displacement of the tip, mm"), sentence!("axial force, N")];

/// Draws the force of a scene's layers against the tip's displacement: its needle enters
/// perpendicularly. Published ranges of forces are drawn where the scene's value is taken, the
/// published slope as a wedge. `lines` is the scene's comparison.
///
/// # Panics
/// Never for a scene that was read: reading checks the law's requirements.
#[must_use]
#[expect(clippy::expect_used, reason = "reading a scene checks what the law asks")]
pub fn draw_force_curve(scene: &Scene, lines: &[DossierLine], words: &CurveWords<'_>) -> String {
    let params = layers_alone(scene).expect("a scene that was read makes a law");
    let whole_m: f64 = scene.layers.iter().rev().skip(1).map(|layer| layer.thickness_mm / 1e3).sum();
    let least_m = if scene.needle.family == Some(NeedleFamily::RenalAccess) { WAY_M } else { LEAST_M };
    let end_m = (whole_m + BEYOND_M).clamp(least_m, MOST_M).min(params.spec().needle_length_m);
    let way = insert_to(&params, insertion_speed_m_per_s(scene), end_m);
    let most_n = way.moments.iter().map(|moment| moment.force_n).fold(0.0, f64::max);
    let bands: Vec<(f64, [f64; 2], &DossierLine)> = lines
        .iter()
        .filter_map(|line| Some((place_of(line, scene, &way)?, line.figure.range.accepted()?, line)))
        .collect();
    let profiled_n = if scene.id == PROFILED { 12.2 } else { 0.0 };
    let top_n = bands.iter().map(|(_, [_, high], _)| *high).fold(1.08 * most_n.max(profiled_n), f64::max);
    let plot = Plot { end_m, top_n, words };
    let mut svg = format!(
        "<svg class=\"force-curve\" width=\"{WIDTH}\" height=\"{HEIGHT}\" viewBox=\"0 0 {WIDTH} {HEIGHT}\" xmlns=\"http://www.w3.org/2000/svg\" \
         font-family=\"sans-serif\" font-size=\"12\" role=\"img\" aria-label=\"{}\">\n<rect width=\"{WIDTH}\" \
         height=\"{HEIGHT}\" fill=\"#FFFFFF\"/>\n",
        words.axes.join(" – ")
    );
    plot.draw_layers(&mut svg, scene);
    plot.draw_axes(&mut svg);
    if let Some(line) =
        lines.iter().find(|line| line.figure.quantity == MeasuredQuantity::WaySlope && line.value.is_some())
    {
        plot.draw_wedge(&mut svg, line);
    }
    for (place_m, accepted, line) in &bands {
        plot.draw_band(&mut svg, *place_m, *accepted, line);
    }
    if scene.id == PROFILED {
        plot.draw_profile(&mut svg);
    }
    plot.draw_curve(&mut svg, &way.moments);
    svg.push_str("</svg>\n");
    svg
}

/// Returns the displacement at which a line's force is marked, in m; `None` for a figure that is no
/// force of this scene.
fn place_of(line: &DossierLine, scene: &Scene, way: &ProbeInsertion) -> Option<f64> {
    let quantity = line.figure.quantity;
    let is_force = quantity.unit() == "N" && line.value.is_some();
    let layer = quantity.layer().filter(|_| is_force)?;
    let boundary = scene.layers.iter().position(|own| own.name == layer)?;
    let is_through = matches!(quantity, MeasuredQuantity::PeakUntilThrough { .. });
    let at = if is_through { way.through[boundary]? } else { way.opened[boundary]? };
    Some(way.moments[at].x_m)
}

/// The scales and the words of a plot.
struct Plot<'a> {
    end_m: f64,
    top_n: f64,
    words: &'a CurveWords<'a>,
}

impl Plot<'_> {
    fn x(&self, way_m: f64) -> f64 {
        FRAME[0] + (FRAME[2] - FRAME[0]) * way_m / self.end_m
    }

    fn y(&self, force_n: f64) -> f64 {
        FRAME[3] - (FRAME[3] - FRAME[1]) * force_n / self.top_n
    }

    /// Draws the undeformed layers as stripes with their names.
    fn draw_layers(&self, svg: &mut String, scene: &Scene) {
        let mut top_m = 0.0;
        for (at, layer) in scene.layers.iter().enumerate() {
            let end_m = if at + 1 == scene.layers.len() { self.end_m } else { top_m + layer.thickness_mm / 1e3 };
            let name = escape(&(self.words.name_layer)(&layer.name));
            let (from, to) = (self.x(top_m), self.x(end_m.min(self.end_m)));
            let (shade, width, height) = (["#F4F0EA", "#E9E3DA"][at % 2], to - from, FRAME[3] - FRAME[1]);
            if width > 0.0 {
                let _ = writeln!(
                    svg,
                    "<rect x=\"{from:.1}\" y=\"{}\" width=\"{width:.1}\" height=\"{height}\" fill=\"{shade}\"><title>{name}</title></rect>",
                    FRAME[1]
                );
                if width > 7.0 * name.chars().count() as f64 {
                    let _ = writeln!(
                        svg,
                        "<text x=\"{:.1}\" y=\"{}\" text-anchor=\"middle\" fill=\"#6B6257\" font-size=\"11\">{name}</text>",
                        0.5 * (from + to),
                        FRAME[1] - 6.0
                    );
                }
            }
            top_m = end_m;
        }
    }

    fn draw_axes(&self, svg: &mut String) {
        let [left, _, right, bottom] = FRAME;
        let step_mm = if self.end_m > 60e-3 { 20 } else { 10 };
        for mm in (0..).step_by(step_mm).take_while(|mm| f64::from(*mm) / 1e3 <= self.end_m) {
            let x = self.x(f64::from(mm) / 1e3);
            let _ = writeln!(svg, "<text x=\"{x:.1}\" y=\"{}\" text-anchor=\"middle\">{mm}</text>", bottom + 16.0);
        }
        let step_n = [0.5, 1.0, 2.0, 5.0, 10.0, 20.0].into_iter().find(|step| self.top_n / step <= 6.0).unwrap_or(50.0);
        for at in (0..).map(|at| f64::from(at) * step_n).take_while(|at| *at <= self.top_n) {
            let y = self.y(at);
            let _ = writeln!(svg, "<path d=\"M{left} {y:.1}H{right}\" stroke=\"#000000\" stroke-opacity=\"0.12\"/>");
            let _ = writeln!(svg, "<text x=\"{}\" y=\"{:.1}\" text-anchor=\"end\">{at}</text>", left - 6.0, y + 4.0);
        }
        let middle = 0.5 * (left + right);
        let _ = writeln!(
            svg,
            "<text x=\"{middle}\" y=\"{}\" text-anchor=\"middle\">{}</text>",
            bottom + 36.0,
            escape(self.words.axes[0])
        );
        let _ = writeln!(
            svg,
            "<text x=\"14\" y=\"{0}\" text-anchor=\"middle\" transform=\"rotate(-90 14 {0})\">{1}</text>",
            0.5 * (FRAME[1] + bottom),
            escape(self.words.axes[1])
        );
    }

    /// Draws the published slopes as a wedge from contact.
    fn draw_wedge(&self, svg: &mut String, line: &DossierLine) {
        let Some([low, high]) = line.figure.range.accepted() else { return };
        let end = |slope: f64| {
            let way_m = self.end_m.min(self.top_n / slope);
            (self.x(way_m), self.y(slope * way_m))
        };
        let ((low_x, low_y), (high_x, high_y)) = (end(low), end(high));
        let (origin_x, origin_y, right) = (self.x(0.0), self.y(0.0), FRAME[2].min(low_x.max(high_x)));
        let _ = writeln!(
            svg,
            "<path d=\"M{origin_x:.1} {origin_y:.1}L{high_x:.1} {high_y:.1}L{right:.1} {high_y:.1}L{low_x:.1} {low_y:.1}Z\" fill=\"#0072B2\" \
             fill-opacity=\"0.13\"><title>{}</title></path>",
            escape(&(self.words.describe)(line))
        );
    }

    /// Draws an accepted range of forces as a bar at the displacement of the scene's value.
    fn draw_band(&self, svg: &mut String, place_m: f64, [low, high]: [f64; 2], line: &DossierLine) {
        let (x, top, bottom) = (self.x(place_m), self.y(high.min(self.top_n)), self.y(low.max(0.0)));
        let colour = if line.agreement == Agreement::Outside { "#D55E00" } else { "#009E73" };
        let _ = writeln!(
            svg,
            "<rect x=\"{:.1}\" y=\"{top:.1}\" width=\"12\" height=\"{:.1}\" fill=\"{colour}\" fill-opacity=\"0.35\" stroke=\"{colour}\">\
             <title>{}</title></rect>",
            x - 6.0,
            bottom - top,
            escape(&(self.words.describe)(line))
        );
    }

    /// Draws the published profile dashed.
    fn draw_profile(&self, svg: &mut String) {
        let points: String = (0..=570)
            .map(|at| f64::from(at) * 0.1)
            .take_while(|mm| mm / 1e3 <= self.end_m)
            .map(|mm| format!("{:.1},{:.1} ", self.x(mm / 1e3), self.y(profile_force_n(mm))))
            .collect();
        let _ = writeln!(
            svg,
            "<polyline points=\"{}\" fill=\"none\" stroke=\"#D55E00\" stroke-width=\"1.5\" stroke-dasharray=\"5 4\"/>",
            points.trim_end()
        );
    }

    /// Draws the scene's own force: in each column its least and its greatest value.
    fn draw_curve(&self, svg: &mut String, moments: &[ProbeMoment]) {
        let size = moments.len().div_ceil(COLUMNS).max(1);
        let mut points = String::new();
        for column in moments.chunks(size) {
            let place = |at: usize| (self.x(column[at].x_m), self.y(column[at].force_n));
            let extreme = |sign: f64| {
                (0..column.len()).max_by(|a, b| (sign * column[*a].force_n).total_cmp(&(sign * column[*b].force_n)))
            };
            let mut two: Vec<usize> = [extreme(-1.0), extreme(1.0)].into_iter().flatten().collect();
            two.sort_unstable();
            two.dedup();
            for at in two {
                let (x, y) = place(at);
                let _ = write!(points, "{x:.1},{y:.1} ");
            }
        }
        let _ = writeln!(
            svg,
            "<polyline points=\"{}\" fill=\"none\" stroke=\"#1F4E79\" stroke-width=\"1.6\"/>",
            points.trim_end()
        );
    }
}

/// Escapes a text for an element of SVG.
fn escape(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('"', "&quot;")
}
