//! The energy ledger: where the work of the hand went, layer by layer.

use serde::{Deserialize, Serialize};

/// Cumulative energies of one layer, in J. All but `elastic_j` never decrease.
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
    /// Lateral work ∫|F⊥||dδ⊥|, in J. A measure of damage, beside the axial balance.
    pub lateral_j: f64,
}

/// The whole ledger.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Ledger {
    /// Positive axial work of the hand, in J.
    pub input_j: f64,
    /// Axial work given back to the hand, in J, as a positive number.
    pub returned_j: f64,
    /// Energy stored now by the presliding spring, in J.
    pub presliding_j: f64,
    /// One entry per layer, from the surface down.
    pub layers: Vec<LayerEnergy>,
}
