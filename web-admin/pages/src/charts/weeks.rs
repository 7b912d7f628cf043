//! Shares over the weeks of a term, a line for each cohort.

use super::DrawingSize;
use super::plot::Plot;
use super::scale::Extent;
use super::svg::{Area, Caption, Svg};
use crate::format;

/// The line of a cohort.
#[derive(Clone, Debug, PartialEq)]
pub struct ShareLine {
    /// The cohort.
    pub label: String,
    /// Its share at the end of each week, 0–1.
    pub shares: Vec<f64>,
}

const HEIGHT: f64 = 250.0;

/// Draws shares over weeks; the first line is solid, the second dashed.
#[must_use]
pub fn draw_shares(lines: &[ShareLine], key: &str, title: &str, size: DrawingSize) -> String {
    let id = format!("{key}-{}", size.name());
    let description = lines.iter().filter_map(describe_line).collect::<Vec<_>>().join(" ");
    let caption = Caption { id: &id, class: size.name(), title, description: &description };
    let weeks = lines.iter().map(|line| line.shares.len()).max().unwrap_or(0).max(1);
    let area = Area { x: 52.0, y: 10.0, width: size.width() - 66.0, height: HEIGHT - 20.0 };
    let plot = Plot::rising(area, Extent::new(0.0, weeks as f64), Extent::new(0.0, 100.0));
    let mut svg = Svg::new(size.width(), HEIGHT + 34.0, &caption);
    plot.draw_x_axis(&mut svg, (weeks + 1).min(size.ticks()), tr!("week of the term"));
    plot.draw_y_axis(&mut svg, 6, tr!("mastered, %"));
    for (index, line) in lines.iter().enumerate().filter(|(_, line)| !line.shares.is_empty()) {
        let ends = (1_u32..).zip(&line.shares).map(|(week, share)| plot.at(f64::from(week), share * 100.0));
        let points: Vec<_> = std::iter::once(plot.at(0.0, 0.0)).chain(ends).collect();
        svg.polyline(&format!("series s{index}"), &points);
    }
    svg.finish()
}

fn describe_line(line: &ShareLine) -> Option<String> {
    let last = line.shares.last()?;
    Some(tr!(
        "{cohort}: {share} mastered after {weeks} weeks.",
        cohort = line.label,
        share = format::format_percent(*last),
        weeks = line.shares.len()
    ))
}
