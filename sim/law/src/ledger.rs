//! The energy ledger: a balance of the hand's work, layer by layer.

use serde::{Deserialize, Serialize};

/// Cumulative energies of one layer, in J. All but `elastic_j` never decrease; `viscous_j` may, by
/// the amount counted in [`Ledger::lagged_j`].
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct LayerEnergy {
    /// Elastic energy stored now by this layer's boundary, in J.
    pub elastic_j: f64,
    /// Dissipated by ruptures of this layer's boundary, in J.
    pub rupture_j: f64,
    /// Dissipated by viscosity, in J.
    pub viscous_j: f64,
    /// Dissipated by friction, in J.
    pub friction_j: f64,
    /// Dissipated by cutting, in J.
    pub cutting_j: f64,
    /// Lateral work ∫|F⊥||dδ⊥|, in J. A measure of damage, separate from the axial balance.
    pub lateral_j: f64,
}

/// The complete ledger.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Ledger {
    /// Positive axial work of the hand, in J.
    pub input_j: f64,
    /// Axial work returned to the hand, in J, as a positive number.
    pub returned_j: f64,
    /// Energy stored now by the springs along the shaft, in J: those of friction and cutting before
    /// they slide and, from version 5 of the law, that of damping.
    pub presliding_j: f64,
    /// Energy returned by viscosity because speed lags by half of its window, in J, as a positive
    /// number: already subtracted from the layers' `viscous_j`. 0 without a window, and from
    /// version 5 of the law.
    #[serde(default)]
    pub lagged_j: f64,
    /// One entry per layer, from the surface down.
    pub layers: Vec<LayerEnergy>,
}

impl LayerEnergy {
    /// Total energy that this layer dissipated on the needle's axis, in J.
    #[must_use]
    pub fn dissipated_j(&self) -> f64 {
        self.rupture_j + self.viscous_j + self.friction_j + self.cutting_j
    }
}

impl Ledger {
    /// An empty ledger.
    #[must_use]
    pub fn new(layers: usize) -> Self {
        Self { layers: vec![LayerEnergy::default(); layers], ..Self::default() }
    }

    /// Elastic energy stored now by all boundaries, in J.
    #[must_use]
    pub fn elastic_j(&self) -> f64 {
        self.layers.iter().map(|layer| layer.elastic_j).sum()
    }

    /// Total energy dissipated on the needle's axis, in J. Never decreases.
    #[must_use]
    pub fn dissipated_j(&self) -> f64 {
        self.layers.iter().map(LayerEnergy::dissipated_j).sum()
    }

    /// Lateral work, in J.
    #[must_use]
    pub fn lateral_j(&self) -> f64 {
        self.layers.iter().map(|layer| layer.lateral_j).sum()
    }

    /// Error of the balance, in J: input − returned − stored − dissipated; 0 for a closed ledger.
    #[must_use]
    pub fn closure_error_j(&self) -> f64 {
        self.input_j - self.returned_j - self.elastic_j() - self.presliding_j - self.dissipated_j()
    }
}
