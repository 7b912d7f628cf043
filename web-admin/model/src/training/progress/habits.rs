//! Strengths of a trainee, and habits that repeatedly cost points.

use std::collections::BTreeMap;

use assessment::{Deduction, DeductionCause, catalogue};

use crate::count_u32;

/// Minimum number of attempts with a line of the rubric before it is called a strength or a habit.
pub const LEAST_ATTEMPTS: usize = 3;
/// A line with a lower mean deduction is a strength, in points of 100.
pub const STRENGTH_POINTS: f64 = 1.0;
/// Maximum number of habits, and of strengths, to be named.
pub const NAMED: usize = 3;

/// A line of the rubric over several attempts.
#[derive(Clone, Debug, PartialEq)]
pub struct RubricHabit {
    /// Id of the metric.
    pub metric: String,
    /// Name of the metric.
    pub label: String,
    /// Advice.
    pub advice: &'static str,
    /// Mean deduction, in points of 100.
    pub mean_points: f64,
    /// Number of attempts with a deduction.
    pub costly: usize,
    /// Number of attempts in which it was assessed.
    pub judged: usize,
    /// Index of the attempt with the largest deduction in the given list.
    pub worst: usize,
}

/// The lines with the largest deductions, and those with almost none.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Habits {
    /// Habits, largest deduction first, at most [`NAMED`].
    pub habits: Vec<RubricHabit>,
    /// Strengths, smallest deduction first, at most [`NAMED`].
    pub strengths: Vec<RubricHabit>,
}

impl Habits {
    /// Computes habits and strengths from the deductions of attempts. Deductions for a missed requirement are left out: they say nothing about
    /// a line.
    #[must_use]
    pub fn of(attempts: &[&[Deduction]]) -> Self {
        let mut by_metric: BTreeMap<&str, Vec<(usize, f64)>> = BTreeMap::new();
        for (place, deductions) in attempts.iter().enumerate() {
            let of_their_own = |deduction: &&Deduction| !matches!(deduction.cause, DeductionCause::Required { .. });
            for deduction in deductions.iter().filter(of_their_own) {
                by_metric.entry(&deduction.metric).or_default().push((place, deduction.points));
            }
        }
        let judged = by_metric.into_iter().filter(|(_, lost)| lost.len() >= LEAST_ATTEMPTS);
        let mut lines: Vec<RubricHabit> = judged.map(|(metric, lost)| line(metric, &lost)).collect();
        lines.sort_by(|a, b| b.mean_points.total_cmp(&a.mean_points));
        let costly = |line: &&RubricHabit| line.mean_points >= STRENGTH_POINTS;
        Self {
            habits: lines.iter().filter(costly).take(NAMED).cloned().collect(),
            strengths: lines.iter().rev().filter(|line| !costly(line)).take(NAMED).cloned().collect(),
        }
    }
}

fn line(metric: &str, lost: &[(usize, f64)]) -> RubricHabit {
    let definition = catalogue::newest_definition(metric);
    let suffix = metric.split_once('.').map(|(_, suffix)| suffix);
    let label = definition.map(|d| suffix.map_or_else(|| d.label.to_owned(), |suffix| d.label_of(suffix)));
    let judged = count_u32(lost.len());
    RubricHabit {
        metric: metric.to_owned(),
        label: label.unwrap_or_else(|| metric.to_owned()),
        advice: definition.map_or("", |d| d.advice),
        mean_points: lost.iter().map(|(_, points)| points).sum::<f64>() / f64::from(judged),
        costly: lost.iter().filter(|(_, points)| *points > 0.0).count(),
        judged: lost.len(),
        worst: lost.iter().max_by(|a, b| a.1.total_cmp(&b.1)).map_or(0, |(place, _)| *place),
    }
}

#[cfg(test)]
mod tests {
    //! Checks that a single bad attempt is not called a habit, and that a line with deductions is
    //! not called a strength.

    use assessment::UnmetRequirement;

    use super::*;

    fn attempt(lost: &[(&str, f64)]) -> Vec<Deduction> {
        let deduction = |(metric, points): &(&str, f64)| Deduction {
            metric: (*metric).to_owned(),
            version: 1,
            points: *points,
            cause: DeductionCause::NoSuchMetric,
        };
        lost.iter().map(deduction).collect()
    }

    #[test]
    fn an_attempt_that_lacks_what_is_required_tells_of_no_habit() {
        let mut missed = attempt(&[("peak_force_n", 10.0)]);
        missed[0].cause = DeductionCause::Required { unmet: UnmetRequirement::Within };
        let gentle = attempt(&[("peak_force_n", 0.0)]);
        let attempts = [&missed[..], &missed, &missed, &gentle, &gentle, &gentle];
        let Habits { habits, strengths } = Habits::of(&attempts);
        assert_eq!((habits.len(), strengths.len()), (0, 1), "{habits:?}");
    }

    #[test]
    fn the_dearest_lines_are_habits_and_the_free_ones_strengths() {
        let attempts = [
            attempt(&[("overshoot_mm", 20.0), ("peak_force_n", 0.0), ("depth_error_mm", 4.0)]),
            attempt(&[("overshoot_mm", 10.0), ("peak_force_n", 0.0), ("depth_error_mm", 8.0)]),
            attempt(&[("overshoot_mm", 30.0), ("peak_force_n", 1.5), ("depth_error_mm", 0.0), ("time_total_s", 50.0)]),
        ];
        let slices: Vec<&[Deduction]> = attempts.iter().map(Vec::as_slice).collect();
        let Habits { habits, strengths } = Habits::of(&slices);
        let names = |lines: &[RubricHabit]| lines.iter().map(|l| l.metric.clone()).collect::<Vec<_>>();
        assert_eq!(names(&habits), ["overshoot_mm", "depth_error_mm"], "one slow attempt is no habit");
        assert_eq!(names(&strengths), ["peak_force_n"]);
        let dearest = &habits[0];
        assert!((dearest.mean_points - 20.0).abs() < 1e-9);
        assert_eq!((dearest.costly, dearest.judged, dearest.worst), (3, 3, 2));
        assert!(!dearest.label.is_empty() && !dearest.advice.is_empty());
    }

    #[test]
    fn too_few_attempts_say_nothing() {
        let attempts = [attempt(&[("overshoot_mm", 20.0)]), attempt(&[("overshoot_mm", 20.0)])];
        assert_eq!(Habits::of(&attempts.iter().map(Vec::as_slice).collect::<Vec<_>>()), Habits::default());
    }
}
