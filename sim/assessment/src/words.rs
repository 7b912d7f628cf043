//! Reasons in words that a trainee can act on.

use scene::{HardFail, RubricLine};

use crate::catalogue::{Direction, Metric, definition, newest};
use crate::rubric::Finding;

/// Why a rubric line cost what it cost, for example `1.9 mm too deep: −12 points`.
pub(crate) fn reason(line: &RubricLine, finding: &Finding, points: f64) -> String {
    let what = match finding {
        Finding::Value(metric, value) if points > 0.0 => lost(line, metric, *value),
        Finding::Value(metric, value) => kept(metric, *value),
        Finding::Absent(absent) => format!("{}: {}", label(line), absent.why()),
        Finding::Unearned(unmet) => format!("{}: {}", label(line), unmet.why()),
        Finding::Unknown => format!("{}: this scene has no such metric", line.metric),
    };
    format!("{what}: {}", cost(points))
}

/// Why a limit failed the attempt: the author's words, and the figures.
pub(crate) fn hard_fail(limit: &HardFail, metric: &Metric, value: f64) -> String {
    let (found, allowed) = (figure(value, &metric.unit), figure(limit.above, &metric.unit));
    format!("{} ({} {found}, limit {allowed})", limit.why, metric.label)
}

fn label(line: &RubricLine) -> String {
    let (base, suffix) = line.metric.split_once('.').unwrap_or((&line.metric, ""));
    match newest(&line.metric) {
        Some(definition) if suffix.is_empty() => definition.label.to_owned(),
        Some(definition) => definition.label_of(suffix),
        None => base.to_owned(),
    }
}

fn lost(line: &RubricLine, metric: &Metric, value: f64) -> String {
    if let Some(side) = side(metric, value) {
        return side;
    }
    let bound = if line.full > line.zero { "more" } else { "less" };
    let (found, full) = (figure(value, &metric.unit), figure(line.full, &metric.unit));
    let advice = definition(&metric.id, metric.version).map_or("", |definition| definition.advice);
    format!("{} {found}, full marks for {full} or {bound} – {advice}", metric.label)
}

fn kept(metric: &Metric, value: f64) -> String {
    side(metric, value).unwrap_or_else(|| format!("{} {}", metric.label, figure(value, &metric.unit)))
}

/// A range metric says to which side.
fn side(metric: &Metric, value: f64) -> Option<String> {
    let words = if value >= 0.0 { "too deep" } else { "too shallow" };
    (metric.direction == Direction::Range).then(|| format!("{} {words}", figure(value.abs(), &metric.unit)))
}

fn cost(points: f64) -> String {
    if points <= 0.0 {
        return "no points lost".to_owned();
    }
    // What was lost is never shown as nothing.
    let shown = rounded(points.max(0.1), if points < 9.95 { 1 } else { 0 });
    let noun = if shown == "1" { "point" } else { "points" };
    format!("−{shown} {noun}")
}

/// A value with its unit, to a precision that a trainee can use.
fn figure(value: f64, unit: &str) -> String {
    let decimals = match value.abs() {
        size if size >= 100.0 => 0,
        size if size >= 1.0 => 1,
        size if size >= 0.1 => 2,
        _ => 3,
    };
    let number = rounded(value, decimals).replace('-', "−");
    match unit {
        "count" | "1" => number,
        "°" => format!("{number}°"),
        _ => format!("{number} {unit}"),
    }
}

/// Fixed decimals without trailing zeros, and without a negative zero.
fn rounded(value: f64, decimals: usize) -> String {
    let text = format!("{value:.decimals$}");
    let short = if decimals > 0 { text.trim_end_matches('0').trim_end_matches('.') } else { &text };
    if short == "-0" { "0".to_owned() } else { short.to_owned() }
}

#[cfg(test)]
mod tests {
    //! Figures and costs read as a person would write them.
    //! Fails when a loss rounds to nothing, a zero carries a sign, or a figure shows digits that nobody can use.

    use super::*;

    #[test]
    fn figures_have_sensible_precision() {
        let cases = [(1.93, "mm", "1.9 mm"), (12.0, "N", "12 N"), (123.4, "mm", "123 mm"), (0.456, "N", "0.46 N")];
        for (value, unit, text) in cases {
            assert_eq!(figure(value, unit), text);
        }
        assert_eq!(figure(-7.25, "1"), "−7.2");
        assert_eq!(figure(-0.0001, "mm"), "0 mm");
        assert_eq!(figure(2.0, "count"), "2");
        assert_eq!(figure(3.21, "°"), "3.2°");
    }

    #[test]
    fn costs_say_what_was_lost() {
        assert_eq!(cost(12.3), "−12 points");
        assert_eq!(cost(1.0), "−1 point");
        assert_eq!(cost(2.54), "−2.5 points");
        assert_eq!(cost(0.001), "−0.1 points");
        assert_eq!(cost(0.0), "no points lost");
    }
}
