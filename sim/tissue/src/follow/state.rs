//! One step of the field's loads.

use law::axial::ParamError;
use serde::{Deserialize, Serialize};

use super::spec::TissueSpec;

/// Parameters of the follower, constant for an attempt.
#[derive(Clone, Debug, PartialEq)]
pub struct FollowParams {
    /// Recoil time of each boundary's layer, in s.
    recoil_time_s: Vec<f64>,
}

/// The loads that the field bears: the complete state, sufficient to continue.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct FollowState {
    /// Contactors at each boundary, then drag along each layer, in N, positive into the body.
    pub loads_n: Vec<f64>,
}

impl FollowParams {
    /// The parameters for a tissue.
    ///
    /// # Errors
    /// If the tissue is invalid.
    pub fn new(tissue: &TissueSpec) -> Result<Self, ParamError> {
        tissue.check()?;
        Ok(Self { recoil_time_s: tissue.recoil_time_s.clone() })
    }
}

impl FollowState {
    /// The state of untouched tissue.
    #[must_use]
    pub fn new(params: &FollowParams) -> Self {
        Self { loads_n: vec![0.0; 2 * params.recoil_time_s.len()] }
    }

    /// Total force that the field bears, in N.
    #[must_use]
    pub fn total_n(&self) -> f64 {
        self.loads_n.iter().sum()
    }
}

/// Advances by `dt_s` to the latest loads of the force law, in N. Never allocates and never fails:
/// a negative or NaN time step counts as zero, and a load that is not finite keeps its last value.
///
/// A contactor's load is max(latest, load·exp(−dt/τ)), so that steps of any size agree: two of dt/2
/// make one of dt.
pub fn step(params: &FollowParams, state: &mut FollowState, dt_s: f64, latest_n: &[f64]) {
    let passed_s = if dt_s > 0.0 { dt_s } else { 0.0 };
    let layers = params.recoil_time_s.len();
    for (at, (load_n, &latest_n)) in state.loads_n.iter_mut().zip(latest_n).enumerate() {
        if latest_n.is_finite() {
            let left_n = params.recoil_time_s.get(at).map_or(latest_n, |tau_s| *load_n * libm::exp(-passed_s / tau_s));
            *load_n = if at < layers { latest_n.max(left_n) } else { latest_n };
        }
    }
}
