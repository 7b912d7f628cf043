//! Medians with quartiles, and means with confidence intervals, one row per group on a shared axis.

use super::plot::Plot;
use super::scale::Extent;
use super::svg::{Area, Caption, PaperPoint, Svg};
use super::{DrawingSize, labels};
use crate::format;

/// A row of the box chart.
#[derive(Clone, Debug, PartialEq)]
pub struct BoxRow {
    /// Label of the row.
    pub label: String,
    /// Lower quartile, median, upper quartile.
    pub quartiles: Option<(f64, f64, f64)>,
    /// The least and the greatest value.
    pub ends: Option<(f64, f64)>,
    /// Mean and the ends of its interval.
    pub mean: Option<(f64, f64, f64)>,
}

const ROW: f64 = 40.0;
const FOOT: f64 = 38.0;

/// Draws boxes on an axis over `range`. `key` makes the ids unique on the page.
#[must_use]
pub fn draw_boxes(rows: &[BoxRow], range: Extent, key: &str, title: &str, size: DrawingSize) -> String {
    let id = format!("{key}-{}", size.name());
    let description = rows.iter().map(describe_box_row).collect::<Vec<_>>().join(" ");
    let caption = Caption { id: &id, class: size.name(), title, description: &description };
    let height = ROW * rows.len() as f64;
    let area = Area { x: 10.0, y: 0.0, width: size.width() - 24.0, height };
    let plot = Plot::rising(area, range, Extent::new(0.0, 1.0));
    let mut svg = Svg::new(size.width(), height + FOOT, &caption);
    plot.draw_x_axis(&mut svg, size.ticks(), "");
    for (row, top) in rows.iter().zip((0..).map(|row| ROW * f64::from(row))) {
        draw_box_row(&mut svg, &plot, row, top);
    }
    svg.finish()
}

fn draw_box_row(svg: &mut Svg, plot: &Plot, row: &BoxRow, top: f64) {
    svg.text("bar-name", PaperPoint::new(plot.area.x, top + 14.0), &labels::shorten_name(&row.label, plot.area.width));
    let middle = top + 27.0;
    if let Some((least, greatest)) = row.ends {
        let (left, right) = (plot.x.at(least), plot.x.at(greatest));
        svg.line("interval", PaperPoint::new(left, middle), PaperPoint::new(right, middle));
        for end in [left, right] {
            svg.line("interval", PaperPoint::new(end, middle - 5.0), PaperPoint::new(end, middle + 5.0));
        }
    }
    if let Some((lower, median, upper)) = row.quartiles {
        let (left, right) = (plot.x.at(lower), plot.x.at(upper));
        svg.rect("box", Area { x: left, y: middle - 8.0, width: (right - left).max(2.0), height: 16.0 });
        let at = plot.x.at(median);
        svg.line("median", PaperPoint::new(at, middle - 9.0), PaperPoint::new(at, middle + 9.0));
    }
    if let Some((mean, low, high)) = row.mean {
        svg.line("interval", PaperPoint::new(plot.x.at(low), middle), PaperPoint::new(plot.x.at(high), middle));
        svg.circle("mean", PaperPoint::new(plot.x.at(mean), middle), 3.5);
    }
}

fn describe_box_row(row: &BoxRow) -> String {
    match row.quartiles {
        Some((lower, median, upper)) => {
            tr!(
                "{label}: median {median}, quartiles {lower} and {upper}.",
                label = row.label,
                median = format::format_fixed(median, 1),
                lower = format::format_fixed(lower, 1),
                upper = format::format_fixed(upper, 1)
            )
        }
        None => tr!("{label}: no data.", label = row.label),
    }
}
