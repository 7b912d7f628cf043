//! Scores over time, and small drawings for use in tables.

use time::OffsetDateTime;

use super::plot::Plot;
use super::scale::{AxisScale, Extent};
use super::svg::{Area, Caption, PaperPoint, Svg};
use crate::format;

/// A scored attempt on a chart.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ScorePoint {
    /// Time of the attempt.
    pub at: OffsetDateTime,
    /// Score, 0–100.
    pub score: f64,
    /// Whether the attempt was passed.
    pub passed: bool,
}

const WIDTH: f64 = 360.0;
const HEIGHT: f64 = 190.0;
/// Number of date labels along the axis.
const DATES: u32 = 3;

/// Draws scores over time with the pass mark. `key` makes the ids unique on the page.
#[must_use]
pub fn draw_scores(points: &[ScorePoint], pass_mark: f64, key: &str, title: &str) -> String {
    let id = format!("scores-{key}");
    let caption = Caption { id: &id, class: "scores", title, description: &describe_scores(points, pass_mark) };
    let area = Area { x: 40.0, y: 10.0, width: WIDTH - 96.0, height: HEIGHT - 44.0 };
    let plot = Plot::rising(area, extent_of_times(points), Extent::new(0.0, 100.0));
    let mut svg = Svg::new(WIDTH, HEIGHT, &caption);
    plot.draw_y_axis(&mut svg, 6, tr!("score"));
    draw_dates(&mut svg, &plot, points);
    let y = plot.y.at(pass_mark);
    svg.line("pass-mark", PaperPoint::new(area.x, y), PaperPoint::new(area.right(), y));
    // Right of the plot, so that it never covers an attempt.
    svg.text(
        "pass-name",
        PaperPoint::new(area.right() + 5.0, y + 4.0),
        &tr!("pass {score}", score = format::line_points(pass_mark)),
    );
    let line: Vec<_> = points.iter().map(|p| plot.at(seconds_since_1970(p.at), p.score)).collect();
    svg.polyline("score-line", &line);
    for point in points {
        draw_point(&mut svg, plot.at(seconds_since_1970(point.at), point.score), point.passed);
    }
    svg.finish()
}

/// Draws a pass as a disc, a fail as a cross.
fn draw_point(svg: &mut Svg, at: PaperPoint, passed: bool) {
    let PaperPoint { x, y } = at;
    if passed {
        svg.circle("point pass", at, 3.5);
    } else {
        svg.line("point fail", PaperPoint::new(x - 3.5, y - 3.5), PaperPoint::new(x + 3.5, y + 3.5));
        svg.line("point fail", PaperPoint::new(x - 3.5, y + 3.5), PaperPoint::new(x + 3.5, y - 3.5));
    }
}

fn describe_scores(points: &[ScorePoint], pass_mark: f64) -> String {
    let passed = points.iter().filter(|p| p.passed).count();
    match (points.first(), points.last()) {
        (Some(first), Some(last)) => tr!(
            "Attempts: {all}, of which {passed} passed at the pass mark of {mark}. The first scored {first}, the last {last}.",
            all = points.len(),
            mark = format::line_points(pass_mark),
            passed = passed,
            first = format::format_points(first.score),
            last = format::format_points(last.score)
        ),
        _ => tr!("No scored attempt yet.").to_owned(),
    }
}

/// Returns the time span shown, with a margin of at least one hour on each side.
fn extent_of_times(points: &[ScorePoint]) -> Extent {
    let seen = Extent::around(points.iter().map(|p| seconds_since_1970(p.at)));
    if !seen.from.is_finite() {
        return Extent::new(0.0, 1.0);
    }
    let margin = (seen.length() * 0.04).max(3600.0);
    Extent::new(seen.from - margin, seen.to + margin)
}

/// Returns seconds since 1970, exact in an `f64` for a few hundred million years.
fn seconds_since_1970(at: OffsetDateTime) -> f64 {
    at.unix_timestamp() as f64
}

fn draw_dates(svg: &mut Svg, plot: &Plot, points: &[ScorePoint]) {
    let area = plot.area;
    svg.line("axis", PaperPoint::new(area.x, area.bottom()), PaperPoint::new(area.right(), area.bottom()));
    if points.is_empty() {
        return;
    }
    let shown = plot.x.domain();
    let mut before = String::new();
    for i in 0..DATES {
        let share = f64::from(i) / f64::from(DATES - 1);
        let x = area.x + share * area.width;
        let day = OffsetDateTime::from_unix_timestamp((shown.from + share * shown.length()) as i64).map(|t| t.date());
        let label = day.map_or(String::new(), format::format_short_date);
        // Labels that fall on the same day would repeat the date.
        if label != before {
            let anchor = ["", " middle", " end"][i as usize];
            svg.text(&format!("tick{anchor}"), PaperPoint::new(x, area.bottom() + 16.0), &label);
            before = label;
        }
    }
}

/// Draws scores as a line with the last one marked. It repeats the table's content, so it is hidden
/// from screen readers.
#[must_use]
pub fn draw_sparkline(points: &[ScorePoint], pass_mark: f64) -> String {
    let mut svg = Svg::ornament(120.0, 28.0, "spark");
    let last = points.len().saturating_sub(1);
    let x = AxisScale::new(Extent::new(0.0, last.max(1) as f64), Extent::new(4.0, 116.0));
    let y = AxisScale::new(Extent::new(0.0, 100.0), Extent::new(25.0, 3.0));
    svg.line("pass-mark", PaperPoint::new(0.0, y.at(pass_mark)), PaperPoint::new(120.0, y.at(pass_mark)));
    let line: Vec<_> = points.iter().enumerate().map(|(i, p)| PaperPoint::new(x.at(i as f64), y.at(p.score))).collect();
    svg.polyline("score-line", &line);
    if let (Some(point), Some(at)) = (points.last(), line.last()) {
        draw_point(&mut svg, *at, point.passed);
    }
    svg.finish()
}

/// Draws one square per exercise: full with a tick if mastered, half if begun, else empty. The
/// count is shown next to it as text.
#[must_use]
pub fn draw_mastery_strip(mastered_begun: &[(bool, bool)]) -> String {
    let mut svg = Svg::ornament(mastered_begun.len() as f64 * 16.0, 14.0, "strip");
    for (i, (mastered, begun)) in mastered_begun.iter().enumerate() {
        let square = Area { x: i as f64 * 16.0 + 1.0, y: 1.0, width: 12.0, height: 12.0 };
        svg.rect(if *mastered { "cell full" } else { "cell" }, square);
        if *mastered {
            svg.polyline(
                "tick-mark",
                &[
                    PaperPoint::new(square.x + 3.0, 7.0),
                    PaperPoint::new(square.x + 5.0, 9.5),
                    PaperPoint::new(square.x + 9.0, 4.5),
                ],
            );
        } else if *begun {
            svg.rect("cell half", Area { y: 7.0, height: 6.0, ..square });
        }
    }
    svg.finish()
}

/// Draws a share, 0–1, as a bar. The number is shown next to it as text.
#[must_use]
pub fn draw_share_bar(share: f64) -> String {
    let mut svg = Svg::ornament(96.0, 8.0, "share");
    let width = AxisScale::new(Extent::new(0.0, 1.0), Extent::new(0.0, 96.0)).at(share);
    svg.rect("whole", Area { x: 0.0, y: 0.0, width: 96.0, height: 8.0 });
    svg.rect("filled", Area { x: 0.0, y: 0.0, width, height: 8.0 });
    svg.finish()
}

/// Draws a score as a bar with the pass mark on it. The numbers are shown next to it as text.
#[must_use]
pub fn draw_score_bar(score: f64, pass_mark: Option<f64>) -> String {
    let scale = AxisScale::new(Extent::new(0.0, 100.0), Extent::new(0.0, 240.0));
    let mut svg = Svg::ornament(240.0, 18.0, "score-bar");
    svg.rect("whole", Area { x: 0.0, y: 4.0, width: 240.0, height: 10.0 });
    svg.rect("filled", Area { x: 0.0, y: 4.0, width: scale.at(score), height: 10.0 });
    if let Some(mark) = pass_mark {
        svg.line("pass-mark", PaperPoint::new(scale.at(mark), 0.0), PaperPoint::new(scale.at(mark), 18.0));
    }
    svg.finish()
}

#[cfg(test)]
mod tests {
    //! Every attempt must be on the chart, with passes and fails distinguishable; zero and one
    //! attempts must be drawn too.

    use time::Duration;
    use time::macros::datetime;

    use super::*;

    fn points(scores: &[f64]) -> Vec<ScorePoint> {
        let at = |i: usize| datetime!(2026-03-02 09:00 UTC) + Duration::days(i64::try_from(i).expect("few"));
        let point = |(i, score): (usize, &f64)| ScorePoint { at: at(i), score: *score, passed: *score >= 70.0 };
        scores.iter().enumerate().map(point).collect()
    }

    #[test]
    fn passes_are_discs_and_fails_are_crosses() {
        let markup = draw_scores(&points(&[40.0, 65.0, 82.0]), 70.0, "x", "Scores");
        assert_eq!(markup.matches("point pass").count(), 1);
        assert_eq!(markup.matches("point fail").count(), 4, "two strokes per fail");
        assert!(markup.contains(">1 Mar<") || markup.contains(">2 Mar<"), "{markup}");
        assert!(markup.contains("The first scored 40, the last 82."));
    }

    #[test]
    fn none_and_one_are_drawn_without_nonsense() {
        for few in [points(&[]), points(&[50.0])] {
            for markup in [draw_scores(&few, 70.0, "x", "Scores"), draw_sparkline(&few, 70.0)] {
                assert!(!markup.contains("NaN") && !markup.contains("polyline"), "{markup}");
            }
        }
    }

    #[test]
    fn a_strip_has_a_square_per_exercise() {
        let markup = draw_mastery_strip(&[(true, true), (false, true), (false, false)]);
        assert_eq!(markup.matches("\"cell\"").count(), 2);
        assert_eq!(markup.matches("tick-mark").count(), 1);
        assert_eq!(markup.matches("cell half").count(), 1);
    }

    #[test]
    fn a_share_stays_in_its_bar() {
        assert!(draw_share_bar(7.0).contains("filled\" x=\"0\" y=\"0\" width=\"96\""));
        assert!(!draw_share_bar(0.0).contains("filled"));
    }
}
