//! Figures of merit of a metric, computed from the simulated groups.

use std::cmp::Ordering;

use assessment::catalogue::Definition;
use assessment::statistics::{Estimate, area_under_curve, intraclass_correlation};
use assessment::{Assessment, Direction};

use super::crowd::Crowd;

/// A mean over exercises, with its interval.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pooled {
    pub value: f64,
    pub low: f64,
    pub high: f64,
}

/// Figures of a metric; `None` if no exercise yields one.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Figures {
    /// Probability that an expert's value is better than a novice's, 0–1.
    pub separation: Option<Pooled>,
    /// ICC(2,1) of the people's attempts.
    pub agreement: Option<Pooled>,
    /// Effect of the tremor: median over the people of the change relative to the larger value.
    pub tremor: Option<f64>,
    /// Effect of a quarter of the rate: maximum over the people of the change relative to the
    /// larger value.
    pub rate: Option<f64>,
}

/// A column of the table: reads one number from an attempt.
pub struct MetricReading<'a> {
    id: String,
    version: u32,
    direction: Direction,
    crowd: &'a Crowd,
}

impl<'a> MetricReading<'a> {
    /// Returns every column of a definition: the form without suffix in each exercise, or the forms
    /// with suffix if it has none.
    pub fn of_metric(definition: &Definition, crowds: &'a [Crowd]) -> Vec<Self> {
        let of_crowd = |crowd: &'a Crowd| {
            let metrics = crowd.novices.first().map_or(&[][..], |attempt| &attempt.metrics);
            let is_part = |id: &str| id.strip_prefix(definition.id).is_some_and(|rest| rest.starts_with('.'));
            let chosen = metrics.iter().filter(move |metric| {
                let named = if definition.plain { metric.id == definition.id } else { is_part(&metric.id) };
                named && metric.version == definition.version
            });
            let column = |metric: &assessment::Metric| MetricReading {
                id: metric.id.clone(),
                version: metric.version,
                direction: metric.direction,
                crowd,
            };
            chosen.map(column).collect::<Vec<_>>()
        };
        crowds.iter().flat_map(of_crowd).collect()
    }

    /// Returns the columns of the scores of every exercise.
    pub fn of_scores(crowds: &'a [Crowd]) -> Vec<Self> {
        let column = |crowd| Self { id: SCORE.to_owned(), version: 1, direction: Direction::Higher, crowd };
        crowds.iter().map(column).collect()
    }

    fn value(&self, attempt: &Assessment) -> Option<f64> {
        if self.id == SCORE { Some(attempt.score) } else { attempt.value_of(&self.id, self.version) }
    }

    /// Returns the value, transformed so that larger is better.
    fn goodness(&self, attempt: &Assessment) -> Option<f64> {
        self.value(attempt).map(|value| match self.direction {
            Direction::Higher => value,
            Direction::Lower => -value,
            Direction::Range => -value.abs(),
        })
    }

    /// Returns `None` if everybody's value is the same, so that no conclusion is possible.
    fn separation(&self) -> Option<Estimate> {
        let group = |attempts: &[Assessment]| attempts.iter().filter_map(|a| self.goodness(a)).collect::<Vec<f64>>();
        let (experts, novices) = (group(&self.crowd.experts), group(&self.crowd.novices));
        let mut all = experts.iter().chain(&novices);
        let first = all.next()?;
        if all.all(|value| value.partial_cmp(first).is_some_and(Ordering::is_eq)) {
            return None;
        }
        area_under_curve(&experts, &novices).ok()
    }

    fn agreement(&self) -> Option<Pooled> {
        let row = |attempts: &Vec<Assessment>| attempts.iter().map(|a| self.goodness(a)).collect::<Vec<_>>();
        let rows: Vec<_> = self.crowd.again.iter().map(row).collect();
        let found = intraclass_correlation(&rows).ok()?;
        let (low, high) = found.single_random_95?;
        Some(Pooled { value: found.single_random, low, high })
    }

    /// Returns the change of each person's first attempt in another version of it, relative to the
    /// larger value.
    fn differences(&self, others: &[Assessment]) -> Vec<f64> {
        let firsts = self.crowd.again.iter().filter_map(|attempts| attempts.first());
        let pair = |(first, other): (&Assessment, &Assessment)| {
            let (a, b) = (self.value(first)?, self.value(other)?);
            let larger = a.abs().max(b.abs());
            Some(if larger > 0.0 { (a - b).abs() / larger } else { 0.0 })
        };
        firsts.zip(others).filter_map(pair).collect()
    }
}

/// Stands for the score in place of a metric's id.
pub const SCORE: &str = "score";

impl Figures {
    /// Pools the columns of a metric.
    pub fn from_readings(columns: &[MetricReading]) -> Self {
        let areas: Vec<Pooled> = columns.iter().filter_map(MetricReading::separation).map(pooled).collect();
        let agreements: Vec<Pooled> = columns.iter().filter_map(MetricReading::agreement).collect();
        let tremor: Vec<f64> = columns.iter().flat_map(|c| c.differences(&c.crowd.steady)).collect();
        let rate: Vec<f64> = columns.iter().flat_map(|c| c.differences(&c.crowd.slow)).collect();
        Self {
            separation: mean(&areas),
            agreement: mean(&agreements),
            tremor: assessment::statistics::quantile(&tremor, 0.5).ok(),
            rate: rate.into_iter().reduce(f64::max),
        }
    }

    /// Returns objections to offering a metric for rubrics, in words; may be empty.
    pub fn found(&self) -> String {
        let apart = match self.separation {
            Some(area) if area.high < CHANCE => Some("wrong way"),
            Some(area) if area.low <= CHANCE => Some("not told apart"),
            Some(_) => None,
            None => Some("never differs"),
        };
        let disagrees = self.agreement.is_some_and(|icc| icc.value < least_agreement());
        let found: Vec<&str> = apart.into_iter().chain(disagrees.then_some("does not agree")).collect();
        found.join(", ")
    }
}

/// Area under the curve of a random guess.
const CHANCE: f64 = 0.5;
/// Smallest agreement that is considered fair (Cicchetti 1994, Guidelines, criteria, and rules of
/// thumb for evaluating normed and standardized assessment instruments in psychology).
pub const FAIR: f64 = 0.40;
/// Number of attempts on which a judgement is based, as in the shipped course (`passes = 3, of =
/// 5`).
pub const JUDGED_BY: f64 = 5.0;

/// Returns the smallest ICC of single attempts for which the means of [`JUDGED_BY`] attempts have
/// fair agreement (Spearman and Brown).
pub fn least_agreement() -> f64 {
    FAIR / (JUDGED_BY - (JUDGED_BY - 1.0) * FAIR)
}

/// Metrics of what must or must not happen. Their relevance is decided by the rubric's author and
/// cannot be shown by comparing groups: virtual hands neither forget to confirm nor puncture twice,
/// the patient's tissue sets the force at which a boundary ruptures, and a needle that errs away
/// from a structure has more clearance than one on the planned line.
pub const BY_CONTENT: [&str; 8] = [
    "rupture_force_n",
    "skin_entries",
    "redirections",
    "structure_hits",
    "structure_clearance_mm",
    "reached",
    "confirmed",
    "withdrawn",
];

fn pooled(area: Estimate) -> Pooled {
    Pooled { value: area.value, low: area.low, high: area.high }
}

/// Returns the mean of independent figures; the distances of its ends are combined as independent
/// errors.
fn mean(figures: &[Pooled]) -> Option<Pooled> {
    let count = figures.len() as f64;
    let average = |of: &dyn Fn(&Pooled) -> f64| figures.iter().map(of).sum::<f64>() / count;
    let together = |of: &dyn Fn(&Pooled) -> f64| average(&|p| of(p) * of(p)).sqrt() / count.sqrt();
    let value = average(&|p| p.value);
    (!figures.is_empty()).then(|| Pooled {
        value,
        low: value - together(&|p| p.value - p.low),
        high: value + together(&|p| p.high - p.value),
    })
}
