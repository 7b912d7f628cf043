//! The field of an attempt: unit responses by the planner's choice of model, and the follower.

use law::axial::{AxialSpec, ParamError};
use phrase::Phrase;

use super::responses::{Responses, pose_question};
use super::spec::TissueSpec;
use super::state::FollowParams;
use crate::axisymmetric::{Along, along_needle};
use crate::planner::{self, PlanError, PlanRequest, Planned, Reach, cut_patch, find_reach, reach_of_all};
use crate::volumetric::Problem3;
use crate::{Judging, Load, LoadKind, Model, Problem, relative_distance};

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
    /// Expected relative error of the displacement along the needle at the boundaries: of mesh and patch together, against the
    /// whole body, under the load of an attempt for which it is worst.
    pub expected_relative_error: f64,
    /// That load; none where the field is judged in the first way.
    pub worst: Option<AttemptLoad>,
}

/// A load that an attempt puts on the tissue.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum AttemptLoad {
    /// A contactor at the boundary of this layer, from 0 at the skin.
    Push(usize),
    /// The shaft's drag along this layer.
    Drag(usize),
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
        match tissue.judging {
            Judging::First => Self::by_the_skin(tissue),
            Judging::Second => Self::by_the_attempt(tissue),
        }
    }

    /// The patch is that of a push on the skin, and the error that of the meshes and of that patch: as recordings were made whose
    /// field names no way of judging.
    fn by_the_skin(tissue: &TissueSpec) -> Result<Self, FollowError> {
        let share = 0.5 * tissue.tolerance;
        let Reach { radius_m, relative_change } = find_reach(&tissue.at_the_skin(), share).map_err(PlanError::from)?;
        let mut field = Self::within(tissue, radius_m.min(tissue.slab.radius_m), share)?;
        field.plan.expected_relative_error += relative_change;
        Ok(field)
    }

    /// Every load of an attempt is asked on the whole body first. A patch is taken that is good enough for all of them, and what
    /// its responses are off by is measured. Where that is too much, meshes are made finer, if finer ones are what it takes.
    fn by_the_attempt(tissue: &TissueSpec) -> Result<Self, FollowError> {
        let known = KnownAnswers::for_tissue(tissue)?;
        let mut share = 0.5 * tissue.tolerance;
        let on_body_m: Vec<_> = known.loads.iter().copied().zip(&known.along.answers_m).collect();
        let radius_m = reach_of_all(&known.question, &on_body_m, tissue.deepest_m(), share).map_err(PlanError::from)?;
        let mut tries = FINER;
        loop {
            let mut field = Self::within(tissue, radius_m, share)?;
            known.judge(&mut field);
            tries -= 1;
            let good = field.plan.expected_relative_error <= tissue.tolerance;
            if good || tries == 0 || field.plan.model != Model::Axisymmetric {
                return Ok(field);
            }
            share *= 0.3;
        }
    }

    /// The responses on a patch of a radius, in m, by models that meet a tolerance on it.
    fn within(tissue: &TissueSpec, radius_m: f64, tolerance: f64) -> Result<Self, FollowError> {
        let patched =
            TissueSpec { slab: cut_patch(&tissue.slab.layers, tissue.deepest_m(), radius_m), ..tissue.clone() };
        let wish = PlanRequest { model: tissue.model, tolerance, judging: Judging::First };
        let mut plan = FieldPlan {
            model: Model::None,
            reason: Phrase::Data(String::new()),
            radius_m,
            unknowns: 0,
            bytes: 0,
            expected_relative_error: f64::NEG_INFINITY,
            worst: None,
        };
        let on_axis = Responses::at_boundaries(&patched, &mut |question| {
            let planned = planner::plan(question, &wish)?;
            plan.take(&planned);
            Ok::<_, FollowError>(planned.field)
        })?;
        plan.bytes += on_axis.bytes();
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

/// Meshes are made finer at most so many times.
const FINER: usize = 3;

/// What an attempt's loads do to the whole body.
struct KnownAnswers {
    /// What is asked of all of them; its own load is a drag through the whole tissue.
    question: Problem3,
    loads: Vec<Load>,
    /// Where each load is in [`TissueSpec::loads`].
    places: Vec<usize>,
    /// What each does at the boundaries, in m/N, and how exactly that is known.
    along: Along,
    /// Layers of the force law.
    layers: usize,
}

impl KnownAnswers {
    fn for_tissue(tissue: &TissueSpec) -> Result<Self, FollowError> {
        let every = tissue.loads().into_iter().enumerate();
        let (places, loads): (Vec<usize>, Vec<Load>) = every.filter_map(|(at, load)| Some((at, load?))).unzip();
        let through = LoadKind::Drag { from_m: 0.0, to_m: tissue.deepest_m() };
        let whole = Load { kind: through, radius_m: tissue.load_radius_m };
        let question = pose_question(tissue, whole, &tissue.points_m());
        let along = along_needle(&question, &loads, tissue.tolerance).map_err(PlanError::from)?;
        Ok(Self { question, loads, places, along, layers: tissue.layers() })
    }

    /// Tells a field's plan what its responses are off by, and under which load it is most.
    fn judge(&self, field: &mut Field) {
        let plan = &mut field.plan;
        plan.expected_relative_error = 0.0;
        for ((&load, answer_m), doubt) in self.places.iter().zip(&self.along.answers_m).zip(&self.along.doubts) {
            let error = relative_distance(&field.on_axis.under(load), answer_m) + doubt;
            if plan.worst.is_none() || error > plan.expected_relative_error {
                plan.expected_relative_error = error;
                plan.worst = Some(match load.checked_sub(self.layers) {
                    None => AttemptLoad::Push(load),
                    Some(layer) => AttemptLoad::Drag(layer),
                });
            }
        }
    }
}

impl TissueSpec {
    /// Depth of the deepest boundary, in m.
    fn deepest_m(&self) -> f64 {
        self.boundaries_m.iter().copied().fold(0.0, f64::max)
    }

    /// The question whose answer tells how far the needle's influence reaches: a push on the skin, seen where it pushes.
    fn at_the_skin(&self) -> Problem3 {
        let load = Load { kind: LoadKind::Contactor { depth_m: 0.0 }, radius_m: self.load_radius_m };
        let flat = Problem { slab: self.slab.clone(), load, sample_r_m: vec![0.0], sample_depth_m: Vec::new() };
        Problem3 { tilt_rad: self.tilt_rad, ..Problem3::flat(&flat) }
    }
}
