//! Answers on a row of points as diverging bars: what leans low goes left of the middle, what leans high right.

use super::svg::{Area, Caption, PaperPoint, Svg};
use super::{DrawingSize, labels};

/// A bar: how often each point was chosen.
#[derive(Clone, Debug, PartialEq)]
pub struct LikertBar {
    /// What it is of.
    pub label: String,
    /// Answers at each point, from low to high.
    pub counts: Vec<usize>,
}

const ROW: f64 = 46.0;
const BAR: f64 = 18.0;
const TOP: f64 = 8.0;

/// Diverging bars, a row each. `key` makes the ids unique on the page.
#[must_use]
pub fn draw_diverging_bars(bars: &[LikertBar], key: &str, title: &str, size: DrawingSize) -> String {
    let id = format!("{key}-{}", size.name());
    let description = bars.iter().map(describe_bar).collect::<Vec<_>>().join(" ");
    let caption = Caption { id: &id, class: size.name(), title, description: &description };
    let height = TOP + ROW * bars.len() as f64;
    let mut svg = Svg::new(size.width(), height, &caption);
    let middle = size.width() / 2.0;
    let reach = bars.iter().map(|bar| shares_of_sides(bar).0.max(shares_of_sides(bar).1)).fold(0.25, f64::max);
    let scale = (middle - 6.0) / reach;
    for (bar, top) in bars.iter().zip((0..).map(|row| TOP + ROW * f64::from(row))) {
        draw_diverging_bar(&mut svg, bar, middle, top, scale);
    }
    svg.line("axis", PaperPoint::new(middle, 0.0), PaperPoint::new(middle, height));
    svg.finish()
}

/// Shares left and right of the middle; the middle point lies on both sides.
fn shares_of_sides(bar: &LikertBar) -> (f64, f64) {
    let total = bar.counts.iter().sum::<usize>().max(1) as f64;
    let half = bar.counts.len() / 2;
    let centre = if bar.counts.len() % 2 == 1 { bar.counts[half] as f64 / 2.0 } else { 0.0 };
    let low: usize = bar.counts[..half].iter().sum();
    let high: usize = bar.counts[bar.counts.len() - half..].iter().sum();
    ((low as f64 + centre) / total, (high as f64 + centre) / total)
}

fn draw_diverging_bar(svg: &mut Svg, bar: &LikertBar, middle: f64, top: f64, scale: f64) {
    let total = bar.counts.iter().sum::<usize>();
    svg.text("bar-name", PaperPoint::new(4.0, top + 13.0), &labels::shorten_name(&bar.label, middle * 2.0 - 8.0));
    let mut left = middle - shares_of_sides(bar).0 * scale;
    for (point, count) in bar.counts.iter().enumerate().filter(|(_, count)| **count > 0) {
        let width = *count as f64 / total as f64 * scale;
        let area = Area { x: left, y: top + 19.0, width, height: BAR };
        svg.rect(&format!("level {}", class_of_point(point, bar.counts.len())), area);
        // The number is the second cue: which point it is tells the order, how many the figure.
        if width > 16.0 {
            svg.text(
                "level-count middle",
                PaperPoint::new(left + width / 2.0, top + 19.0 + BAR - 5.0),
                &count.to_string(),
            );
        }
        left += width;
    }
}

/// The class of a point: how far it lies from the middle, and on which side.
fn class_of_point(point: usize, points: usize) -> &'static str {
    let share = point as f64 / (points.max(2) - 1) as f64;
    match share {
        ..0.2 => "low2",
        ..0.45 => "low1",
        ..0.55 => "mid",
        ..0.8 => "high1",
        _ => "high2",
    }
}

fn describe_bar(bar: &LikertBar) -> String {
    let counts: Vec<String> = bar.counts.iter().map(ToString::to_string).collect();
    tr!("{label}: {counts} from low to high.", label = bar.label, counts = counts.join(", "))
}

#[cfg(test)]
mod tests {
    //! Fails when a bar leans to the wrong side, or a name becomes markup.

    use super::*;

    #[test]
    fn what_leans_low_goes_left() {
        let low = shares_of_sides(&LikertBar { label: String::new(), counts: vec![6, 2, 2, 0, 0] });
        assert!((low.0 - 0.9).abs() < 1e-12 && (low.1 - 0.1).abs() < 1e-12, "{low:?}");
        let even = shares_of_sides(&LikertBar { label: String::new(), counts: vec![1, 1, 1, 1] });
        assert!((even.0 - even.1).abs() < 1e-12);
    }

    #[test]
    fn a_bar_without_answers_draws_nothing_and_no_nonsense() {
        let bars = [LikertBar { label: "<b>".to_owned(), counts: vec![0; 5] }];
        let drawn = draw_diverging_bars(&bars, "x", "t", DrawingSize::Wide);
        assert!(!drawn.contains("<rect") && !drawn.contains("NaN") && !drawn.contains("<b>"), "{drawn}");
    }
}
