//! The field of an attempt: unit responses by the planner's choice of model, and the follower.

use super::responses::Responses;
use super::spec::TissueSpec;
use super::state::FollowParams;
use crate::axial::{AxialSpec, ParamError};
use crate::phrase::Phrase;
use crate::tissue::planner::{self, PlanError, Planned, Reach, Wish, patch, reach};
use crate::tissue::volumetric::Problem3;
use crate::tissue::{Load, LoadKind, Model, Problem};

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

impl FollowError {
    /// What is wrong, for people.
    #[must_use]
    pub fn in_words(&self) -> Phrase {
        match self {
            Self::Param(error) => Phrase::data(error),
            Self::Plan(error) => error.in_words(),
        }
    }
}

/// What the field of a tissue is computed with.
#[derive(Clone, Debug, PartialEq)]
pub struct FieldPlan {
    /// The model.
    pub model: Model,
    /// Why this one, and its mesh under the load that is worst off.
    pub reason: Phrase,
    /// How far the tissue is modelled around the needle, in m.
    pub radius_m: f64,
    /// Unknowns of the largest load's model.
    pub unknowns: usize,
    /// Most bytes held at a time: the largest load's model, which is let go when it has answered, and the responses.
    pub bytes: usize,
    /// Expected relative error of the displacement on the needle: of the mesh and of the patch, the worst load's.
    pub expected_relative_error: f64,
}

/// A tissue that follows the needle, ready for an attempt.
#[derive(Clone, Debug, PartialEq)]
pub struct Field {
    follow: FollowParams,
    on_axis: Responses,
    plan: FieldPlan,
}

impl Field {
    /// Computes what 1 N along the needle at each place does at every boundary it meets, by the model that the planner chooses, on a patch
    /// no larger than the needle's influence. Mesh and patch share the tolerance.
    ///
    /// # Errors
    /// When the tissue makes no sense or no model can be had.
    pub fn new(tissue: &TissueSpec) -> Result<Self, FollowError> {
        tissue.check()?;
        let share = 0.5 * tissue.tolerance;
        let body = &tissue.slab;
        let Reach { radius_m, relative_change } = reach(&tissue.at_the_skin(), share).map_err(PlanError::from)?;
        let radius_m = radius_m.min(body.radius_m);
        let deepest_m = tissue.boundaries_m.iter().copied().fold(0.0, f64::max);
        let patched = TissueSpec { slab: patch(&body.layers, deepest_m, radius_m), ..tissue.clone() };
        let wish = Wish { model: tissue.model, tolerance: share };
        let mut plan = FieldPlan {
            model: Model::None,
            reason: Phrase::Data(String::new()),
            radius_m,
            unknowns: 0,
            bytes: 0,
            expected_relative_error: f64::NEG_INFINITY,
        };
        let on_axis = Responses::at_boundaries(&patched, &mut |question| {
            let planned = planner::plan(question, &wish)?;
            plan.take(&planned);
            Ok::<_, FollowError>(planned.field)
        })?;
        plan.bytes += on_axis.bytes();
        plan.expected_relative_error += relative_change;
        Ok(Self { follow: FollowParams::new(tissue)?, on_axis, plan })
    }

    /// What the follower needs to know.
    #[must_use]
    pub fn follow(&self) -> &FollowParams {
        &self.follow
    }

    /// Responses on the needle at every boundary.
    #[must_use]
    pub fn on_axis(&self) -> &Responses {
        &self.on_axis
    }

    /// What it was computed with.
    #[must_use]
    pub fn plan(&self) -> &FieldPlan {
        &self.plan
    }

    /// Gives every boundary of a law the field's stiffness.
    pub fn couple(&self, axial: &mut AxialSpec) {
        for (layer, stiffness_n_per_m) in axial.layers.iter_mut().zip(self.on_axis.stiffnesses_n_per_m()) {
            layer.stiffness_n_per_m = stiffness_n_per_m;
        }
    }
}

impl FieldPlan {
    /// Takes the model of one more load into account.
    fn take(&mut self, planned: &Planned) {
        self.model = planned.field.model();
        self.unknowns = self.unknowns.max(planned.field.unknowns());
        self.bytes = self.bytes.max(planned.field.bytes());
        if planned.estimated_relative_error > self.expected_relative_error {
            self.expected_relative_error = planned.estimated_relative_error;
            self.reason.clone_from(&planned.reason);
        }
    }
}

impl TissueSpec {
    /// The question whose answer tells how far the needle's influence reaches: a push on the skin, seen where it pushes.
    fn at_the_skin(&self) -> Problem3 {
        let load = Load { kind: LoadKind::Contactor { depth_m: 0.0 }, radius_m: self.load_radius_m };
        let flat = Problem { slab: self.slab.clone(), load, sample_r_m: vec![0.0], sample_depth_m: Vec::new() };
        Problem3 { tilt_rad: self.tilt_rad, ..Problem3::flat(&flat) }
    }
}
