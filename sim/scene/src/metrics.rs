//! The metric ids that rubrics and hard fails may name: a typo is refused, not silently never scored.

use mechanics::phrase;
use mechanics::phrase::Phrase;

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

/// Every metric id of the catalogue, version 1, and what follows it.
pub const METRICS: &[(&str, Suffix)] = &[
    ("depth_error_mm", Suffix::None),
    ("overshoot_mm", Suffix::None),
    ("tip_error_mm", Suffix::None),
    ("entry_error_mm", Suffix::None),
    ("angle_error_deg", Suffix::None),
    ("peak_force_n", Suffix::None),
    ("peak_force_layer_n", Suffix::Layer),
    ("rupture_force_n", Suffix::LargestOrRupture),
    ("over_insertion_mm", Suffix::LargestOrRupture),
    ("stop_time_s", Suffix::LargestOrRupture),
    ("force_impulse_ns", Suffix::None),
    ("force_rate_peak_n_per_s", Suffix::None),
    ("rupture_energy_mj", Suffix::TotalOrLayer),
    ("cutting_energy_mj", Suffix::TotalOrLayer),
    ("friction_energy_mj", Suffix::TotalOrLayer),
    ("lateral_work_mj", Suffix::TotalOrLayer),
    ("lateral_peak_n", Suffix::None),
    ("sweep_area_mm2", Suffix::None),
    ("skin_entries", Suffix::None),
    ("redirections", Suffix::None),
    ("structure_hits", Suffix::TotalOrKind),
    ("structure_clearance_mm", Suffix::Structure),
    ("time_total_s", Suffix::None),
    ("time_in_tissue_s", Suffix::None),
    ("path_length_mm", Suffix::None),
    ("path_in_tissue_mm", Suffix::None),
    ("axis_travel_mm", Suffix::None),
    ("path_deviation_sd_mm", Suffix::None),
    ("smoothness_ldlj", Suffix::None),
    ("idle_fraction", Suffix::None),
    ("translational_actions", Suffix::None),
    ("rotational_actions", Suffix::None),
];

const KINDS: [&str; 5] = ["target", "vessel", "nerve", "bone", "organ"];

/// What is allowed in place of `metric` in this scene, in words; nothing if it is a metric.
pub(crate) fn refusal(metric: &str, scene: &Scene) -> Option<Phrase> {
    let (id, rest) = metric.split_once('.').map_or((metric, None), |(id, rest)| (id, Some(rest)));
    let Some(&(_, suffix)) = METRICS.iter().find(|(known, _)| *known == id) else {
        let known: Vec<_> = METRICS.iter().map(|(id, _)| *id).collect();
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
