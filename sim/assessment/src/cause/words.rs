//! Formats reasons as advice to the trainee: as translatable phrases, and in English.

use phrase::{Phrase, phrase};

use crate::catalogue::{Direction, find_definition, newest_definition};
use crate::cause::{Deduction, DeductionCause, FailureCause, HardFailure};

/// Formats a deduction in English, for example `1.9 mm too deep: −12 points`.
#[must_use]
pub fn deduction_in_words(deduction: &Deduction) -> String {
    deduction_with_cost(deduction).to_string()
}

/// Formats a deduction with the points lost.
#[must_use]
pub fn deduction_with_cost(deduction: &Deduction) -> Phrase {
    let why = deduction_phrase(deduction, deduction.points > 0.0);
    phrase!("{why}: {cost}", why = why, cost = cost_phrase(deduction.points))
}

/// Formats the points lost as the end of a sentence: `: −12 points`.
pub(crate) fn cost_in_words(points: f64) -> String {
    format!(": {}", cost_phrase(points))
}

/// Formats a failure in English: the author's message and the values.
#[must_use]
pub fn failure_in_words(failure: &HardFailure) -> String {
    failure_phrase(failure).to_string()
}

/// Returns the name of a metric; for an unknown one, its id.
#[must_use]
pub fn name_metric(id: &str) -> Phrase {
    match (newest_definition(id), id.split_once('.')) {
        (None, _) => Phrase::data(id),
        (Some(definition), None) => Phrase::sentence(definition.label),
        (Some(definition), Some((_, part))) => definition.name_part(part),
    }
}

/// Formats the reason for lost points; if `advised`, adds the value for full marks and the advice.
#[must_use]
pub fn deduction_phrase(deduction: &Deduction, advised: bool) -> Phrase {
    let metric = || name_metric(&deduction.metric);
    match &deduction.cause {
        DeductionCause::Measured { value, full, zero } => {
            measured(deduction, *value, advised.then_some((*full, full > zero)))
        }
        DeductionCause::Absent { reason } => {
            phrase!("{metric}: {reason}", metric = metric(), reason = Phrase::sentence(reason.words()))
        }
        DeductionCause::Required { unmet } => {
            phrase!("{metric}: {reason}", metric = metric(), reason = Phrase::sentence(unmet.words()))
        }
        DeductionCause::NoSuchMetric => {
            phrase!("{metric}: not available in this scene", metric = &deduction.metric)
        }
        DeductionCause::Worded { words } => Phrase::data(words),
    }
}

/// Formats a value; with `full`, adds the value for full marks, whether larger values earn them
/// too, and the advice.
fn measured(deduction: &Deduction, value: f64, full: Option<(f64, bool)>) -> Phrase {
    let definition = find_definition(&deduction.metric, deduction.version);
    let unit = definition.map_or("", |definition| definition.unit);
    // For a range metric, state the side.
    if definition.is_some_and(|definition| definition.direction == Direction::Range) {
        let found = figure_phrase(value.abs(), unit);
        return if value >= 0.0 {
            phrase!("{found} too deep", found = found)
        } else {
            phrase!("{found} too shallow", found = found)
        };
    }
    let found = metric_with_value(&deduction.metric, value, unit);
    let Some((full, more)) = full else { return found };
    let (full, advice) = (figure_phrase(full, unit), Phrase::sentence(definition.map_or("", |d| d.advice)));
    if more {
        phrase!("{found}, full marks for {full} or more – {advice}", found = found, full = full, advice = advice)
    } else {
        phrase!("{found}, full marks for {full} or less – {advice}", found = found, full = full, advice = advice)
    }
}

fn metric_with_value(metric: &str, value: f64, unit: &str) -> Phrase {
    phrase!("{metric} {value}", metric = name_metric(metric), value = figure_phrase(value, unit))
}

/// Formats a failure: the author's message and the values.
#[must_use]
pub fn failure_phrase(failure: &HardFailure) -> Phrase {
    match &failure.cause {
        FailureCause::Required { unmet } => Phrase::sentence(unmet.failure_words()),
        FailureCause::Limit { words, metric, version, value, limit } => {
            let unit = find_definition(metric, *version).map_or("", |definition| definition.unit);
            let (found, limit) = (metric_with_value(metric, *value, unit), figure_phrase(*limit, unit));
            phrase!("{why} ({found}, limit {limit})", why = words, found = found, limit = limit)
        }
        FailureCause::Worded { words } => Phrase::Known(words.clone()),
    }
}

/// Formats the points lost.
#[must_use]
pub fn cost_phrase(points: f64) -> Phrase {
    if points <= 0.0 {
        return phrase!("no points lost");
    }
    // A loss must never be rounded to nothing.
    let shown = round_decimals(points.max(0.1), if points < 9.95 { 1 } else { 0 });
    if shown == "1" {
        phrase!("−{points} point", points = Phrase::Number(shown))
    } else {
        phrase!("−{points} points", points = Phrase::Number(shown))
    }
}

fn figure_phrase(value: f64, unit: &str) -> Phrase {
    Phrase::Number(say_figure(value, unit))
}

/// Formats a value with its unit, to a precision that is useful to a trainee.
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

/// Rounds to fixed decimals, without trailing zeros and without a negative zero.
fn round_decimals(value: f64, decimals: usize) -> String {
    let text = format!("{value:.decimals$}");
    let short = if decimals > 0 { text.trim_end_matches('0').trim_end_matches('.') } else { &text };
    if short == "-0" { "0".to_owned() } else { short.to_owned() }
}

#[cfg(test)]
mod tests {
    //! Values and points must be readable: a loss is not rounded to nothing, zero has no sign, and
    //! there are no useless digits.

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
        assert_eq!(cost_phrase(12.3).to_string(), "−12 points");
        assert_eq!(cost_phrase(1.0).to_string(), "−1 point");
        assert_eq!(cost_phrase(2.54).to_string(), "−2.5 points");
        assert_eq!(cost_phrase(0.001).to_string(), "−0.1 points");
        assert_eq!(cost_phrase(0.0).to_string(), "no points lost");
    }
}
