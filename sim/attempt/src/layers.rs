//! The layers' positions along the needle.

use documents::ExerciseBundle;
use recording::Recording;
use serde::{Deserialize, Serialize};

use crate::insertion::deepest_insertion;

/// A layer as the needle crosses it, at rest, along the needle's axis.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct LayerSpan {
    /// The layer's name.
    pub name: String,
    /// The layer's texture, which determines its colour.
    pub texture: String,
    /// Its beginning, in mm along the needle.
    pub top_mm: f64,
    /// Its end, in mm along the needle.
    pub bottom_mm: f64,
}

/// Returns the thickness of each layer of the patient along the surface normal, in m: the recorded
/// one, or the scene's own if the recording has no valid one.
#[must_use]
pub fn patient_thicknesses_m(recording: &Recording, bundle: &ExerciseBundle) -> Vec<f64> {
    let drawn = &recording.session.patient_thickness_mm;
    let layers = &bundle.scene.layers;
    let fits = drawn.len() == layers.len() && drawn.iter().all(|mm| mm.is_finite() && *mm >= 0.0);
    if fits {
        drawn.iter().map(|mm| mm * 1e-3).collect()
    } else {
        layers.iter().map(|layer| layer.thickness_mm * 1e-3).collect()
    }
}

/// Returns the depth of every boundary below the skin, straight down, in m, for layers of given
/// thickness from the skin down, in m.
pub(crate) fn tops_of_layers_m(thicknesses_m: impl IntoIterator<Item = f64>) -> Vec<f64> {
    let top_m = |depth_m: &mut f64, thickness_m: f64| Some(std::mem::replace(depth_m, *depth_m + thickness_m));
    thicknesses_m.into_iter().scan(0.0, top_m).collect()
}

/// Returns the position of each layer along the needle of the deepest insertion, from the skin
/// down, by the axis that the law latched at its contact; along the planned one if the needle never
/// met the skin.
#[must_use]
pub fn span_layers(recording: &Recording, bundle: &ExerciseBundle) -> Vec<LayerSpan> {
    let skin = &bundle.scene.skin_shape;
    let planned = || bundle.exercise.incidence();
    let incidence = deepest_insertion(recording).map_or_else(planned, |(insertion, _)| insertion.incidence(skin));
    let mut boundaries_m = Vec::new();
    incidence.lay_layers(patient_thicknesses_m(recording, bundle), &mut boundaries_m);
    let spans = bundle.scene.layers.iter().zip(boundaries_m.windows(2)).map(|(layer, ends_m)| {
        let (name, texture) = (layer.name.clone(), layer.texture.clone());
        LayerSpan { name, texture, top_mm: ends_m[0] * 1e3, bottom_mm: ends_m[1] * 1e3 }
    });
    spans.collect()
}
