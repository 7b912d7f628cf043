//! Line charts in SVG, in a uniform style.

use std::error::Error;
use std::fmt::Display;
use std::fs;
use std::path::Path;

pub use plotters::chart::SeriesLabelPosition;
use plotters::coord::Shift;
use plotters::prelude::*;

use crate::error::BenchError;
use crate::machine::{self, Machine};

/// Result of a drawing function; boxed because plotters' errors depend on the backend's type.
pub type Drawn = Result<(), Box<dyn Error>>;

/// The viewer's default sans-serif font.
pub const FONT: &str = "sans-serif";
/// Colour of lines and labels that are not data.
pub const INK: RGBColor = RGBColor(60, 60, 60);
/// Colours that colour-blind readers can distinguish (Okabe and Ito), without yellow, which is too
/// light on white.
const COLOURS: [RGBColor; 8] = [
    RGBColor(0, 114, 178),
    RGBColor(213, 94, 0),
    RGBColor(0, 158, 115),
    RGBColor(204, 121, 167),
    RGBColor(86, 180, 233),
    RGBColor(230, 159, 0),
    RGBColor(0, 0, 0),
    RGBColor(128, 128, 128),
];
const SIZE: (u32, u32) = (960, 500);
/// Width of the legend next to the plot.
const KEY_WIDTH: i32 = 260;
/// Lines with fewer points than this show a marker at each.
const FEW: usize = 40;

/// A line of a chart.
pub struct ChartCurve {
    /// Name in the legend; an empty name is not listed.
    pub name: String,
    /// Points in order, in the axes' units. Points that are not positive are not shown on
    /// logarithmic axes.
    pub points: Vec<(f64, f64)>,
}

impl ChartCurve {
    /// Returns the points that logarithmic axes can show.
    fn shown(&self) -> impl Iterator<Item = (f64, f64)> + Clone + '_ {
        self.points.iter().copied().filter(|&(x, y)| x > 0.0 && y > 0.0)
    }
}

/// A chart with two logarithmic axes, because speed and error span powers of ten.
#[derive(Default)]
pub struct Chart {
    /// Title.
    pub title: String,
    /// Label of the horizontal axis, with its unit.
    pub x: String,
    /// Label of the vertical axis, with its unit.
    pub y: String,
    /// Lines.
    pub curves: Vec<ChartCurve>,
    /// Lines of other solvers: dashed, with square markers.
    pub beside: Vec<ChartCurve>,
    /// Highlighted points, each with a ring.
    pub rings: Vec<ChartCurve>,
}

impl Chart {
    /// Draws the chart.
    ///
    /// # Errors
    /// On an I/O error.
    pub fn draw(&self, path: &Path) -> Result<(), BenchError> {
        finish(self.picture(path), path)
    }

    fn picture(&self, path: &Path) -> Drawn {
        let root = SVGBackend::new(path, SIZE).into_drawing_area();
        root.fill(&WHITE)?;
        let titled = root.titled(&self.title, (FONT, 22))?;
        let (plot, key) = titled.split_horizontally(SIZE.0 as i32 - KEY_WIDTH);
        let (x, y) = (self.range(|point| point.0), self.range(|point| point.1));
        let mut canvas = ChartBuilder::on(&plot)
            .margin(16)
            .x_label_area_size(46)
            .y_label_area_size(76)
            .build_cartesian_2d((x.0..x.1).log_scale(), (y.0..y.1).log_scale())?;
        canvas
            .configure_mesh()
            .light_line_style(TRANSPARENT)
            .bold_line_style(BLACK.mix(0.12))
            .x_desc(&self.x)
            .y_desc(&self.y)
            .x_label_formatter(&label)
            .y_label_formatter(&label)
            .label_style((FONT, 14))
            .axis_desc_style((FONT, 16))
            .draw()?;
        for (index, curve) in self.curves.iter().enumerate() {
            if curve.points.len() <= FEW {
                canvas.draw_series(curve.shown().map(|point| Circle::new(point, 3, colour(index).filled())))?;
            }
            canvas.draw_series(LineSeries::new(curve.shown(), colour(index).stroke_width(2)))?;
        }
        for (index, curve) in self.beside.iter().enumerate() {
            let colour = colour(self.curves.len() + index);
            canvas.draw_series(DashedLineSeries::new(curve.shown(), 6, 4, colour.stroke_width(2)))?;
            let square = |point| EmptyElement::at(point) + Rectangle::new([(-4, -4), (4, 4)], colour.filled());
            canvas.draw_series(curve.shown().map(square))?;
        }
        for rings in &self.rings {
            canvas.draw_series(rings.shown().map(|point| Circle::new(point, 8, INK.stroke_width(2))))?;
        }
        self.list(&key)?;
        root.present()?;
        Ok(())
    }

    /// Draws the legend next to the plot.
    fn list(&self, area: &DrawingArea<SVGBackend<'_>, Shift>) -> Drawn {
        let lines = self.curves.iter().map(|curve| (curve, false)).chain(self.beside.iter().map(|curve| (curve, true)));
        let mut y = 30;
        let say = |name: &str, y: i32| {
            area.draw(&Text::new(name.to_owned(), (44, y - 6), (FONT, 14).into_font().color(&INK)))
        };
        for (index, (curve, dashed)) in lines.enumerate().filter(|(_, (curve, _))| !curve.name.is_empty()) {
            let style = colour(index);
            if dashed {
                area.draw(&PathElement::new([(8, y), (14, y)], style.stroke_width(2)))?;
                area.draw(&PathElement::new([(30, y), (36, y)], style.stroke_width(2)))?;
                area.draw(&Rectangle::new([(18, y - 4), (26, y + 4)], style.filled()))?;
            } else {
                area.draw(&PathElement::new([(8, y), (36, y)], style.stroke_width(2)))?;
                area.draw(&Circle::new((22, y), 3, style.filled()))?;
            }
            say(&curve.name, y)?;
            y += 24;
        }
        for rings in self.rings.iter().filter(|rings| !rings.name.is_empty()) {
            area.draw(&Circle::new((22, y), 7, INK.stroke_width(2)))?;
            say(&rings.name, y)?;
            y += 24;
        }
        Ok(())
    }

    /// Returns the smallest range of whole powers of ten that contains every positive value.
    fn range(&self, of: impl Fn(&(f64, f64)) -> f64) -> (f64, f64) {
        let values = self
            .curves
            .iter()
            .chain(&self.beside)
            .chain(&self.rings)
            .flat_map(|curve| &curve.points)
            .map(of)
            .filter(|value| *value > 0.0);
        let (low, high) = values.fold((f64::INFINITY, 0.0_f64), |(low, high), value| (low.min(value), high.max(value)));
        if high == 0.0 {
            return (1.0, 10.0);
        }
        let power = |exponent: f64| libm::pow(10.0, exponent);
        (power(libm::log10(low).floor()), power(libm::log10(high).ceil()))
    }
}

/// Formats an axis label: plain decimals from thousandths up to 100 000, otherwise a power of ten.
fn label(value: &f64) -> String {
    if (0.000_999..100_000.5).contains(value) {
        format!("{}", (value * 1e6).round() / 1e6)
    } else {
        format!("{value:.0e}")
    }
}

/// Returns the colour of a line.
pub fn colour(index: usize) -> RGBColor {
    COLOURS[index % COLOURS.len()]
}

/// Returns a line's symbol in the legend.
pub fn key(index: usize) -> impl Fn((i32, i32)) -> PathElement<(i32, i32)> {
    move |(x, y)| PathElement::new([(x, y), (x + 20, y)], colour(index).stroke_width(2))
}

/// Adds program and machine to a picture.
///
/// # Errors
/// If the picture could not be drawn or written.
pub fn finish(drawn: Drawn, path: &Path) -> Result<(), BenchError> {
    let cannot = |error: &dyn Display| BenchError::work(format_args!("{}: {error}", path.display()));
    drawn.map_err(|error| cannot(&error))?;
    let svg = fs::read_to_string(path).map_err(|error| cannot(&error))?;
    let who = format!("{}, {}", machine::program(), Machine::this().in_words());
    fs::write(path, signed(&svg, &who)).map_err(|error| cannot(&error))
}

/// Returns a picture with its origin in the lower left corner.
fn signed(svg: &str, who: &str) -> String {
    let who = who.replace('&', "&amp;").replace('<', "&lt;");
    let line = format!(
        "<text x=\"12\" y=\"99%\" font-family=\"sans-serif\" font-size=\"11\" fill=\"#767676\">{who}</text>\n</svg>"
    );
    svg.replacen("</svg>", &line, 1)
}

#[cfg(test)]
mod tests {
    use super::signed;

    #[test]
    fn a_picture_is_signed_once_and_stays_well_formed() {
        let whole = signed("<svg>\n<g/>\n</svg>\n", "a <b> & c");
        assert!(
            whole.ends_with("a &lt;b> &amp; c</text>\n</svg>\n") && whole.matches("</svg>").count() == 1,
            "{whole}"
        );
    }
}
