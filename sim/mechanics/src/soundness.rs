//! Sound scenes: no rupture of a monotonic insertion may raise the elastic energy or the force.

use crate::axial::{AxialSpec, Contactor};

/// A threshold too high for its stiffness: its rupture would create energy or force.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("boundary {boundary} ({layer}): the {} rupture at {threshold_n} N raises the force by {force_rise_n} N and the elastic energy by {energy_rise_mj} mJ; the largest sound threshold is {largest_sound_n} N", match .contactor { Contactor::Tip => "tip", Contactor::Rim => "rim" })]
pub struct Unsound {
    /// Which boundary, from 0.
    pub boundary: usize,
    /// Its layer's name.
    pub layer: String,
    /// Which contactor's threshold.
    pub contactor: Contactor,
    /// The threshold, in N.
    pub threshold_n: f64,
    /// Rise of the force over the whole cascade, in N (0 when it falls).
    pub force_rise_n: f64,
    /// Rise of the elastic energy over the whole cascade, in mJ (0 when it falls).
    pub energy_rise_mj: f64,
    /// The largest threshold of this contactor and boundary that would be sound, others unchanged, in N.
    pub largest_sound_n: f64,
}

/// Every unsound rupture of a scene, in the order met; empty for a sound scene.
#[must_use]
pub fn check(_spec: &AxialSpec) -> Vec<Unsound> {
    unimplemented!()
}
