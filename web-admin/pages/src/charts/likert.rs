//! Likert answers as diverging bars: low answers extend to the left of the middle, high answers to
//! the right.

use super::svg::{Area, Caption, PaperPoint, Svg};
use super::{DrawingSize, labels};
use crate::format;

/// A bar: counts of the answers at each point.
#[derive(Clone, Debug, PartialEq)]
pub struct LikertBar {
    /// Label of the bar.
    pub label: String,
    /// Number of answers at each point, from low to high.
    pub counts: Vec<usize>,
}

/// An item: its text, and one bar for each group of respondents.
#[derive(Clone, Debug, PartialEq)]
pub struct LikertItem {
    /// Full text of the question.
    pub text: String,
    /// One bar per group.
    pub bars: Vec<LikertBar>,
}

const LINE: f64 = 16.0;
const BAR: f64 = 18.0;
const BAR_ROW: f64 = LINE + BAR + 6.0;
const GAP: f64 = 12.0;
const TOP: f64 = 4.0;
const AXIS: f64 = 22.0;

/// Scale shared by all bars of a drawing.
struct BarScale {
    /// x coordinate of the middle of the scale.
    middle: f64,
    /// Width per unit of share.
    scale: f64,
    /// Largest share on one side.
    reach: f64,
}

/// Draws diverging bars, one item below the other, over one axis of shares. `key` makes the ids
/// unique on the page.
#[must_use]
pub fn draw_diverging_bars(items: &[LikertItem], key: &str, title: &str, size: DrawingSize) -> String {
    let id = format!("{key}-{}", size.name());
    let description = items.iter().map(describe_item).collect::<Vec<_>>().join(" ");
    let caption = Caption { id: &id, class: size.name(), title, description: &description };
    let lines: Vec<Vec<&str>> = items.iter().map(|item| labels::wrap_lines(&item.text, size.width() - 8.0)).collect();
    let height_of =
        |item: &LikertItem, lines: &[&str]| LINE * lines.len() as f64 + BAR_ROW * item.bars.len() as f64 + GAP;
    let rows: f64 = items.iter().zip(&lines).map(|(item, lines)| height_of(item, lines)).sum();
    let mut svg = Svg::new(size.width(), TOP + rows + AXIS, &caption);
    let scale = BarScale::new(items, size.width());
    draw_share_axis(&mut svg, &scale, TOP + rows);
    let mut top = TOP;
    for (item, lines) in items.iter().zip(&lines) {
        for (line, text) in (1..).zip(lines) {
            svg.text("item-name", PaperPoint::new(4.0, top + LINE * f64::from(line) - 3.0), text);
        }
        let first = top + LINE * lines.len() as f64;
        for (bar, row) in item.bars.iter().zip(0..) {
            draw_diverging_bar(&mut svg, bar, first + BAR_ROW * f64::from(row), &scale);
        }
        top += height_of(item, lines);
    }
    svg.finish()
}

impl BarScale {
    fn new(items: &[LikertItem], width: f64) -> Self {
        let sides = items.iter().flat_map(|item| &item.bars).map(shares_of_sides);
        // The axis shows at least a quarter on each side.
        let reach = sides.map(|(low, high)| low.max(high)).fold(0.25, f64::max);
        let middle = width / 2.0;
        Self { middle, scale: (middle - 20.0) / reach, reach }
    }
}

/// Draws the axis of shares on both sides of the middle, with a tick at every quarter that the bars
/// reach.
fn draw_share_axis(svg: &mut Svg, scale: &BarScale, bottom: f64) {
    let ticks = (1..=4).map(|quarter| f64::from(quarter) / 4.0).take_while(|share| *share <= scale.reach + 1e-9);
    let places = ticks.flat_map(|share| [(share, -share * scale.scale), (share, share * scale.scale)]);
    for (share, off) in places {
        let x = scale.middle + off;
        svg.line("grid", PaperPoint::new(x, 0.0), PaperPoint::new(x, bottom));
        svg.text("tick middle", PaperPoint::new(x, bottom + 15.0), &format::format_percent(share));
    }
    svg.line("axis", PaperPoint::new(scale.middle, 0.0), PaperPoint::new(scale.middle, bottom));
    svg.text("tick middle", PaperPoint::new(scale.middle, bottom + 15.0), &format::format_percent(0.0));
}

/// Returns the shares left and right of the middle; answers at the middle point count half on each
/// side.
fn shares_of_sides(bar: &LikertBar) -> (f64, f64) {
    let total = bar.counts.iter().sum::<usize>().max(1) as f64;
    let half = bar.counts.len() / 2;
    let centre = if bar.counts.len() % 2 == 1 { bar.counts[half] as f64 / 2.0 } else { 0.0 };
    let low: usize = bar.counts[..half].iter().sum();
    let high: usize = bar.counts[bar.counts.len() - half..].iter().sum();
    ((low as f64 + centre) / total, (high as f64 + centre) / total)
}

fn draw_diverging_bar(svg: &mut Svg, bar: &LikertBar, top: f64, scale: &BarScale) {
    let total = bar.counts.iter().sum::<usize>();
    let under = top + LINE - 1.0;
    svg.text("bar-name", PaperPoint::new(4.0, top + LINE - 5.0), &bar.label);
    let mut left = scale.middle - shares_of_sides(bar).0 * scale.scale;
    for (point, count) in bar.counts.iter().enumerate().filter(|(_, count)| **count > 0) {
        let width = *count as f64 / total as f64 * scale.scale;
        let area = Area { x: left, y: under, width, height: BAR };
        svg.rect(&format!("level {}", class_of_point(point, bar.counts.len())), area);
        // The number is the second cue next to colour: order shows which point it is, the number
        // how many chose it.
        if width > 16.0 {
            let place = PaperPoint::new(left + width / 2.0, under + BAR - 5.0);
            svg.text("level-count middle", place, &count.to_string());
        }
        left += width;
    }
}

/// Returns the CSS class of a point, by its distance from the middle and its side.
#[must_use]
pub fn class_of_point(point: usize, points: usize) -> &'static str {
    let share = point as f64 / (points.max(2) - 1) as f64;
    match share {
        ..0.2 => "low2",
        ..0.45 => "low1",
        ..0.55 => "mid",
        ..0.8 => "high1",
        _ => "high2",
    }
}

fn describe_item(item: &LikertItem) -> String {
    let bars: Vec<String> = item.bars.iter().map(describe_bar).collect();
    format!("{} {}", item.text, bars.join(" "))
}

fn describe_bar(bar: &LikertBar) -> String {
    let counts: Vec<String> = bar.counts.iter().map(ToString::to_string).collect();
    tr!("{label}: {counts} from low to high.", label = bar.label, counts = counts.join(", "))
}

#[cfg(test)]
mod tests {
    //! Bars must extend to the correct side, and texts must never become markup.

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
        let bars = vec![LikertBar { label: "<b>".to_owned(), counts: vec![0; 5] }];
        let bars = [LikertItem { text: "<i>".to_owned(), bars }];
        let drawn = draw_diverging_bars(&bars, "x", "t", DrawingSize::Wide);
        assert!(
            !drawn.contains("<rect") && !drawn.contains("NaN") && !drawn.contains("<b>") && !drawn.contains("<i>"),
            "{drawn}"
        );
    }
}
