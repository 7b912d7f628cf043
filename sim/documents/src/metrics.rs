//! Metric ids allowed in rubrics and hard fails, so that a typo is refused instead of never being
//! scored.

use law::structures::StructureKind;
use phrase::{Phrase, phrase};

use crate::model::Scene;

/// Suffix of a metric's id.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Suffix {
    /// No suffix: `depth_error_mm`.
    None,
    /// A layer: `peak_force_layer_n.skin`.
    Layer,
    /// No suffix for the total, or a layer: `cutting_energy_mj`, `cutting_energy_mj.fat`.
    TotalOrLayer,
    /// No suffix for the largest value, or a layer (its upper boundary) and the contactor:
    /// `stop_time_s.skin.rim`.
    LargestOrRupture,
    /// No suffix for all kinds except targets, or a kind of structure: `structure_hits`,
    /// `structure_hits.vessel`.
    TotalOrKind,
    /// The name of a structure: `structure_clearance_mm.artery`.
    Structure,
}

/// A metric of the catalogue as documents refer to it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct KnownMetric {
    /// Its id.
    pub id: &'static str,
    /// Suffix.
    pub suffix: Suffix,
    /// Newest version; documents may use every version from 1 on.
    pub newest: u32,
    /// Whether it is measured only in exercises with a C-arm.
    pub needs_arm: bool,
}

const fn known(id: &'static str, suffix: Suffix) -> KnownMetric {
    KnownMetric { id, suffix, newest: 1, needs_arm: false }
}

impl KnownMetric {
    const fn in_two_versions(self) -> Self {
        Self { newest: 2, ..self }
    }

    const fn of_the_arm(self) -> Self {
        Self { needs_arm: true, ..self }
    }
}

/// Every metric id of the catalogue with its suffix and versions.
pub const METRICS: &[KnownMetric] = &[
    known("depth_error_mm", Suffix::None),
    known("overshoot_mm", Suffix::None),
    known("tip_error_mm", Suffix::None),
    known("entry_error_mm", Suffix::None),
    known("angle_error_deg", Suffix::None),
    known("peak_force_n", Suffix::None),
    known("peak_force_layer_n", Suffix::Layer),
    known("rupture_force_n", Suffix::LargestOrRupture),
    known("over_insertion_mm", Suffix::LargestOrRupture),
    known("stop_time_s", Suffix::LargestOrRupture).in_two_versions(),
    known("force_impulse_ns", Suffix::None),
    known("force_rate_peak_n_per_s", Suffix::None),
    known("rupture_energy_mj", Suffix::TotalOrLayer),
    known("cutting_energy_mj", Suffix::TotalOrLayer),
    known("friction_energy_mj", Suffix::TotalOrLayer),
    known("lateral_work_mj", Suffix::TotalOrLayer),
    known("lateral_peak_n", Suffix::None),
    known("max_lateral_force_n", Suffix::Layer),
    known("sweep_area_mm2", Suffix::None),
    known("skin_entries", Suffix::None),
    known("redirections", Suffix::None),
    known("structure_hits", Suffix::TotalOrKind).in_two_versions(),
    known("structure_clearance_mm", Suffix::Structure),
    known("time_total_s", Suffix::None),
    known("time_in_tissue_s", Suffix::None),
    known("path_length_mm", Suffix::None).in_two_versions(),
    known("path_in_tissue_mm", Suffix::None).in_two_versions(),
    known("axis_travel_mm", Suffix::None).in_two_versions(),
    known("path_deviation_sd_mm", Suffix::None),
    known("smoothness_ldlj", Suffix::None),
    known("smoothness_sparc", Suffix::None),
    known("idle_fraction", Suffix::None).in_two_versions(),
    known("translational_actions", Suffix::None).in_two_versions(),
    known("rotational_actions", Suffix::None).in_two_versions(),
    known("reached", Suffix::Layer),
    known("confirmed", Suffix::None),
    known("withdrawn", Suffix::None),
    known("fluoroscopy_time_s", Suffix::None).of_the_arm(),
    known("fluoroscopy_shots", Suffix::None).of_the_arm(),
    known("kerma_mgy", Suffix::None).of_the_arm(),
    known("kerma_area_gycm2", Suffix::None).of_the_arm(),
    known("mean_field_cm2", Suffix::None).of_the_arm(),
    known("views_before_skin", Suffix::None).of_the_arm(),
];

/// The names in a scene that metric ids may contain.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct SceneNames {
    /// Names of its layers, from the surface down.
    pub layers: Vec<String>,
    /// Names of its structures.
    pub structures: Vec<String>,
    /// Whether the needle has a rim behind its tip.
    pub has_rim: bool,
}

impl From<&Scene> for SceneNames {
    fn from(scene: &Scene) -> Self {
        Self {
            layers: scene.layers.iter().map(|layer| layer.name.clone()).collect(),
            structures: scene.structures.iter().map(|structure| structure.spec.name.clone()).collect(),
            has_rim: scene.needle.tip_to_rim_mm > 0.0,
        }
    }
}

impl SceneNames {
    /// Extracts the names from a scene that is still being written and may be invalid; returns
    /// empty lists if the text is not TOML.
    #[must_use]
    pub fn from_text(scene: &str) -> Self {
        let Ok(scene) = scene.parse::<toml::Table>() else { return Self::default() };
        let names = |key: &str| -> Vec<String> {
            let tables = scene.get(key).and_then(toml::Value::as_array).into_iter().flatten();
            tables.filter_map(|table| table.get("name")?.as_str().map(str::to_owned)).collect()
        };
        let needle = |key: &str| scene.get("needle").and_then(|needle| needle.get(key));
        let is_trocar = || needle("kind").and_then(toml::Value::as_str) != Some("needle");
        let to_rim = |value: &toml::Value| value.as_float().or_else(|| value.as_integer().map(|mm| mm as f64));
        let has_rim = needle("tip_to_rim_mm").and_then(to_rim).map_or_else(is_trocar, |mm| mm > 0.0);
        Self { layers: names("layer"), structures: names("structure"), has_rim }
    }
}

impl KnownMetric {
    /// Returns the ids of this metric in a scene.
    #[must_use]
    pub fn ids_in(&self, scene: &SceneNames) -> Vec<String> {
        let endings = endings(self.suffix, scene);
        let alone = self.stands_alone().then(|| self.id.to_owned());
        alone.into_iter().chain(endings.iter().map(|ending| format!("{}.{ending}", self.id))).collect()
    }

    const fn stands_alone(&self) -> bool {
        !matches!(self.suffix, Suffix::Layer | Suffix::Structure)
    }
}

/// Returns the newest version of a metric, with or without suffix; 1 for an unknown metric.
pub(crate) fn newest_version(metric: &str) -> u32 {
    let id = metric.split_once('.').map_or(metric, |(id, _)| id);
    METRICS.iter().find(|known| known.id == id).map_or(1, |known| known.newest)
}

/// Describes the ids allowed in place of `metric` in this scene; `None` if `metric` is valid.
pub(crate) fn refusal(metric: &str, scene: &Scene) -> Option<Phrase> {
    let (id, rest) = metric.split_once('.').map_or((metric, None), |(id, rest)| (id, Some(rest)));
    let Some(known) = METRICS.iter().find(|known| known.id == id) else {
        let known: Vec<_> = METRICS.iter().map(|known| known.id).collect();
        return Some(phrase!("not a metric; allowed: {known}", known = known.join(", ")));
    };
    if rest.is_none() && known.stands_alone() {
        return None;
    }
    let allowed = known.ids_in(&SceneNames::from(scene));
    if allowed.iter().any(|allowed| allowed == metric) {
        return None;
    }
    Some(match allowed.len() {
        0 => phrase!("the scene has nothing that {id} could refer to", id = id),
        _ => phrase!("allowed in this scene: {known}", known = allowed.join(", ")),
    })
}

fn endings(suffix: Suffix, scene: &SceneNames) -> Vec<String> {
    let layers = scene.layers.iter().cloned();
    match suffix {
        Suffix::None => Vec::new(),
        Suffix::Layer | Suffix::TotalOrLayer => layers.collect(),
        Suffix::LargestOrRupture => {
            let contactors: &[&str] = if scene.has_rim { &["tip", "rim"] } else { &["tip"] };
            layers.flat_map(|l| contactors.iter().map(move |c| format!("{l}.{c}"))).collect()
        }
        Suffix::TotalOrKind => StructureKind::WORDS.map(String::from).to_vec(),
        Suffix::Structure => scene.structures.clone(),
    }
}
