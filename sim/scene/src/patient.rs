//! A patient drawn from a scene's spread.

use serde::{Deserialize, Serialize};

use crate::model::Scene;

/// What was drawn: kept in the recording.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Patient {
    /// Thickness of each layer, in mm, from the surface down.
    pub thickness_mm: Vec<f64>,
}

impl Patient {
    /// The scene's nominal patient.
    #[must_use]
    pub fn nominal(scene: &Scene) -> Self {
        Self { thickness_mm: scene.layers.iter().map(|l| l.thickness_mm).collect() }
    }

    /// The patient of a seed: each layer uniform within its spread, never negative.
    #[must_use]
    pub fn draw(_scene: &Scene, _seed: u64) -> Self {
        unimplemented!()
    }
}
