//! The metric ids that rubrics and hard fails may name: a typo is refused, not silently never scored.

use phrase::{Phrase, phrase};

use crate::model::Scene;

/// What follows a metric's id.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Suffix {
    /// Nothing: `depth_error_mm`.
    None,
    /// A layer: `peak_force_layer_n.skin`.
    Layer,
    /// Nothing for the total, or a layer: `cutting_energy_mj`, `cutting_energy_mj.fat`.
    TotalOrLayer,
    /// Nothing for the largest, or a layer, whose upper boundary is meant, and the contactor: `stop_time_s.skin.rim`.
    LargestOrRupture,
    /// Nothing for all but targets, or a kind of structure: `structure_hits`, `structure_hits.vessel`.
    TotalOrKind,
    /// The name of a structure: `structure_clearance_mm.artery`.
    Structure,
}

/// A metric of the catalogue, as documents may name it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct KnownMetric {
    /// Its id.
    pub id: &'static str,
    /// What follows the id.
    pub suffix: Suffix,
    /// Its newest version; all from 1 on may be named.
    pub newest: u32,
}

const fn known(id: &'static str, suffix: Suffix) -> KnownMetric {
    KnownMetric { id, suffix, newest: 1 }
}

impl KnownMetric {
    const fn in_two_versions(self) -> Self {
        Self { newest: 2, ..self }
    }
}

/// Every metric id of the catalogue, what follows it, and its versions.
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
    known("structure_hits", Suffix::TotalOrKind),
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
];

const KINDS: [&str; 5] = ["target", "vessel", "nerve", "bone", "organ"];

/// The newest version of a metric, plain or split; 1 for what is none.
pub(crate) fn newest_version(metric: &str) -> u32 {
    let id = metric.split_once('.').map_or(metric, |(id, _)| id);
    METRICS.iter().find(|known| known.id == id).map_or(1, |known| known.newest)
}

/// What is allowed in place of `metric` in this scene, in words; nothing if it is a metric.
pub(crate) fn refusal(metric: &str, scene: &Scene) -> Option<Phrase> {
    let (id, rest) = metric.split_once('.').map_or((metric, None), |(id, rest)| (id, Some(rest)));
    let Some(&KnownMetric { suffix, .. }) = METRICS.iter().find(|known| known.id == id) else {
        let known: Vec<_> = METRICS.iter().map(|known| known.id).collect();
        return Some(phrase!("not a metric; allowed: {known}", known = known.join(", ")));
    };
    let endings = endings(suffix, scene);
    let stands_alone = !matches!(suffix, Suffix::Layer | Suffix::Structure);
    match rest {
        None if stands_alone => None,
        Some(rest) if endings.iter().any(|e| e == rest) => None,
        _ => {
            let alone = stands_alone.then(|| id.to_owned());
            let allowed: Vec<_> = alone.into_iter().chain(endings.iter().map(|e| format!("{id}.{e}"))).collect();
            Some(match allowed.len() {
                0 => phrase!("the scene has nothing that {id} could speak of", id = id),
                _ => phrase!("allowed in this scene: {known}", known = allowed.join(", ")),
            })
        }
    }
}

fn endings(suffix: Suffix, scene: &Scene) -> Vec<String> {
    let layers = scene.layers.iter().map(|l| l.name.clone());
    match suffix {
        Suffix::None => Vec::new(),
        Suffix::Layer | Suffix::TotalOrLayer => layers.collect(),
        Suffix::LargestOrRupture => {
            let contactors: &[&str] = if scene.needle.tip_to_rim_mm > 0.0 { &["tip", "rim"] } else { &["tip"] };
            layers.flat_map(|l| contactors.iter().map(move |c| format!("{l}.{c}"))).collect()
        }
        Suffix::TotalOrKind => KINDS.map(String::from).to_vec(),
        Suffix::Structure => scene.structures.iter().map(|s| s.spec.name.clone()).collect(),
    }
}
