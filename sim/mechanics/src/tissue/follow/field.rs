//! The field of an attempt: unit responses by the planner's choice of model, and the follower.

use super::responses::Responses;
use super::spec::TissueSpec;
use super::state::FollowParams;
use crate::axial::ParamError;
use crate::tissue::planner::{PlanError, Wish, plan};
use crate::tissue::volumetric::Problem3;
use crate::tissue::{FieldModel, Problem};

/// Rate of the field, in Hz (physics section 5).
pub const FIELD_HZ: u32 = 120;

/// Why a tissue cannot be followed.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum FollowError {
    /// A number of the tissue is out of range.
    #[error(transparent)]
    Param(#[from] ParamError),
    /// The planner refuses.
    #[error(transparent)]
    Plan(#[from] PlanError),
}

/// A tissue that follows the needle, ready for an attempt.
#[derive(Clone, Debug, PartialEq)]
pub struct Field {
    follow: FollowParams,
    on_axis: Responses,
}

impl Field {
    /// Computes what 1 N at each place does at every boundary on the axis, by the model that the planner chooses.
    ///
    /// # Errors
    /// When the tissue makes no sense or no model can be had.
    pub fn new(tissue: &TissueSpec) -> Result<Self, FollowError> {
        let on_axis = Responses::at_boundaries(tissue, &mut |problem| tissue.model(problem))?;
        Ok(Self { follow: FollowParams::new(tissue)?, on_axis })
    }

    /// What the follower needs to know.
    #[must_use]
    pub fn follow(&self) -> &FollowParams {
        &self.follow
    }

    /// Responses on the axis at every boundary.
    #[must_use]
    pub fn on_axis(&self) -> &Responses {
        &self.on_axis
    }
}

impl TissueSpec {
    /// The stiffness of each boundary by the model that the planner chooses, in N/m: what a coupled law uses.
    ///
    /// # Errors
    /// When the tissue makes no sense or no model can be had.
    pub fn planned_stiffnesses_n_per_m(&self) -> Result<Vec<f64>, FollowError> {
        self.stiffnesses_n_per_m(&mut |problem| self.model(problem))
    }

    fn model(&self, problem: &Problem) -> Result<Box<dyn FieldModel>, FollowError> {
        Ok(plan(&Problem3::flat(problem), &Wish { model: self.model, tolerance: self.tolerance })?.field)
    }
}
