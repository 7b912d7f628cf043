//! A patient drawn from a scene's spread.

use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};

use crate::model::{Scene, SceneLayer};

/// The thicknesses drawn for a patient; stored in the recording.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Patient {
    /// Thickness of each layer, in mm, from the surface down.
    pub thickness_mm: Vec<f64>,
}

impl Patient {
    /// Returns the scene's nominal patient.
    #[must_use]
    pub fn nominal(scene: &Scene) -> Self {
        Self::at(scene, |_| 0.0)
    }

    /// Draws the patient of a seed: each layer uniform within its spread, never negative.
    ///
    /// A layer's draw depends only on the seed and the layer's name: adding, moving or editing
    /// another layer does not change it, as a single generator shared by all layers would.
    #[must_use]
    pub fn draw(scene: &Scene, seed: u64) -> Self {
        Self::at(scene, |layer| 2.0 * uniform(seed, &layer.name) - 1.0)
    }

    /// Returns the patients at the ends of the spread: every layer at its thinnest, every layer at
    /// its thickest.
    #[must_use]
    pub fn extremes(scene: &Scene) -> [Self; 2] {
        [Self::at(scene, |_| -1.0), Self::at(scene, |_| 1.0)]
    }

    fn at(scene: &Scene, within: impl Fn(&SceneLayer) -> f64) -> Self {
        let thickness = |l: &SceneLayer| (l.thickness_mm + l.thickness_spread_mm * within(l)).max(0.0);
        Self { thickness_mm: scene.layers.iter().map(thickness).collect() }
    }
}

/// Returns a number 0 ≤ u < 1 for a seed and a name.
fn uniform(seed: u64, name: &str) -> f64 {
    let digest = Sha256::new().chain_update(seed.to_le_bytes()).chain_update(name).finalize();
    let bits = digest.iter().take(8).fold(0, |bits: u64, byte| bits << 8 | u64::from(*byte));
    // The upper 53 bits fill a significand exactly.
    (bits >> 11) as f64 / (1_u64 << 53) as f64
}
