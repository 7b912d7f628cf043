//! Requirements that an attempt must meet to earn any marks.

use documents::{Exercise, Required};
use serde::{Deserialize, Serialize};

use crate::catalogue::{Metric, find_metric, first_version, is_untouched};

/// A requirement that was not met.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum UnmetRequirement {
    /// The layer's upper boundary was not opened by the tip.
    Reached,
    /// The position is too far from the target, or missing.
    Within,
    /// The position was not confirmed in the body.
    Confirmed,
    /// The needle was in the body at the end, or was never in the body.
    Withdrawn,
}

impl UnmetRequirement {
    /// Every requirement.
    pub const ALL: [Self; 4] = [Self::Reached, Self::Within, Self::Confirmed, Self::Withdrawn];

    /// Returns the reason why a line earned nothing, in words.
    #[must_use]
    pub fn words(self) -> &'static str {
        match self {
            Self::Reached => "the needle did not reach the required layer",
            Self::Within => "the position is too far from the target",
            Self::Confirmed => "the position was not confirmed",
            Self::Withdrawn => "the needle was not withdrawn",
        }
    }

    /// Returns the reason why the attempt failed, in words.
    #[must_use]
    pub fn failure_words(self) -> &'static str {
        match self {
            Self::Reached => "No points: the needle did not reach the required layer.",
            Self::Within => "No points: the position is too far from the target.",
            Self::Confirmed => "No points: the position was not confirmed.",
            Self::Withdrawn => "No points: the needle was not withdrawn.",
        }
    }
}

/// A position and its allowed distance from the target.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DepthMiss {
    /// Distance from the target, in mm; positive beyond it.
    pub error_mm: f64,
    /// Allowed distance, in mm.
    pub allowed_mm: f64,
}

impl DepthMiss {
    /// Metric of the distance.
    pub const METRIC: &str = "depth_error_mm";

    /// Returns the distances of a judged attempt; `None` if the exercise allows any, or the attempt
    /// has no position.
    #[must_use]
    pub fn find(metrics: &[Metric], exercise: &Exercise) -> Option<Self> {
        let allowed_mm = exercise.required.as_ref()?.within_mm?;
        let error = metrics.iter().find(|metric| metric.id == Self::METRIC && metric.version == first_version())?;
        Some(Self { error_mm: error.value?, allowed_mm })
    }
}

/// A requirement as a metric and the allowed range of its magnitude.
struct Demand {
    unmet: UnmetRequirement,
    metric: String,
    /// Smallest magnitude that meets it.
    least: f64,
    /// Largest magnitude that meets it.
    most: f64,
}

fn list_demands(required: &Required) -> impl Iterator<Item = Demand> {
    let demand = |unmet, metric: &str| Demand { unmet, metric: metric.to_owned(), least: 1.0, most: f64::INFINITY };
    let reached = required.reached.as_ref().map(|layer| demand(UnmetRequirement::Reached, &format!("reached.{layer}")));
    let within = required.within_mm.map(|most| Demand {
        least: 0.0,
        most,
        ..demand(UnmetRequirement::Within, "depth_error_mm")
    });
    let confirmed = required.confirmed.then(|| demand(UnmetRequirement::Confirmed, "confirmed"));
    let withdrawn = required.withdrawn.then(|| demand(UnmetRequirement::Withdrawn, "withdrawn"));
    [reached, within, confirmed, withdrawn].into_iter().flatten()
}

/// Returns the metrics, each in its first version, that the requirements refer to.
pub(crate) fn required_metrics(exercise: &Exercise) -> impl Iterator<Item = String> {
    exercise.required.iter().flat_map(list_demands).map(|demand| demand.metric)
}

/// Returns the requirements that were not met; none if the needle never touched the skin, which is
/// a sufficient reason by itself.
pub(crate) fn find_unmet(exercise: &Exercise, metrics: &[Metric]) -> Vec<UnmetRequirement> {
    let is_met = |Demand { metric, least, most, .. }: &Demand| {
        let size = find_metric(metrics, metric, first_version()).and_then(|found| found.value).map(f64::abs);
        size.is_some_and(|size| (*least..=*most).contains(&size))
    };
    let required = exercise.required.iter().filter(|_| !is_untouched(metrics));
    required.flat_map(list_demands).filter(|demand| !is_met(demand)).map(|demand| demand.unmet).collect()
}
