//! Line charts in SVG, in one style.

use std::error::Error;
use std::path::Path;

pub use plotters::chart::SeriesLabelPosition;
use plotters::prelude::*;

use crate::exit::{Failure, Outcome};

/// What drawing returns: plotters' errors depend on the backend's type.
pub type Drawn = Result<(), Box<dyn Error>>;

/// The viewer's own sans-serif face.
pub const FONT: &str = "sans-serif";
/// Lines and labels that are not data.
pub const INK: RGBColor = RGBColor(60, 60, 60);
/// Colours that stay apart for colour-blind readers (Okabe and Ito), the yellow left out as too light on white.
const COLOURS: [RGBColor; 7] = [
    RGBColor(0, 114, 178),
    RGBColor(213, 94, 0),
    RGBColor(0, 158, 115),
    RGBColor(204, 121, 167),
    RGBColor(86, 180, 233),
    RGBColor(230, 159, 0),
    RGBColor(0, 0, 0),
];
const SIZE: (u32, u32) = (800, 500);
/// A line of no more points than this shows each of them.
const FEW: usize = 40;

/// One line.
pub struct Curve {
    /// For the legend; an empty name is not listed.
    pub name: String,
    /// Points in order, in the axes' units. Those that are not positive have no place on logarithmic axes.
    pub points: Vec<(f64, f64)>,
}

impl Curve {
    /// The points that logarithmic axes have a place for.
    fn shown(&self) -> impl Iterator<Item = (f64, f64)> + '_ {
        self.points.iter().copied().filter(|&(x, y)| x > 0.0 && y > 0.0)
    }
}

/// A chart with two logarithmic axes: speed and error span powers of ten.
pub struct Chart {
    /// What it shows.
    pub title: String,
    /// Label of the horizontal axis, with its unit.
    pub x: String,
    /// Label of the vertical axis, with its unit.
    pub y: String,
    /// Lines.
    pub curves: Vec<Curve>,
    /// Where nothing is drawn.
    pub legend: SeriesLabelPosition,
    /// Points that stand out: a ring around each.
    pub rings: Vec<Curve>,
}

impl Chart {
    /// Draws it.
    ///
    /// # Errors
    /// When the disk refuses.
    pub fn draw(&self, path: &Path) -> Outcome {
        finish(self.picture(path), path)
    }

    fn picture(&self, path: &Path) -> Drawn {
        let root = SVGBackend::new(path, SIZE).into_drawing_area();
        root.fill(&WHITE)?;
        let (x, y) = (self.range(|point| point.0), self.range(|point| point.1));
        let mut canvas = ChartBuilder::on(&root)
            .caption(&self.title, (FONT, 22))
            .margin(16)
            .margin_right(36)
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
            let line = canvas.draw_series(LineSeries::new(curve.shown(), colour(index).stroke_width(2)))?;
            if !curve.name.is_empty() {
                line.label(&curve.name).legend(key(index));
            }
        }
        for rings in &self.rings {
            let ring = |point| Circle::new(point, 8, INK.stroke_width(2));
            let drawn = canvas.draw_series(rings.shown().map(ring))?;
            drawn.label(&rings.name).legend(|(x, y)| Circle::new((x + 10, y), 6, INK.stroke_width(2)));
        }
        if self.curves.iter().chain(&self.rings).any(|curve| !curve.name.is_empty()) {
            canvas
                .configure_series_labels()
                .position(self.legend.clone())
                .background_style(WHITE.mix(0.85))
                .label_font((FONT, 14))
                .draw()?;
        }
        root.present()?;
        Ok(())
    }

    /// Whole powers of ten that hold every positive value.
    fn range(&self, of: impl Fn(&(f64, f64)) -> f64) -> (f64, f64) {
        let values =
            self.curves.iter().chain(&self.rings).flat_map(|curve| &curve.points).map(of).filter(|value| *value > 0.0);
        let (low, high) = values.fold((f64::INFINITY, 0.0_f64), |(low, high), value| (low.min(value), high.max(value)));
        if high == 0.0 {
            return (1.0, 10.0);
        }
        let power = |exponent: f64| libm::pow(10.0, exponent);
        (power(libm::log10(low).floor()), power(libm::log10(high).ceil()))
    }
}

/// Numbers as people write them, from thousandths to thousands, else in powers of ten.
fn label(value: &f64) -> String {
    if (0.000_999..100_000.5).contains(value) {
        format!("{}", (value * 1e6).round() / 1e6)
    } else {
        format!("{value:.0e}")
    }
}

/// The colour of a line.
pub fn colour(index: usize) -> RGBColor {
    COLOURS[index % COLOURS.len()]
}

/// A line's sign in the legend.
pub fn key(index: usize) -> impl Fn((i32, i32)) -> PathElement<(i32, i32)> {
    move |(x, y)| PathElement::new([(x, y), (x + 20, y)], colour(index).stroke_width(2))
}

/// Says which picture could not be drawn.
///
/// # Errors
/// When it could not.
pub fn finish(drawn: Drawn, path: &Path) -> Outcome {
    drawn.map_err(|error| Failure::work(format_args!("{}: {error}", path.display())))
}
