//! The metric catalogue: for each version of each metric its definition, domain, favourable
//! direction, and whether a rubric should use it.
//!
//! A changed definition is added as a new version. All versions are computed for every attempt, and
//! a rubric line states which one it uses; a line without a version uses the first, because it was
//! written when there was no other.

mod table;

use documents::name_structure;
use phrase::{Phrase, phrase};
use recording::Contactor;
use serde::{Deserialize, Serialize};
pub use table::DEFINITIONS;

use crate::absent::Absent;

/// The favourable direction of a metric.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Direction {
    /// Lower is better.
    Lower,
    /// Higher is better.
    Higher,
    /// Values near 0 are better, on either side.
    Range,
}

/// A metric's value in one attempt.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Metric {
    /// Id, for example `depth_error_mm` or `peak_force_layer_n.skin`.
    pub id: String,
    /// Version of the definition.
    pub version: u32,
    /// Value in `unit`; absent outside the metric's domain, and never NaN or infinite.
    pub value: Option<f64>,
    /// Unit; `count` for a count, `1` for a dimensionless number.
    pub unit: String,
    /// Favourable direction.
    pub direction: Direction,
    /// Whether the metric applies to this attempt.
    pub applies: bool,
    /// Human-readable name.
    #[serde(default)]
    pub label: String,
    /// Reason why the metric does not apply, if it does not.
    #[serde(default, deserialize_with = "Absent::deserialize_field", skip_serializing_if = "Option::is_none")]
    pub absent: Option<Absent>,
}

/// The meaning of the suffix of a metric id, which follows the first full stop.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Split {
    /// `.<layer>`, a layer's name in the scene.
    Layer,
    /// `.<layer>.<tip|rim>`: the boundary at the top of a layer, and the contactor that opened it.
    Boundary,
    /// `.<kind>`: target, vessel, nerve, bone or organ.
    Kind,
    /// `.<name>`, a structure's name in the scene.
    Structure,
}

/// One row of the catalogue: the definition of a metric, also shown as help.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Definition {
    /// Id without suffix.
    pub id: &'static str,
    /// Version of the definition; a changed definition is a new version.
    pub version: u32,
    /// Unit; `count` for a count, `1` for a dimensionless number.
    pub unit: &'static str,
    /// Favourable direction.
    pub direction: Direction,
    /// Human-readable name.
    pub label: &'static str,
    /// The definition, in one sentence.
    pub definition: &'static str,
    /// Domain, in words.
    pub domain: &'static str,
    /// Advice for a trainee who lost points.
    pub advice: &'static str,
    /// Source of the definition or of the parts that were adopted; empty if it is this simulator's
    /// own.
    pub source: &'static str,
    /// Reason why no rubric should use this metric; empty if rubrics may. A rubric that uses it is
    /// evaluated nevertheless.
    pub unoffered: &'static str,
    /// Whether the id without a suffix is a metric.
    pub plain: bool,
    /// The kind of suffix, if the metric may have one.
    pub split: Option<Split>,
}

impl Definition {
    /// Returns the name of the metric with a suffix, for example `peak force in muscle`.
    #[must_use]
    pub fn label_of(&self, suffix: &str) -> String {
        self.name_part(suffix).to_string()
    }

    /// Returns the translatable name of the metric with a suffix.
    #[must_use]
    pub fn name_part(&self, suffix: &str) -> Phrase {
        let metric = Phrase::sentence(self.label);
        match (self.split, suffix.rsplit_once('.')) {
            (Some(Split::Boundary), Some((layer, contactor))) => {
                let contactor = if contactor == "rim" { Contactor::Rim } else { Contactor::Tip };
                phrase!("{metric}, {pop}", metric = metric, pop = contactor.into_layer(name_structure(layer)))
            }
            (Some(Split::Layer), _) => phrase!("{metric} in {layer}", metric = metric, layer = name_structure(suffix)),
            (Some(Split::Structure), _) => {
                phrase!("{metric} to {structure}", metric = metric, structure = name_structure(suffix))
            }
            _ => phrase!("{metric}: {part}", metric = metric, part = Phrase::Known(suffix.to_owned())),
        }
    }
}

/// Returns a version of the definition of a metric id, with or without suffix.
#[must_use]
pub fn find_definition(metric_id: &str, version: u32) -> Option<&'static Definition> {
    definition_versions(metric_id).find(|definition| definition.version == version)
}

/// Returns the newest definition of a metric id, with or without suffix. All versions share label,
/// unit and direction.
#[must_use]
pub fn newest_definition(metric_id: &str) -> Option<&'static Definition> {
    definition_versions(metric_id).max_by_key(|definition| definition.version)
}

fn definition_versions(metric_id: &str) -> impl Iterator<Item = &'static Definition> {
    let base = metric_id.split_once('.').map_or(metric_id, |(base, _)| base);
    let is_split = base.len() < metric_id.len();
    DEFINITIONS.iter().filter(move |d| d.id == base && if is_split { d.split.is_some() } else { d.plain })
}

/// Returns the default version.
pub(crate) const fn first_version() -> u32 {
    1
}

/// Finds a version of a metric, if its definition is current.
pub(crate) fn find_metric<'a>(metrics: &'a [Metric], id: &str, version: u32) -> Option<&'a Metric> {
    metrics.iter().find(|metric| metric.id == id && metric.version == version && is_current(metric))
}

/// Returns whether the attempt never touched the skin.
pub(crate) fn is_untouched(metrics: &[Metric]) -> bool {
    metrics.iter().any(|metric| metric.absent == Some(Absent::Untouched))
}

/// Returns whether the catalogue defines this version of the metric and, for a metric without
/// value, this version of the program knows the reason.
fn is_current(metric: &Metric) -> bool {
    let defined = find_definition(&metric.id, metric.version).is_some();
    defined && (metric.value.is_some() || metric.absent.is_some_and(|absent| absent != Absent::OfAnotherVersion))
}

#[cfg(test)]
mod tests {
    //! The catalogue contains the metrics of the specification; each row is unique, complete and
    //! found by its id.

    use super::*;

    #[test]
    fn every_row_is_complete_and_unique() {
        for (i, d) in DEFINITIONS.iter().enumerate() {
            assert!(d.plain || d.split.is_some(), "{} can be no metric", d.id);
            let same = |other: &&Definition| other.id == d.id;
            let before = DEFINITIONS[..i].iter().filter(same).count();
            assert_eq!(u32::try_from(before + 1), Ok(d.version), "{} lacks a version or has one twice", d.id);
            let shown = |d: &Definition| (d.label, d.unit, d.direction, d.plain, d.split);
            assert!(DEFINITIONS.iter().filter(same).all(|other| shown(other) == shown(d)), "{} has two faces", d.id);
            for words in [d.unit, d.label, d.definition, d.domain, d.advice] {
                assert!(!words.is_empty(), "{} lacks words", d.id);
            }
        }
    }

    #[test]
    fn plain_and_split_ids_are_told_apart() {
        assert_eq!(newest_definition("peak_force_n").map(|d| d.unit), Some("N"));
        assert_eq!(newest_definition("peak_force_layer_n.deep fat").map(|d| d.id), Some("peak_force_layer_n"));
        assert_eq!(newest_definition("peak_force_layer_n"), None, "only by layer");
        assert_eq!(newest_definition("peak_force_n.skin"), None, "not by layer");
        assert_eq!(newest_definition("charm"), None);
    }

    #[test]
    fn every_version_is_found_and_no_other() {
        let versions = [1, 2, 3].map(|version| find_definition("stop_time_s.skin.rim", version).map(|d| d.version));
        assert_eq!(versions, [Some(1), Some(2), None]);
        assert_eq!(newest_definition("stop_time_s").map(|d| d.version), Some(2));
    }

    #[test]
    fn split_labels_read_as_words() {
        let label = |id: &str| newest_definition(id).map(|d| d.label_of(id.split_once('.').map_or("", |(_, s)| s)));
        assert_eq!(label("peak_force_layer_n.fat").as_deref(), Some("peak force in fat"));
        assert_eq!(label("over_insertion_mm.fat.rim").as_deref(), Some("advance after the pop, rim into fat"));
        assert_eq!(label("structure_clearance_mm.left kidney").as_deref(), Some("clearance to left kidney"));
        assert_eq!(label("structure_hits.vessel").as_deref(), Some("structures hit: vessel"));
    }
}
