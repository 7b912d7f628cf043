//! Means with their intervals over attempts, a line for each group.

use assessment::statistics::Estimate;

use super::DrawingSize;
use super::plot::Plot;
use super::scale::Extent;
use super::svg::{Area, Caption, PaperPoint, Svg};
use crate::format;

/// The line of a group.
#[derive(Clone, Debug, PartialEq)]
pub struct MeansLine {
    /// The group.
    pub label: String,
    /// Its mean at each attempt, from the first, where there is one.
    pub means: Vec<Option<Estimate>>,
}

const HEIGHT: f64 = 250.0;
/// Looks of lines; more groups take them in turn.
const LOOKS: usize = 4;
/// How far the lines of two groups stand apart, so that their intervals do not cover each other.
const APART: f64 = 5.0;

/// Lines of scores, 0–100, over attempts. `key` makes the ids unique on the page.
#[must_use]
pub fn draw_means(lines: &[MeansLine], key: &str, title: &str, size: DrawingSize) -> String {
    let id = format!("{key}-{}", size.name());
    let description = lines.iter().map(describe_line).collect::<Vec<_>>().join(" ");
    let caption = Caption { id: &id, class: size.name(), title, description: &description };
    let attempts = lines.iter().map(|line| line.means.len()).max().unwrap_or(0);
    let area = Area { x: 46.0, y: 10.0, width: size.width() - 60.0, height: HEIGHT - 20.0 };
    let plot = Plot::rising(area, Extent::new(0.5, attempts as f64 + 0.5), Extent::new(0.0, 100.0));
    let mut svg = Svg::new(size.width(), HEIGHT + 34.0, &caption);
    plot.draw_x_axis(&mut svg, (attempts + 1).min(size.ticks()), tr!("attempt"));
    plot.draw_y_axis(&mut svg, 6, tr!("score"));
    for (index, line) in lines.iter().enumerate() {
        let shift = APART * (index as f64 - (lines.len() as f64 - 1.0) / 2.0);
        draw_line(&mut svg, &plot, line, LineLook { index: index % LOOKS, shift });
    }
    svg.finish()
}

/// How a line looks, and how far it is moved aside.
#[derive(Clone, Copy)]
struct LineLook {
    index: usize,
    shift: f64,
}

fn draw_line(svg: &mut Svg, plot: &Plot, line: &MeansLine, LineLook { index, shift }: LineLook) {
    let place = |attempt: f64, value: f64| {
        let at = plot.at(attempt, value);
        PaperPoint::new(at.x + shift, at.y)
    };
    let known = (1_u32..).zip(&line.means).filter_map(|(n, mean)| Some((f64::from(n), mean.as_ref()?)));
    let known: Vec<(f64, &Estimate)> = known.collect();
    let class = format!("series s{index}");
    for (attempt, mean) in &known {
        svg.line(&format!("interval s{index}"), place(*attempt, mean.low), place(*attempt, mean.high));
        svg.circle(&format!("dot s{index}"), place(*attempt, mean.value), 3.5);
    }
    svg.polyline(&class, &known.iter().map(|(attempt, mean)| place(*attempt, mean.value)).collect::<Vec<_>>());
}

fn describe_line(line: &MeansLine) -> String {
    let means = line.means.iter().map(|mean| match mean {
        Some(mean) => format::format_fixed(mean.value, 0),
        None => "–".to_owned(),
    });
    tr!("{group}: {means}.", group = line.label, means = means.collect::<Vec<_>>().join(", "))
}
