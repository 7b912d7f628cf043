//! A plot: two axis scales over an area, with grid, ticks and titles.

use super::scale::{AxisScale, Extent, tick_label};
use super::svg::{Area, PaperPoint, Svg};

/// Two axis scales over an area of the drawing.
#[derive(Clone, Copy, Debug)]
pub struct Plot {
    /// Horizontal scale.
    pub x: AxisScale,
    /// Vertical scale; upwards or downwards.
    pub y: AxisScale,
    /// The area between the axes.
    pub area: Area,
}

impl Plot {
    /// Creates a plot whose y axis points up.
    #[must_use]
    pub fn rising(area: Area, x: Extent, y: Extent) -> Self {
        Self {
            x: AxisScale::new(x, Extent::new(area.x, area.right())),
            y: AxisScale::new(y, Extent::new(area.bottom(), area.y)),
            area,
        }
    }

    /// Creates a plot whose y axis points down, as for depth.
    #[must_use]
    pub fn falling(area: Area, x: Extent, y: Extent) -> Self {
        Self {
            x: AxisScale::new(x, Extent::new(area.x, area.right())),
            y: AxisScale::new(y, Extent::new(area.y, area.bottom())),
            area,
        }
    }

    /// Returns the position of a pair of values.
    #[must_use]
    pub fn at(&self, x: f64, y: f64) -> PaperPoint {
        PaperPoint::new(self.x.at(x), self.y.at(y))
    }

    /// Draws grid lines, labels and title of the horizontal axis, below the area.
    pub fn draw_x_axis(&self, svg: &mut Svg, most: usize, title: &str) {
        let ticks = self.x.ticks(most);
        let bottom = self.area.bottom();
        for tick in &ticks {
            let x = self.x.at(*tick);
            svg.line("grid", PaperPoint::new(x, self.area.y), PaperPoint::new(x, bottom));
            svg.text("tick middle", PaperPoint::new(x, bottom + 15.0), &tick_label(*tick, &ticks));
        }
        svg.line("axis", PaperPoint::new(self.area.x, bottom), PaperPoint::new(self.area.right(), bottom));
        svg.text("axis-title end", PaperPoint::new(self.area.right(), bottom + 31.0), title);
    }

    /// Draws grid lines, labels and title of the vertical axis, left of the area.
    pub fn draw_y_axis(&self, svg: &mut Svg, most: usize, title: &str) {
        let ticks = self.y.ticks(most);
        for tick in &ticks {
            let y = self.y.at(*tick);
            svg.line("grid", PaperPoint::new(self.area.x, y), PaperPoint::new(self.area.right(), y));
            svg.text("tick end", PaperPoint::new(self.area.x - 6.0, y + 4.0), &tick_label(*tick, &ticks));
        }
        svg.line("axis", PaperPoint::new(self.area.x, self.area.y), PaperPoint::new(self.area.x, self.area.bottom()));
        svg.text_upwards("axis-title middle", PaperPoint::new(12.0, self.area.y + self.area.height / 2.0), title);
    }

    /// Returns a band of full height between two values of x.
    #[must_use]
    pub fn column(&self, from: f64, to: f64) -> Area {
        let (left, right) = (self.x.at(from), self.x.at(to));
        Area { x: left, y: self.area.y, width: right - left, height: self.area.height }
    }

    /// Returns a band of full width between two values of y.
    #[must_use]
    pub fn row(&self, from: f64, to: f64) -> Area {
        let (top, bottom) = (self.y.at(from), self.y.at(to));
        Area { x: self.area.x, y: top.min(bottom), width: self.area.width, height: (bottom - top).abs() }
    }
}

/// Returns the range of the finite values, extended to include 0; `None` if there are none.
#[must_use]
pub fn extent_with_zero(values: impl Iterator<Item = f64>) -> Option<Extent> {
    values
        .filter(|v| v.is_finite())
        .map(|v| Extent::new(v.min(0.0), v.max(0.0)))
        .reduce(|found, next| Extent::new(found.from.min(next.from), found.to.max(next.to)))
}
