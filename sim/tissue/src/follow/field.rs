//! The field of an attempt: unit responses from the model that the planner chooses, and the
//! follower.

use law::axial::{AxialSpec, ParamError};
use phrase::{Phrase, phrase};

use super::angles::{AngledResponses, FLATTEST_RAD, place_cosines};
use super::asked::{AskedLoads, AttemptLoad};
use super::responses::Responses;
use super::spec::TissueSpec;
use super::state::FollowParams;
use super::unevenness::weigh_change;
use crate::axisymmetric::{Along, AlongAngles, along_needle, along_needle_at};
use crate::planner::{self, PlanError, PlanRequest, Planned, Reach, cut_patch, find_reach, reach_of_all};
use crate::volumetric::Problem3;
use crate::{Judging, Load, LoadKind, Model, Problem, relative_distance};

/// Rate of the field, in Hz (physics section 5).
pub const FIELD_HZ: u32 = 120;

/// Why the field of a tissue cannot be computed.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum FollowError {
    /// A number of the tissue is out of range.
    #[error(transparent)]
    Param(#[from] ParamError),
    /// The planner rejects the tissue.
    #[error(transparent)]
    Plan(#[from] PlanError),
    /// The hand would feel a field that is not known well enough.
    #[error("the estimated error of a coupled field is {error}; allowed: its tolerance of {tolerance}")]
    Uncertain {
        /// Estimated relative error.
        error: f64,
        /// Relative error that the tissue allows.
        tolerance: f64,
    },
}

impl FollowError {
    /// A description for the user.
    #[must_use]
    pub fn in_words(&self) -> Phrase {
        match self {
            Self::Param(error) => Phrase::data(error),
            Self::Plan(error) => error.in_words(),
            Self::Uncertain { error, tolerance } => phrase!(
                "the estimated error of the field that the hand would feel is {error} %; allowed: {tolerance} %",
                error = Phrase::number(100.0 * error, 0),
                tolerance = Phrase::number(100.0 * tolerance, 0)
            ),
        }
    }
}

/// A coupled field may be off by so many times its tolerance: what is more is not felt.
const MOST_UNCERTAIN: f64 = 3.0;

/// The computation of a tissue's field.
#[derive(Clone, Debug, PartialEq)]
pub struct FieldPlan {
    /// The model.
    pub model: Model,
    /// Reason for the model, and its mesh under the worst load.
    pub reason: Phrase,
    /// Unknowns of the largest load's model.
    pub unknowns: usize,
    /// Maximum memory held at a time, in bytes: the largest load's model, which is released after
    /// its solve, and the responses.
    pub bytes: usize,
    /// Expected relative error of the displacement along the needle at the boundaries: of mesh and
    /// patch together, compared with the whole body, under the worst load of an attempt.
    pub expected_relative_error: f64,
    /// The worst load; `None` if the field is judged in the first way.
    pub worst: Option<AttemptLoad>,
}

/// Reach of a needle's influence.
#[derive(Clone, Debug, PartialEq)]
enum Influence {
    /// The reach, in m.
    Known(f64),
    /// Not computed: a display needs it, an attempt does not.
    Unknown {
        /// The question for the whole body, under a perpendicular needle.
        upright: Box<Problem3>,
        /// Displacements under each load there, in m/N.
        on_body_m: Vec<(Load, Vec<f64>)>,
        deepest_m: f64,
        tolerance: f64,
    },
}

/// The field of a tissue that follows the needle, ready for an attempt.
#[derive(Clone, Debug, PartialEq)]
pub struct Field {
    follow: FollowParams,
    on_axis: AngledResponses,
    /// Responses for a needle at the angle of the exercise.
    planned: Responses,
    plan: FieldPlan,
    influence: Influence,
}

impl Field {
    /// Computes the displacements at every boundary that the needle meets under 1 N along the
    /// needle at each place, with the model that the planner chooses, on a patch no larger than the
    /// needle's influence. Mesh and patch share the tolerance.
    ///
    /// # Errors
    /// If the tissue is invalid or no model can be made.
    pub fn new(tissue: &TissueSpec) -> Result<Self, FollowError> {
        tissue.check()?;
        if !tissue.is_even() {
            let field = Self::by_the_change(tissue)?;
            let (error, tolerance) = (field.plan.expected_relative_error, tissue.tolerance);
            // Earlier recordings were made with whatever came of it.
            let is_felt = tissue.coupled && tissue.judging >= Judging::Fourth;
            return if is_felt && error > MOST_UNCERTAIN * tolerance {
                Err(FollowError::Uncertain { error, tolerance })
            } else {
                Ok(field)
            };
        }
        match tissue.judging {
            Judging::First => Self::by_the_skin(tissue),
            Judging::Second => Self::by_the_attempt(tissue),
            Judging::Third | Judging::Fourth => Self::by_the_angle(tissue),
        }
    }

    /// Uses the patch of a push on the skin, and the error of the meshes and of that patch: the
    /// method for recordings whose field names no way of judging.
    fn by_the_skin(tissue: &TissueSpec) -> Result<Self, FollowError> {
        let share = 0.5 * tissue.tolerance;
        let Reach { radius_m, relative_change } = find_reach(&tissue.at_the_skin(), share).map_err(PlanError::from)?;
        let mut field = Self::within(tissue, radius_m.min(tissue.slab.radius_m), share)?;
        field.plan.expected_relative_error += relative_change;
        Ok(field)
    }

    /// First solves every load of an attempt on the whole body. Then chooses a patch that is
    /// accurate enough for all of them, and measures the error of its responses. If that is too
    /// large, the meshes are refined, provided that refinement helps.
    fn by_the_attempt(tissue: &TissueSpec) -> Result<Self, FollowError> {
        let known = KnownAnswers::for_tissue(tissue)?;
        let mut share = 0.5 * tissue.tolerance;
        let on_body_m: Vec<_> = known.asked.loads.iter().copied().zip(known.along.answers_m.iter().cloned()).collect();
        let radius_m =
            reach_of_all(&known.asked.question, &on_body_m, tissue.deepest_m(), share).map_err(PlanError::from)?;
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

    /// For flat layers, which can be solved in (r, z), solves every load on the whole body under a
    /// needle at several angles, as many as interpolation needs; any other model is solved for the
    /// angle of the exercise alone.
    fn by_the_angle(tissue: &TissueSpec) -> Result<Self, FollowError> {
        if !matches!(tissue.model, None | Some(Model::Axisymmetric)) {
            return Self::by_the_attempt(tissue);
        }
        let asked = AskedLoads::of(tissue);
        let flattest_rad = FLATTEST_RAD.max(tissue.tilt_rad.abs());
        let flattest = Problem3 { tilt_rad: flattest_rad, ..asked.question.clone() };
        flattest.check()?;
        let (_, why) = planner::choose(&flattest, tissue.model)?;
        let mut count = FEWEST_ANGLES;
        loop {
            let angles = KnownAngles::new(&asked, tissue, flattest_rad, count)?;
            let field = angles.into_field(&asked, tissue, &why)?;
            count *= 2;
            if field.plan.expected_relative_error <= tissue.tolerance || count > MOST_ANGLES {
                return Ok(field);
            }
        }
    }

    /// Solves flat layers first, and then the change by the skin and the inclusions under a needle
    /// at the angle of the exercise. A change that matters is added, equally at every angle.
    fn by_the_change(tissue: &TissueSpec) -> Result<Self, FollowError> {
        let asked = AskedLoads::of(tissue);
        let (_, why) = planner::choose(&asked.question, tissue.model)?;
        let level = TissueSpec { model: None, tolerance: LEVEL_SHARE * tissue.tolerance, ..tissue.leveled() };
        let mut field = Self::by_the_angle(&level)?;
        let Self { planned, plan, .. } = &mut field;
        let left = tissue.tolerance - plan.expected_relative_error;
        let weighed = weigh_change(&asked, tissue, planned, left)?;
        plan.reason = weighed.in_words(&why, &plan.reason);
        plan.expected_relative_error += weighed.error;
        plan.worst = weighed.worst.map(|place| asked.load_at(place));
        plan.unknowns = plan.unknowns.max(weighed.unknowns);
        plan.bytes = plan.bytes.max(weighed.bytes);
        if let Some(change) = &weighed.added {
            plan.model = Model::Volumetric;
            planned.add(1.0, change);
            field.on_axis.add(change);
        }
        Ok(field)
    }

    /// The responses on a patch of a radius, in m, by models that meet a tolerance on it.
    fn within(tissue: &TissueSpec, radius_m: f64, tolerance: f64) -> Result<Self, FollowError> {
        let patched =
            TissueSpec { slab: cut_patch(&tissue.slab.layers, tissue.deepest_m(), radius_m), ..tissue.clone() };
        let wish = PlanRequest { model: tissue.model, tolerance, judging: Judging::First };
        let mut plan = FieldPlan {
            model: Model::None,
            reason: Phrase::Data(String::new()),
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
        let planned = on_axis.clone();
        let (follow, on_axis) = (FollowParams::new(tissue)?, AngledResponses::constant(on_axis));
        Ok(Self { follow, on_axis, planned, plan, influence: Influence::Known(radius_m) })
    }

    /// Parameters of the follower.
    #[must_use]
    pub fn follow(&self) -> &FollowParams {
        &self.follow
    }

    /// Responses on the needle at every boundary, for any angle of the needle.
    #[must_use]
    pub fn on_axis(&self) -> &AngledResponses {
        &self.on_axis
    }

    /// Responses for a needle at the angle of the exercise.
    #[must_use]
    pub fn planned(&self) -> &Responses {
        &self.planned
    }

    /// Distance from the needle up to which the tissue moves by more than the tolerance, in m: the
    /// extent of a display.
    ///
    /// # Errors
    /// Those of [`Field::new`].
    pub fn reach_m(&self) -> Result<f64, FollowError> {
        match &self.influence {
            Influence::Known(radius_m) => Ok(*radius_m),
            Influence::Unknown { upright, on_body_m, deepest_m, tolerance } => {
                Ok(reach_of_all(upright, on_body_m, *deepest_m, *tolerance).map_err(PlanError::from)?)
            }
        }
    }

    /// How the field was computed.
    #[must_use]
    pub fn plan(&self) -> &FieldPlan {
        &self.plan
    }

    /// Gives every boundary of a law the field's stiffness at the angle of the exercise.
    pub fn couple(&self, axial: &mut AxialSpec) {
        for (layer, stiffness_n_per_m) in axial.layers.iter_mut().zip(self.planned.stiffnesses_n_per_m()) {
            layer.stiffness_n_per_m = stiffness_n_per_m;
        }
    }
}

impl FieldPlan {
    /// Records the errors of the responses to each load.
    fn judge(&mut self, asked: &AskedLoads, errors: impl Iterator<Item = f64>) {
        let worst = asked.worst(errors);
        self.expected_relative_error = worst.map_or(0.0, |worst| worst.error);
        self.worst = worst.map(|worst| asked.load_at(worst.place));
    }

    /// Accounts for the model of another load.
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

/// Maximum number of mesh refinements.
const FINER: usize = 3;

/// Share of the tolerance for flat layers if there is a change to add.
const LEVEL_SHARE: f64 = 0.4;

/// Initial and maximum number of solved angles: doubled until the interpolation is accurate enough.
const FEWEST_ANGLES: usize = 8;
const MOST_ANGLES: usize = 32;

/// Solutions for an attempt's loads on the whole body.
struct KnownAnswers {
    asked: AskedLoads,
    /// Displacement under each load at the boundaries, in m/N, and its accuracy.
    along: Along,
}

impl KnownAnswers {
    fn for_tissue(tissue: &TissueSpec) -> Result<Self, FollowError> {
        let asked = AskedLoads::of(tissue);
        let along = along_needle(&asked.question, &asked.loads, tissue.tolerance).map_err(PlanError::from)?;
        Ok(Self { asked, along })
    }

    /// Records in a field's plan the error of its responses, and the worst load.
    fn judge(&self, field: &mut Field) {
        let Field { planned, plan, .. } = field;
        let known = self.asked.places.iter().zip(&self.along.answers_m).zip(&self.along.doubts);
        let error = |((load, answer_m), doubt): ((&usize, &Vec<f64>), &f64)| {
            relative_distance(&planned.under(*load), answer_m) + doubt
        };
        plan.judge(&self.asked, known.map(error));
    }
}

/// Solutions for an attempt's loads on the whole body under a needle at several angles: those that
/// the responses are made of, and those between them that measure the interpolation error.
struct KnownAngles {
    flattest_rad: f64,
    /// Cosines of the former.
    nodes: Vec<f64>,
    /// Cosines of the latter, the perpendicular needle first.
    probes: Vec<f64>,
    /// At the former, then at the latter.
    along: AlongAngles,
}

impl KnownAngles {
    fn new(asked: &AskedLoads, tissue: &TissueSpec, flattest_rad: f64, count: usize) -> Result<Self, FollowError> {
        let nodes = place_cosines(flattest_rad, count);
        let between = nodes.windows(2).map(|pair| 0.5 * (pair[0] + pair[1]));
        let probes: Vec<f64> = std::iter::once(1.0).chain(between).chain([libm::cos(flattest_rad)]).collect();
        let tilts_rad: Vec<f64> = nodes.iter().chain(&probes).map(|cosine| libm::acos(*cosine)).collect();
        let along = along_needle_at(&asked.question, &asked.loads, &tilts_rad, tissue.tolerance);
        Ok(Self { flattest_rad, nodes, probes, along: along.map_err(PlanError::from)? })
    }

    /// Displacement along the needle at each sample under a load, at one of the angles, in m/N.
    fn answer_m(&self, asked: &AskedLoads, load: usize, angle: usize) -> &[f64] {
        let samples = asked.question.flat.sample_depth_m.len();
        &self.along.answers_m[load][angle * samples..(angle + 1) * samples]
    }

    /// The responses at one of the angles.
    fn responses(&self, asked: &AskedLoads, angle: usize) -> Responses {
        asked.responses(|load, sample| self.answer_m(asked, load, angle)[sample])
    }

    fn into_field(self, asked: &AskedLoads, tissue: &TissueSpec, why: &Phrase) -> Result<Field, FollowError> {
        let count = self.nodes.len();
        let tables = (0..count).map(|angle| self.responses(asked, angle)).collect();
        let on_axis = AngledResponses::new(self.flattest_rad, self.nodes.clone(), tables);
        let upright_m =
            asked.loads.iter().enumerate().map(|(at, load)| (*load, self.answer_m(asked, at, count).to_vec()));
        let influence = Influence::Unknown {
            upright: Box::new(Problem3 { tilt_rad: 0.0, ..asked.question.clone() }),
            on_body_m: upright_m.collect(),
            deepest_m: tissue.deepest_m(),
            tolerance: 0.5 * tissue.tolerance,
        };
        let mut plan = FieldPlan {
            model: Model::Axisymmetric,
            reason: phrase!(
                "{why}; {mesh} for each harmonic, solved once for {count} angles of the needle up to {degrees}°, between which \
                 the rest is interpolated",
                why = why.clone(),
                mesh = self.along.mesh.clone(),
                count = count,
                degrees = Phrase::number(self.flattest_rad.to_degrees(), 0)
            ),
            unknowns: self.along.unknowns,
            bytes: self.along.bytes + on_axis.bytes(),
            expected_relative_error: 0.0,
            worst: None,
        };
        let between: Vec<Responses> = self.probes.iter().map(|cosine| on_axis.at(*cosine)).collect();
        let told: Vec<Responses> = (0..self.probes.len()).map(|probe| self.responses(asked, count + probe)).collect();
        let off = |place: usize| {
            let pairs = between.iter().zip(&told);
            pairs.map(|(found, told)| relative_distance(&found.under(place), &told.under(place))).fold(0.0, f64::max)
        };
        plan.judge(asked, asked.places.iter().zip(&self.along.doubts).map(|(place, doubt)| off(*place) + doubt));
        let planned = on_axis.at(libm::cos(tissue.tilt_rad));
        Ok(Field { follow: FollowParams::new(tissue)?, on_axis, planned, plan, influence })
    }
}

impl TissueSpec {
    /// The question that determines the reach of the needle's influence: a push on the skin,
    /// sampled where it pushes.
    fn at_the_skin(&self) -> Problem3 {
        let load = Load { kind: LoadKind::Contactor { depth_m: 0.0 }, radius_m: self.load_radius_m };
        let flat = Problem { slab: self.slab.clone(), load, sample_r_m: vec![0.0], sample_depth_m: Vec::new() };
        Problem3 { tilt_rad: self.tilt_rad, ..Problem3::flat(&flat) }
    }
}
