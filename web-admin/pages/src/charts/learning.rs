//! Learning curves: LC-CUSUM and CUSUM over attempts, with their decision limits.

use assessment::learning::{Crossing, LearningPoint, Rule};

use super::plot::Plot;
use super::scale::Extent;
use super::svg::{Area, Caption, PaperPoint, Svg};

const WIDTH: f64 = 360.0;
const HEIGHT: f64 = 200.0;

/// Draws the curve with its decision limits. `key` makes the ids unique on the page.
#[must_use]
pub fn draw_learning_curve(points: &[LearningPoint], rule: &Rule, key: &str, title: &str) -> String {
    let id = format!("curve-{key}");
    let caption = Caption { id: &id, class: "scores", title, description: &describe_crossings(points) };
    let area = Area { x: 40.0, y: 10.0, width: WIDTH - 112.0, height: HEIGHT - 48.0 };
    let lines = deciding_lines(points, rule);
    let values = points.iter().map(|p| p.value).chain(lines.iter().map(|(at, _)| *at)).chain([0.0]);
    let sums = Extent::around(values);
    let plot =
        Plot::rising(area, Extent::new(0.0, (points.len().max(4)) as f64), Extent::new(sums.from - 0.3, sums.to + 0.3));
    let mut svg = Svg::new(WIDTH, HEIGHT, &caption);
    plot.draw_y_axis(&mut svg, 6, tr!("sum"));
    plot.draw_x_axis(&mut svg, 6, tr!("attempts"));
    for (at, name) in lines {
        let y = plot.y.at(at);
        svg.line("pass-mark", PaperPoint::new(area.x, y), PaperPoint::new(area.right(), y));
        svg.text("pass-name", PaperPoint::new(area.right() + 5.0, y + 4.0), name);
    }
    draw_curve_runs(&mut svg, &plot, points);
    svg.finish()
}

/// Returns the decision limits that apply somewhere on this curve.
fn deciding_lines(points: &[LearningPoint], rule: &Rule) -> Vec<(f64, &'static str)> {
    let mut lines = Vec::new();
    if let Some(learning) = rule.learning {
        lines.push((learning.h, tr!("competent")));
    }
    if rule.learning.is_none() || points.iter().any(|p| !p.learning) {
        lines.push((rule.monitor.h1, tr!("too many failures")));
        lines.push((-rule.monitor.h0, tr!("acceptable")));
    }
    lines
}

/// Draws one line per run: a crossing ends a run, and the next attempt starts again at 0.
fn draw_curve_runs(svg: &mut Svg, plot: &Plot, points: &[LearningPoint]) {
    let mut run = vec![plot.at(0.0, 0.0)];
    for (i, point) in points.iter().enumerate() {
        let place = plot.at((i + 1) as f64, point.value);
        run.push(place);
        if let Some(crossed) = point.crossed {
            svg.polyline("score-line", &run);
            draw_crossing(svg, place, crossed);
            run = vec![plot.at((i + 1) as f64, 0.0)];
        }
    }
    svg.polyline("score-line", &run);
    if let Some(last) = run.last().filter(|_| run.len() > 1) {
        svg.circle("point", *last, 3.0);
    }
}

/// Draws a disc where competence was shown, a cross where too many attempts failed.
fn draw_crossing(svg: &mut Svg, at: PaperPoint, crossed: Crossing) {
    let PaperPoint { x, y } = at;
    match crossed {
        Crossing::Acceptable => svg.circle("point pass", at, 3.5),
        Crossing::Unacceptable => {
            svg.line("point fail", PaperPoint::new(x - 3.5, y - 3.5), PaperPoint::new(x + 3.5, y + 3.5));
            svg.line("point fail", PaperPoint::new(x - 3.5, y + 3.5), PaperPoint::new(x + 3.5, y - 3.5));
        }
    }
}

fn describe_crossings(points: &[LearningPoint]) -> String {
    let crossed = |wanted| points.iter().filter(|p| p.crossed == Some(wanted)).count();
    tr!(
        "Attempts: {all}. The curve reached the line of competence {acceptable} times and the line of too many failures {unacceptable} times.",
        all = points.len(),
        acceptable = crossed(Crossing::Acceptable),
        unacceptable = crossed(Crossing::Unacceptable)
    )
}

#[cfg(test)]
mod tests {
    //! Every crossing is marked, and a curve without attempts contains no invalid coordinates.

    use assessment::learning::{CusumParams, learning_curve};

    use super::*;

    #[test]
    fn crossings_are_marked_and_lines_named() {
        let params = CusumParams { p0: 0.1, p1: 0.4, alpha: 0.1, beta: 0.1 };
        let rule = Rule::new(&params, Some(30)).expect("a rule");
        let failures: Vec<bool> = (0..40).map(|i| i > 30).collect();
        let drawn = draw_learning_curve(&learning_curve(&rule, &failures).points, &rule, "x", "Curve");
        assert!(drawn.contains("point pass") && drawn.contains("point fail") && drawn.contains(">too many failures<"));
        let empty = draw_learning_curve(&[], &rule, "x", "Curve");
        assert!(!empty.contains("NaN") && !empty.contains("polyline") && !empty.contains(">acceptable<"), "{empty}");
    }
}
