//! The metric catalogue, version 1.

use serde::{Deserialize, Serialize};

/// Which way is better.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Direction {
    /// Lower is better.
    Lower,
    /// Higher is better.
    Higher,
    /// Near 0 is better, either side.
    Range,
}

/// A metric's value in one attempt.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Metric {
    /// Id, for example `depth_error_mm` or `peak_force_layer_n.skin`.
    pub id: String,
    /// Version of the definition.
    pub version: u32,
    /// Value; absent outside the metric's domain.
    pub value: Option<f64>,
    /// Unit.
    pub unit: String,
    /// Which way is better.
    pub direction: Direction,
    /// The metric applies to this attempt.
    pub applies: bool,
    /// Name in words, for people.
    #[serde(default)]
    pub label: String,
}
