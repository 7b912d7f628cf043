//! Causes in words that a trainee can act on, in English.

use crate::catalogue::{Definition, Direction, find_definition, newest_definition};
use crate::cause::{Deduction, DeductionCause, FailureCause, HardFailure};

/// Why a rubric line cost what it cost, for example `1.9 mm too deep: −12 points`.
#[must_use]
pub fn deduction_in_words(deduction: &Deduction) -> String {
    let metric = Measure::new(&deduction.metric, deduction.version);
    let what = match &deduction.cause {
        DeductionCause::Measured { value, full, zero } => {
            let advised = deduction.points > 0.0;
            metric.measured(*value, advised.then_some((*full, full > zero)))
        }
        DeductionCause::Absent { reason } => format!("{}: {}", metric.label, reason.words()),
        DeductionCause::Required { unmet } => format!("{}: {}", metric.label, unmet.words()),
        DeductionCause::NoSuchMetric => format!("{}: this scene has no such metric", deduction.metric),
        DeductionCause::Worded { words } => words.clone(),
    };
    what + &cost_in_words(deduction.points)
}

/// What a line cost, as it ends a sentence: `: −12 points`.
pub(crate) fn cost_in_words(points: f64) -> String {
    format!(": {}", say_points(points))
}

/// Why an attempt failed: the author's words, and the figures.
#[must_use]
pub fn failure_in_words(failure: &HardFailure) -> String {
    match &failure.cause {
        FailureCause::Required { unmet } => unmet.failure_words().to_owned(),
        FailureCause::Limit { words, metric, version, value, limit } => {
            let Measure { label, definition } = Measure::new(metric, *version);
            let unit = definition.map_or("", |definition| definition.unit);
            format!("{words} ({label} {}, limit {})", say_figure(*value, unit), say_figure(*limit, unit))
        }
        FailureCause::Worded { words } => words.clone(),
    }
}

/// What words are found for.
struct Measure {
    label: String,
    definition: Option<&'static Definition>,
}

impl Measure {
    fn new(id: &str, version: u32) -> Self {
        let (base, suffix) = id.split_once('.').unwrap_or((id, ""));
        let label = match newest_definition(id) {
            Some(definition) if suffix.is_empty() => definition.label.to_owned(),
            Some(definition) => definition.label_of(suffix),
            None => base.to_owned(),
        };
        Self { label, definition: find_definition(id, version) }
    }

    /// A value; where it cost something, also what earns full marks, whether more than that does, and advice.
    fn measured(&self, value: f64, full: Option<(f64, bool)>) -> String {
        let unit = self.definition.map_or("", |definition| definition.unit);
        // A range metric says to which side.
        if self.definition.is_some_and(|definition| definition.direction == Direction::Range) {
            let side = if value >= 0.0 { "too deep" } else { "too shallow" };
            return format!("{} {side}", say_figure(value.abs(), unit));
        }
        let found = format!("{} {}", self.label, say_figure(value, unit));
        let Some((full, more)) = full else { return found };
        let (bound, advice) = (if more { "more" } else { "less" }, self.definition.map_or("", |d| d.advice));
        format!("{found}, full marks for {} or {bound} – {advice}", say_figure(full, unit))
    }
}

fn say_points(points: f64) -> String {
    if points <= 0.0 {
        return "no points lost".to_owned();
    }
    // What was lost is never shown as nothing.
    let shown = round_decimals(points.max(0.1), if points < 9.95 { 1 } else { 0 });
    let noun = if shown == "1" { "point" } else { "points" };
    format!("−{shown} {noun}")
}

/// A value with its unit, to a precision that a trainee can use.
#[must_use]
pub fn say_figure(value: f64, unit: &str) -> String {
    let decimals = match value.abs() {
        size if size >= 100.0 => 0,
        size if size >= 1.0 => 1,
        size if size >= 0.1 => 2,
        _ => 3,
    };
    let number = round_decimals(value, decimals).replace('-', "−");
    match unit {
        "count" | "1" => number,
        "°" => format!("{number}°"),
        _ => format!("{number} {unit}"),
    }
}

/// Fixed decimals without trailing zeros, and without a negative zero.
fn round_decimals(value: f64, decimals: usize) -> String {
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
            assert_eq!(say_figure(value, unit), text);
        }
        assert_eq!(say_figure(-7.25, "1"), "−7.2");
        assert_eq!(say_figure(-0.0001, "mm"), "0 mm");
        assert_eq!(say_figure(2.0, "count"), "2");
        assert_eq!(say_figure(3.21, "°"), "3.2°");
    }

    #[test]
    fn costs_say_what_was_lost() {
        assert_eq!(say_points(12.3), "−12 points");
        assert_eq!(say_points(1.0), "−1 point");
        assert_eq!(say_points(2.54), "−2.5 points");
        assert_eq!(say_points(0.001), "−0.1 points");
        assert_eq!(say_points(0.0), "no points lost");
    }
}
