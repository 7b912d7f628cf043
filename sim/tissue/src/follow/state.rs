//! One step of the field's loads.

use law::axial::ParamError;
use serde::{Deserialize, Serialize};

use super::spec::TissueSpec;

/// What a follower needs to know, constant for an attempt.
#[derive(Clone, Debug, PartialEq)]
pub struct FollowParams {
    /// Recoil time of each boundary's layer, in s.
    recoil_time_s: Vec<f64>,
}

/// The loads that the field carries: all that must be saved to continue.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct FollowState {
    /// Contactors at each boundary, then drag along each layer, in N, positive into the body.
    pub loads_n: Vec<f64>,
}

impl FollowParams {
    /// The follower of a tissue.
    ///
    /// # Errors
    /// When the tissue makes no sense.
    pub fn new(tissue: &TissueSpec) -> Result<Self, ParamError> {
        tissue.check()?;
        Ok(Self { recoil_time_s: tissue.recoil_time_s.clone() })
    }
}

impl FollowState {
    /// Tissue that nothing touches.
    #[must_use]
    pub fn new(params: &FollowParams) -> Self {
        Self { loads_n: vec![0.0; 2 * params.recoil_time_s.len()] }
    }

    /// Force that the field carries, in N.
    #[must_use]
    pub fn total_n(&self) -> f64 {
        self.loads_n.iter().sum()
    }
}

/// Advances by `dt_s` to the latest loads of the force law, in N. Never allocates and never fails: no time passes in a step that
/// is backwards or no number, and a load that is no number is held.
///
/// A contactor's load is max(latest, load·exp(−dt/τ)), so that steps of any size agree: two of dt/2 make one of dt.
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
