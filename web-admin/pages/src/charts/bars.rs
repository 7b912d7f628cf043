//! Attempts per day as bars, and small drawings of a value within a distribution.

use time::Date;

use super::scale::{AxisScale, Extent};
use super::svg::{Area, Caption, PaperPoint, Svg};
use super::{DrawingSize, draw_both_widths};
use crate::format;

const HEIGHT: f64 = 150.0;

/// Draws passed and failed attempts per day, including days without attempts.
#[must_use]
pub fn draw_attempts_by_day(days: &[(Date, usize, usize)]) -> String {
    draw_both_widths(|size| draw_bars_of_days(days, size))
}

fn draw_bars_of_days(days: &[(Date, usize, usize)], size: DrawingSize) -> String {
    let id = format!("days-{}", size.name());
    let total: usize = days.iter().map(|(_, passed, failed)| passed + failed).sum();
    let most = days.iter().map(|(_, passed, failed)| passed + failed).max().unwrap_or(0);
    let description = trn!(
        "{n} attempt in {days} days, at most {most} on one day.",
        "{n} attempts in {days} days, at most {most} on one day.",
        total,
        days = days.len(),
        most = most
    );
    let caption = Caption { id: &id, class: size.name(), title: tr!("Attempts by day"), description: &description };
    let mut svg = Svg::new(size.width(), HEIGHT, &caption);
    let area = Area { x: 34.0, y: 8.0, width: size.width() - 44.0, height: HEIGHT - 36.0 };
    let y = AxisScale::new(Extent::new(0.0, most.max(1) as f64), Extent::new(area.bottom(), area.y));
    let x = AxisScale::new(Extent::new(0.0, days.len().max(1) as f64), Extent::new(area.x, area.right()));
    for (count, label) in [(0, "0".to_owned()), (most, most.to_string())] {
        svg.line(
            "grid",
            PaperPoint::new(area.x, y.at(count as f64)),
            PaperPoint::new(area.right(), y.at(count as f64)),
        );
        svg.text("tick end", PaperPoint::new(area.x - 6.0, y.at(count as f64) + 4.0), &label);
    }
    for (i, (_, passed, failed)) in days.iter().enumerate() {
        let (left, right) = (x.at(i as f64), x.at((i + 1) as f64));
        let width = (right - left - 1.0).max(0.5);
        let (top, middle) = (y.at((passed + failed) as f64), y.at(*passed as f64));
        svg.rect("bar passed", Area { x: left, y: middle, width, height: area.bottom() - middle });
        svg.rect("bar failed", Area { x: left, y: top, width, height: middle - top });
    }
    for (day, place, anchor) in [(days.first(), area.x, ""), (days.last(), area.right(), " end")] {
        if let Some((date, ..)) = day {
            svg.text(
                &format!("tick{anchor}"),
                PaperPoint::new(place, area.bottom() + 16.0),
                &format::format_short_date(*date),
            );
        }
    }
    svg.finish()
}

/// Draws minimum, quartiles and maximum as a small box on a shared scale. The numbers are shown
/// next to it as text.
#[must_use]
pub fn draw_spread(five: &assessment::statistics::Summary, domain: Extent) -> String {
    let mut svg = Svg::ornament(150.0, 16.0, "spread");
    let x = AxisScale::new(domain, Extent::new(3.0, 147.0));
    svg.line("axis", PaperPoint::new(x.at(five.min), 8.0), PaperPoint::new(x.at(five.max), 8.0));
    let (left, right) = (x.at(five.lower_quartile), x.at(five.upper_quartile));
    svg.rect("filled", Area { x: left, y: 3.0, width: (right - left).max(1.0), height: 10.0 });
    svg.line("median", PaperPoint::new(x.at(five.median), 1.0), PaperPoint::new(x.at(five.median), 15.0));
    svg.finish()
}

/// Draws a score within the distribution of others, 0–100: range, interquartile range and median,
/// with the own score as a dot. The numbers are shown next to it as text.
#[must_use]
pub fn draw_score_among_others(own: f64, others: &assessment::statistics::Summary) -> String {
    const MIDDLE: f64 = 16.0;
    let mut svg = Svg::ornament(260.0, 54.0, "chart");
    let x = AxisScale::new(Extent::new(0.0, 100.0), Extent::new(12.0, 248.0));
    for tick in [0.0, 50.0, 100.0] {
        svg.line("grid", PaperPoint::new(x.at(tick), 2.0), PaperPoint::new(x.at(tick), 34.0));
        svg.text("tick middle", PaperPoint::new(x.at(tick), 50.0), &format::format_points(tick));
    }
    svg.line("axis", PaperPoint::new(x.at(0.0), 34.0), PaperPoint::new(x.at(100.0), 34.0));
    svg.line("interval", PaperPoint::new(x.at(others.min), MIDDLE), PaperPoint::new(x.at(others.max), MIDDLE));
    let (left, right) = (x.at(others.lower_quartile), x.at(others.upper_quartile));
    svg.rect("box", Area { x: left, y: MIDDLE - 9.0, width: (right - left).max(1.0), height: 18.0 });
    svg.line(
        "median",
        PaperPoint::new(x.at(others.median), MIDDLE - 9.0),
        PaperPoint::new(x.at(others.median), MIDDLE + 9.0),
    );
    svg.circle("point pass", PaperPoint::new(x.at(own), MIDDLE), 4.0);
    svg.finish()
}

#[cfg(test)]
mod tests {
    //! A day's bar is as high as its number of attempts; a chart without attempts is drawn too.

    use time::macros::date;

    use super::*;

    #[test]
    fn days_are_stacked_and_empty_ones_keep_their_place() {
        let drawn = draw_attempts_by_day(&[
            (date!(2026 - 05 - 01), 2, 1),
            (date!(2026 - 05 - 02), 0, 0),
            (date!(2026 - 05 - 03), 0, 4),
        ]);
        assert_eq!(
            (drawn.matches("bar passed").count(), drawn.matches("bar failed").count()),
            (2, 4),
            "wide and narrow"
        );
        assert!(drawn.contains("7 attempts in 3 days, at most 4 on one day."));
        assert!(!draw_attempts_by_day(&[]).contains("NaN"));
    }
}
