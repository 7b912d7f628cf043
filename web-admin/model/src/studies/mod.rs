//! Statistics of a validation study: group differences, learning curves and repeatability.
//!
//! Comparisons are between people, not attempts: each person contributes the mean of their
//! attempts, because attempts of one person are not independent observations.

use assessment::statistics::{
    self, Estimate, IntraclassCorrelation, NotComputable, RankSumTest, Summary, area_under_curve, hedges_g,
    holm_adjusted, intraclass_correlation, mann_whitney,
};
use serde::Serialize;

/// Value of a metric in one attempt.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StudyValue {
    /// Index of the participant.
    pub participant: usize,
    /// Number of the participant's attempt, from 1.
    pub number: usize,
    /// Value, in the metric's unit.
    pub value: f64,
}

/// A metric, or the score, over the attempts of a study at one exercise.
#[derive(Clone, Debug, PartialEq)]
pub struct StudyMetric {
    /// Id; `score` for the score.
    pub id: String,
    /// Name.
    pub label: String,
    /// Unit.
    pub unit: String,
    /// Values of the attempts that have one.
    pub values: Vec<StudyValue>,
}

/// Assignment of the participants to groups.
#[derive(Clone, Copy, Debug)]
pub struct StudyGroups<'a> {
    /// Index of each participant's group.
    pub of_participants: &'a [usize],
    /// Number of groups: the first is the least experienced, the last are the experts.
    pub count: usize,
}

/// Comparison of the groups in a metric, and of the experts with the least experienced.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct StudyComparison {
    /// Id of the metric; `score` for the score.
    pub id: String,
    /// Name of the metric.
    pub label: String,
    /// Unit of the metric.
    pub unit: String,
    /// Summary of each group, over the means of each participant's attempts.
    pub groups: Vec<Option<Summary>>,
    /// Test of the experts against the least experienced.
    pub test: RankSumTest,
    /// p value of the test after Holm's correction over all metrics of the exercise.
    pub p_holm: f64,
    /// Hedges' g: difference between experts and the least experienced, in standard deviations.
    pub hedges_g: Option<Estimate>,
    /// Probability that an expert's value is above that of a person of the first group.
    pub auc: Option<Estimate>,
}

/// Results of a study for one exercise.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct StudyFindings {
    /// Comparisons: the score first, then the metrics by the p value of their test.
    pub comparisons: Vec<StudyComparison>,
    /// Number of metrics that are not compared: they have fewer than two people on one side, or the
    /// values of all people are equal within [`SAME`]. An example is the force at a pop, which the
    /// tissue determines: a test would find differences in the last digit of a simulation
    /// significant.
    pub left_out: usize,
    /// Mean score of each group at each attempt, from the first.
    pub learning: Vec<Vec<Option<Estimate>>>,
    /// Agreement between the scores of each participant's attempts.
    pub repeated: Result<IntraclassCorrelation, NotComputable>,
}

impl StudyFindings {
    /// Computes the results from the score and the metrics of all attempts, up to `attempts` per
    /// participant.
    #[must_use]
    pub fn new(groups: StudyGroups<'_>, attempts: usize, score: &StudyMetric, metrics: &[StudyMetric]) -> Self {
        let differing = metrics.iter().filter(|metric| !is_same_for_everybody(&means_by_group(groups, metric)));
        let found: Vec<StudyComparison> =
            std::iter::once(score).chain(differing).filter_map(|metric| compare(groups, metric)).collect();
        let corrected = holm_adjusted(&found.iter().map(|found| found.test.p).collect::<Vec<_>>());
        let mut comparisons: Vec<StudyComparison> =
            found.into_iter().zip(corrected).map(|(found, p_holm)| StudyComparison { p_holm, ..found }).collect();
        comparisons.sort_by(|a, b| {
            (a.id != score.id, a.test.p).partial_cmp(&(b.id != score.id, b.test.p)).unwrap_or(std::cmp::Ordering::Equal)
        });
        Self {
            left_out: 1 + metrics.len() - comparisons.len(),
            comparisons,
            learning: (0..groups.count).map(|group| learning_of_group(groups, group, attempts, score)).collect(),
            repeated: repeated_scores(groups, attempts, score),
        }
    }
}

/// Returns the means of the participants' attempts, by group.
fn means_by_group(groups: StudyGroups<'_>, metric: &StudyMetric) -> Vec<Vec<f64>> {
    let mut sums = vec![(0.0, 0.0); groups.of_participants.len()];
    for value in &metric.values {
        if let Some((sum, count)) = sums.get_mut(value.participant) {
            *sum += value.value;
            *count += 1.0;
        }
    }
    let mut means = vec![Vec::new(); groups.count];
    for ((sum, count), group) in sums.into_iter().zip(groups.of_participants) {
        if count > 0.0 && *group < groups.count {
            means[*group].push(sum / count);
        }
    }
    means
}

/// Values that differ by at most this fraction of the largest are considered equal.
const SAME: f64 = 0.02;

fn is_same_for_everybody(means: &[Vec<f64>]) -> bool {
    let all = || means.iter().flatten().copied();
    let (least, most) = (all().fold(f64::INFINITY, f64::min), all().fold(f64::NEG_INFINITY, f64::max));
    most - least <= SAME * least.abs().max(most.abs())
}

fn compare(groups: StudyGroups<'_>, metric: &StudyMetric) -> Option<StudyComparison> {
    let means = means_by_group(groups, metric);
    let (first, experts) = (means.first()?, means.last()?);
    let test = mann_whitney(experts, first).ok()?;
    Some(StudyComparison {
        id: metric.id.clone(),
        label: metric.label.clone(),
        unit: metric.unit.clone(),
        groups: means.iter().map(|values| statistics::summary(values).ok()).collect(),
        test,
        p_holm: test.p,
        hedges_g: hedges_g(experts, first).ok(),
        auc: area_under_curve(experts, first).ok(),
    })
}

fn learning_of_group(
    groups: StudyGroups<'_>,
    group: usize,
    attempts: usize,
    score: &StudyMetric,
) -> Vec<Option<Estimate>> {
    let of_group = |value: &&StudyValue| groups.of_participants.get(value.participant) == Some(&group);
    let at = |number: usize| {
        let scores: Vec<f64> = score
            .values
            .iter()
            .filter(of_group)
            .filter(|value| value.number == number)
            .map(|value| value.value)
            .collect();
        // Scores end at 0 and at 100, and so does an interval of their mean.
        let mean = statistics::mean(&scores).ok()?;
        Some(Estimate { low: mean.low.max(0.0), high: mean.high.min(100.0), ..mean })
    };
    (1..=attempts).map(at).collect()
}

fn repeated_scores(
    groups: StudyGroups<'_>,
    attempts: usize,
    score: &StudyMetric,
) -> Result<IntraclassCorrelation, NotComputable> {
    let mut rows = vec![vec![None; attempts]; groups.of_participants.len()];
    for value in &score.values {
        let place = rows.get_mut(value.participant).and_then(|row| row.get_mut(value.number.wrapping_sub(1)));
        if let Some(place) = place {
            *place = Some(value.value);
        }
    }
    rows.retain(|row| row.iter().any(Option::is_some));
    intraclass_correlation(&rows)
}

#[cfg(test)]
mod tests {
    //! Checks that people are compared instead of attempts, that metrics that are equal for all are
    //! not tested, and that the correction covers all tests.

    use super::*;

    fn metric(id: &str, of: impl Fn(usize, usize) -> f64) -> StudyMetric {
        let values = (0..8).flat_map(|participant| (1..=2).map(move |number| (participant, number)));
        let value = |(participant, number)| StudyValue { participant, number, value: of(participant, number) };
        StudyMetric {
            id: id.to_owned(),
            label: id.to_owned(),
            unit: "1".to_owned(),
            values: values.map(value).collect(),
        }
    }

    #[test]
    fn people_are_compared_by_the_mean_of_their_attempts() {
        let groups = StudyGroups { of_participants: &[0, 0, 0, 0, 1, 1, 1, 1], count: 2 };
        let score = metric("score", |participant, number| participant as f64 * 10.0 + number as f64);
        let same = metric("same", |participant, _| 1.9 + participant as f64 * 1e-3);
        let other = metric("other", |participant, _| (participant % 4) as f64);
        let found = StudyFindings::new(groups, 2, &score, &[same, other]);
        assert_eq!((found.comparisons.len(), found.left_out), (2, 1));
        let first = &found.comparisons[0];
        assert_eq!((first.test.first_n, first.test.second_n, first.test.u), (4, 4, 16.0), "four people a side");
        assert!((first.test.p - 2.0 / 70.0).abs() < 1e-12, "counted over 70 ways: {first:?}");
        assert!((first.p_holm - 4.0 / 70.0).abs() < 1e-12, "two were asked: {first:?}");
        assert_eq!(first.groups[0].as_ref().map(|summary| (summary.n, summary.median)), Some((4, 16.5)));
        let learning = |group: usize, at: usize| found.learning[group][at].as_ref().map(|mean| mean.value);
        assert_eq!((learning(0, 0), learning(1, 1)), (Some(16.0), Some(57.0)));
        let agreement = found.repeated.expect("eight people, two attempts each");
        assert!(agreement.single_random > 0.99 && agreement.n == 8, "{agreement:?}");
    }

    #[test]
    fn a_study_without_attempts_finds_nothing() {
        let groups = StudyGroups { of_participants: &[0, 1], count: 2 };
        let none = StudyMetric { values: vec![], ..metric("score", |_, _| 0.0) };
        let found = StudyFindings::new(groups, 3, &none, &[]);
        assert_eq!((found.comparisons.len(), found.left_out, found.learning[0].len()), (0, 1, 3));
        assert!(found.repeated.is_err());
    }
}
