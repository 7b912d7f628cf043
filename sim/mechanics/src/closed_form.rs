//! Closed forms of physics that the tests and the documents quote: rupture positions and forces of a monotonic insertion.

use crate::axial::{AxialSpec, Contactor};

/// A rupture predicted in closed form.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PredictedRupture {
    /// Which contactor.
    pub contactor: Contactor,
    /// Which boundary, from 0 at the surface.
    pub boundary: usize,
    /// Axial displacement of the tip at the rupture, in m.
    pub x_m: f64,
    /// Elastic force on the hand just before, in N.
    pub force_before_n: f64,
    /// Elastic force on the hand just after the whole cascade at this position, in N.
    pub force_after_n: f64,
    /// Elastic energy before, in J.
    pub energy_before_j: f64,
    /// Elastic energy after the whole cascade, in J.
    pub energy_after_j: f64,
}

/// Ruptures of a slow monotonic insertion, in order.
#[must_use]
pub fn ruptures(_spec: &AxialSpec) -> Vec<PredictedRupture> {
    unimplemented!()
}
