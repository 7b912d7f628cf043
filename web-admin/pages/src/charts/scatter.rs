//! Scatter plots of two figures of each response.

use super::DrawingSize;
use super::plot::Plot;
use super::scale::Extent;
use super::svg::{Area, Caption, Svg};

/// Draws points with the titles of both axes. `key` makes the ids unique on the page.
#[must_use]
pub fn draw_scatter(points: &[(f64, f64)], x_title: &str, y_title: &str, key: &str, size: DrawingSize) -> String {
    let id = format!("{key}-{}", size.name());
    let title = tr!("{score} against {figure}", score = y_title, figure = x_title);
    let description = trn!("{n} point.", "{n} points.", points.len());
    let caption = Caption { id: &id, class: size.name(), title: &title, description: &description };
    let height = 300.0;
    let area = Area { x: 52.0, y: 10.0, width: size.width() - 66.0, height: height - 52.0 };
    let plot = Plot::rising(
        area,
        extent_with_margin(points.iter().map(|p| p.0)),
        extent_with_margin(points.iter().map(|p| p.1)),
    );
    let mut svg = Svg::new(size.width(), height, &caption);
    plot.draw_x_axis(&mut svg, size.ticks(), x_title);
    plot.draw_y_axis(&mut svg, 6, y_title);
    for (x, y) in points {
        svg.circle("dot", plot.at(*x, *y), 4.0);
    }
    svg.finish()
}

/// Returns the range of some values with a margin, so that no point lies on an axis.
fn extent_with_margin(values: impl Iterator<Item = f64>) -> Extent {
    let found = Extent::around(values);
    let margin = (found.length() * 0.06).max(1e-6);
    Extent::new(found.from - margin, found.to + margin)
}
