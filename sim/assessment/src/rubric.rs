//! Evaluates rubric lines and limits.

use documents::{Exercise, RubricLine};

use crate::absent::Absent;
use crate::catalogue::{Direction, Metric, find_metric, first_version, is_untouched};
use crate::cause::{Deduction, DeductionCause, FailureCause, HardFailure};
use crate::error::AssessError;
use crate::required::{self, UnmetRequirement};

/// The result of a rubric line's metric.
#[derive(Clone, Copy)]
pub(crate) enum LineFinding<'a> {
    /// It has a value.
    Value(&'a Metric, f64),
    /// It does not apply, for this reason.
    Absent(Absent),
    /// The line earns nothing regardless of its value: a requirement was not met.
    Unearned(UnmetRequirement),
    /// This scene has no such metric.
    Unknown,
}

/// Returns whether an attempt can be judged by these metrics alone: every metric used by a line, a
/// limit or a requirement was measured by its current definition. Otherwise the recording must be
/// measured again.
#[must_use]
pub fn suffices(exercise: &Exercise, metrics: &[Metric]) -> bool {
    let known = |id: &str, version| find_metric(metrics, id, version).is_some();
    let lines = exercise.rubric.iter().all(|line| known(&line.metric, line.version));
    let limits = exercise.hard_fails.iter().all(|limit| known(&limit.metric, limit.version));
    lines && limits && required::required_metrics(exercise).all(|id| known(&id, first_version()))
}

/// Returns one deduction per rubric line, the largest first; 100 points minus their sum is the
/// score.
pub(crate) fn find_deductions(exercise: &Exercise, metrics: &[Metric]) -> Result<Vec<Deduction>, AssessError> {
    let total: f64 = exercise.rubric.iter().map(line_weight).sum();
    if total <= 0.0 || !total.is_finite() {
        return Err(AssessError::Document(format!(
            "exercise {}: rubric weights add up to {total}; there must be a line with a finite weight above 0",
            exercise.id
        )));
    }
    let unmet = required::find_unmet(exercise, metrics);
    let mut deductions: Vec<Deduction> = exercise
        .rubric
        .iter()
        .map(|line| {
            let finding = find_line_value(line, metrics, unmet.first());
            let share = earned_share(line, &finding, exercise.required.is_none());
            let points = 100.0 * line_weight(line) / total * (1.0 - share);
            let cause = deduction_cause(line, &finding);
            Deduction { metric: line.metric.clone(), version: line.version, points, cause }
        })
        .collect();
    deductions.sort_by(|a, b| b.points.total_cmp(&a.points));
    Ok(deductions)
}

fn deduction_cause(line: &RubricLine, finding: &LineFinding) -> DeductionCause {
    match *finding {
        LineFinding::Value(_, value) => DeductionCause::Measured { value, full: line.full, zero: line.zero },
        LineFinding::Absent(reason) => DeductionCause::Absent { reason },
        LineFinding::Unearned(unmet) => DeductionCause::Required { unmet },
        LineFinding::Unknown => DeductionCause::NoSuchMetric,
    }
}

fn line_weight(line: &RubricLine) -> f64 {
    if line.weight > 0.0 { line.weight } else { 0.0 }
}

/// Evaluates the metric of a line. An attempt that never touched the skin earns nothing, not even
/// for being quick; neither does one that does not meet the requirements.
fn find_line_value<'a>(line: &RubricLine, metrics: &'a [Metric], unmet: Option<&UnmetRequirement>) -> LineFinding<'a> {
    let Some(found) = find_metric(metrics, &line.metric, line.version) else { return LineFinding::Unknown };
    match (found.value, found.absent) {
        _ if is_untouched(metrics) => LineFinding::Absent(Absent::Untouched),
        _ if let Some(unmet) = unmet => LineFinding::Unearned(*unmet),
        (Some(value), _) => LineFinding::Value(found, value),
        (None, Some(absent)) => LineFinding::Absent(absent),
        (None, None) => LineFinding::Unknown,
    }
}

/// Returns the share of the line's points that the attempt earned, 0–1. `unmet_earns`: in documents
/// without a `[required]` table, a layer or boundary that was not reached earns full marks.
fn earned_share(line: &RubricLine, finding: &LineFinding, unmet_earns: bool) -> f64 {
    match finding {
        LineFinding::Value(metric, value) => linear_share(line, judged_value(metric.direction, *value)),
        LineFinding::Absent(absent) if absent.is_harmless() && unmet_earns => 1.0,
        LineFinding::Absent(_) | LineFinding::Unearned(_) | LineFinding::Unknown => 0.0,
    }
}

/// Returns the value to compare with `full` and `zero`: a range metric's distance from 0, any other
/// metric's value.
fn judged_value(direction: Direction, value: f64) -> f64 {
    if direction == Direction::Range { value.abs() } else { value }
}

/// Returns 1 at `full`, 0 at `zero`, linear between, clamped. If both are equal, that value earns
/// full marks.
fn linear_share(line: &RubricLine, value: f64) -> f64 {
    let rising = line.full > line.zero;
    if (rising && value >= line.full) || (!rising && value <= line.full) {
        return 1.0;
    }
    let share = (value - line.zero) / (line.full - line.zero);
    if share.is_finite() { share.clamp(0.0, 1.0) } else { 0.0 }
}

/// Returns each requirement that was not met, and each limit that was exceeded.
pub(crate) fn find_failures(exercise: &Exercise, metrics: &[Metric]) -> Vec<HardFailure> {
    let unmet = required::find_unmet(exercise, metrics).into_iter().map(|unmet| FailureCause::Required { unmet });
    let broken = exercise.hard_fails.iter().filter_map(|limit| {
        let found = find_metric(metrics, &limit.metric, limit.version)?;
        let value = found.value.filter(|value| *value > limit.above)?;
        let (words, metric, version) = (limit.why.clone(), limit.metric.clone(), limit.version);
        Some(FailureCause::Limit { words, metric, version, value, limit: limit.above })
    });
    unmet.chain(broken).map(|cause| HardFailure { cause }).collect()
}

#[cfg(test)]
mod tests {
    //! A rubric line earns 1 at full, 0 at zero and is linear between, in either direction; a line
    //! without width must not divide by zero.

    use super::*;

    fn line(full: f64, zero: f64) -> RubricLine {
        RubricLine { metric: "peak_force_n".to_owned(), version: 1, full, zero, weight: 1.0 }
    }

    #[test]
    fn lower_and_higher_lines_are_linear_and_clamped() {
        for (value, share) in [(0.0, 1.0), (2.0, 1.0), (3.0, 0.75), (5.0, 0.25), (6.0, 0.0), (60.0, 0.0)] {
            assert!((linear_share(&line(2.0, 6.0), value) - share).abs() < 1e-12, "lower at {value}");
        }
        for (value, share) in [(-9.0, 0.0), (-8.0, 0.0), (-6.5, 0.5), (-5.0, 1.0), (1.0, 1.0)] {
            assert!((linear_share(&line(-5.0, -8.0), value) - share).abs() < 1e-12, "higher at {value}");
        }
    }

    #[test]
    fn a_line_without_width_is_a_step() {
        assert!((linear_share(&line(2.0, 2.0), 2.0) - 1.0).abs() < 1e-12);
        assert!(linear_share(&line(2.0, 2.0), 2.1).abs() < 1e-12);
        assert!(linear_share(&line(f64::NAN, 2.0), 2.1).abs() < 1e-12);
    }

    #[test]
    fn a_range_is_judged_by_its_distance_from_zero() {
        assert!((judged_value(Direction::Range, -3.0) - 3.0).abs() < 1e-12);
        assert!((judged_value(Direction::Higher, -3.0) + 3.0).abs() < 1e-12);
    }
}
