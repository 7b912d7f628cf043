//! Chooses the cheapest model that answers a question within a tolerance, with the reason as text.
//!
//! Flat layers under a perpendicular needle are a problem in (r, z), and under an oblique one two
//! of them, a harmonic each. For these the axisymmetric model is exact in its dimension and cheaper
//! than any other at every error that the others reach (`stylet bench field` shows it), so it is
//! chosen. Layers without an axis of symmetry go to the volumetric model, the only one that can
//! represent them. The lattice is used only on request by name: its central forces fix ν = 1/4, an
//! error that no refinement removes.
//!
//! The error of a choice is not looked up but estimated on the actual question, by comparison with
//! a clearly better mesh.

mod patch;

pub use patch::{Reach, cut_patch, find_reach, reach_of_all};
use phrase::{Phrase, phrase};

use super::axisymmetric::{self, AxisymmetricError};
use super::mass_spring::{self, LatticeError};
use super::volumetric::{self, Problem3, Skin, VolumetricError};
use super::{FieldModel, Judging, Model, Problem};

/// The request to the planner.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PlanRequest {
    /// The model requested by name; if absent, the planner chooses.
    pub model: Option<Model>,
    /// Tolerated relative L2 error over the samples, of the axial and of the radial displacement.
    pub tolerance: f64,
    /// How the error is judged.
    pub judging: Judging,
}

/// A model made for a question.
pub struct Planned {
    /// The model, solved for 1 N.
    pub field: Box<dyn FieldModel>,
    /// Why this model and this mesh.
    pub reason: Phrase,
    /// Estimated relative error.
    pub estimated_relative_error: f64,
    /// Whether the estimate meets the tolerance.
    pub met: bool,
}

/// Why no model can be made.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum PlanError {
    /// The axisymmetric model rejects the question.
    #[error(transparent)]
    Axisymmetric(#[from] AxisymmetricError),
    /// The lattice rejects the question.
    #[error(transparent)]
    MassSpring(#[from] LatticeError),
    /// The volumetric model rejects the question.
    #[error(transparent)]
    Volumetric(#[from] VolumetricError),
    /// The requested model cannot answer this question.
    #[error("{}", self.in_words())]
    Unsuited {
        /// The model.
        model: Model,
        /// The obstacle.
        why: Phrase,
    },
    /// The question has no load.
    #[error("load_depths_m: none; at least one load is needed")]
    NoLoad,
    /// "none" was requested, but a model is needed.
    #[error("model = \"none\" has no field; allowed: \"auto\", \"axisymmetric\", \"mass-spring\", \"volumetric\"")]
    NoModel,
}

impl PlanError {
    /// A description for the user. Errors in numbers that only a program could have set are not
    /// translated.
    #[must_use]
    pub fn in_words(&self) -> Phrase {
        match self {
            Self::Unsuited { model, why } => phrase!(
                "model = \"{model}\": {why}; allowed: \"auto\" or \"volumetric\"",
                model = model.name(),
                why = why.clone()
            ),
            Self::Axisymmetric(_) | Self::MassSpring(_) | Self::Volumetric(_) | Self::NoLoad | Self::NoModel => {
                Phrase::data(self)
            }
        }
    }
}

/// Chooses the model for a question, with the reason: the cheap half of a plan.
///
/// # Errors
/// If the requested model cannot answer the question.
pub fn choose(question: &Problem3, wished: Option<Model>) -> Result<(Model, Phrase), PlanError> {
    let bent = what_breaks_the_axis(question);
    let oblique = (question.tilt_rad != 0.0).then(|| phrase!("the needle is oblique"));
    match (wished, bent) {
        (Some(Model::None), _) => Err(PlanError::NoModel),
        (Some(model @ Model::Axisymmetric), Some(why)) => Err(PlanError::Unsuited { model, why }),
        (Some(model), why) => match oblique.or(why).filter(|_| model == Model::MassSpring) {
            Some(why) => Err(PlanError::Unsuited { model, why }),
            None => Ok((model, phrase!("{model} was requested", model = model.name()))),
        },
        (None, Some(why)) => Ok((Model::Volumetric, phrase!("{why}, so three dimensions are needed", why = why))),
        (None, None) => {
            let why = match oblique {
                None => phrase!("flat layers under a perpendicular needle are axisymmetric, so (r, z) is exact"),
                Some(_) => phrase!(
                    "flat layers are axisymmetric under an oblique needle too, so two harmonics in (r, z), for its \
                     push into the body and along the skin, are exact"
                ),
            };
            Ok((Model::Axisymmetric, why))
        }
    }
}

fn what_breaks_the_axis(question: &Problem3) -> Option<Phrase> {
    match (question.skin == Skin::Flat, question.inclusions.is_empty()) {
        (true, true) => None,
        (true, false) => Some(phrase!("there are inclusions")),
        (false, true) => Some(phrase!("the skin is curved")),
        (false, false) => Some(phrase!("the skin is curved and there are inclusions")),
    }
}

/// Chooses and makes the model.
///
/// # Errors
/// The first number of the question or the request that is out of range, or a model that cannot
/// answer the question.
pub fn plan(question: &Problem3, wish: &PlanRequest) -> Result<Planned, PlanError> {
    let (model, why) = choose(question, wish.model)?;
    let flat = &question.flat;
    let (judging, tolerance) = (wish.judging, wish.tolerance);
    let made = match model {
        Model::None => return Err(PlanError::NoModel),
        Model::Axisymmetric if question.tilt_rad != 0.0 => {
            Made::from(axisymmetric::fit_oblique_by(judging, question, tolerance)?)
        }
        Model::Axisymmetric => Made::from(axisymmetric::fit_by(judging, flat, tolerance)?),
        Model::MassSpring => Made::from(mass_spring::fit_by(judging, flat, tolerance)?),
        Model::Volumetric => Made::from(volumetric::fit_by(judging, question, tolerance)?),
    };
    let Made { field, mesh, estimated_relative_error, met } = made;
    let percent = Phrase::Number((1e2 * wish.tolerance).to_string());
    let nearer = model != Model::Axisymmetric && what_breaks_the_axis(question).is_none();
    let reason = match (met, nearer) {
        (true, _) => phrase!(
            "{why}; {mesh}: the cheapest found that meets a tolerance of {percent} %",
            why = why,
            mesh = mesh,
            percent = percent
        ),
        (false, false) => phrase!(
            "{why}; {mesh}: the best available, but it does not meet a tolerance of {percent} %",
            why = why,
            mesh = mesh,
            percent = percent
        ),
        (false, true) => phrase!(
            "{why}; {mesh}: the best available, but it does not meet a tolerance of {percent} %; \"axisymmetric\" \
             comes closer",
            why = why,
            mesh = mesh,
            percent = percent
        ),
    };
    Ok(Planned { field, reason, estimated_relative_error, met })
}

/// A mesh of a model's ladder, from coarse to fine; `None` past the last, or if the model cannot be
/// used.
#[must_use]
pub fn plan_rung(problem: &Problem, model: Model, at: usize) -> Option<Result<Box<dyn FieldModel>, PlanError>> {
    match model {
        Model::None => None,
        Model::Axisymmetric => boxed(axisymmetric::fit_rung(problem, at)),
        Model::MassSpring => boxed(mass_spring::fit_rung(problem, at)),
        Model::Volumetric => boxed(volumetric::fit_rung(&Problem3::flat(problem), at)),
    }
}

fn boxed<M: FieldModel + 'static, E: Into<PlanError>>(
    rung: Option<Result<M, E>>,
) -> Option<Result<Box<dyn FieldModel>, PlanError>> {
    rung.map(|made| made.map(|model| Box::new(model) as Box<dyn FieldModel>).map_err(Into::into))
}

/// The result of a model's own fit.
struct Made {
    field: Box<dyn FieldModel>,
    mesh: Phrase,
    estimated_relative_error: f64,
    met: bool,
}

macro_rules! made_from {
    ($($model:ident::$fitted:ident)+) => {
        $(impl From<$model::$fitted> for Made {
            fn from(fitted: $model::$fitted) -> Self {
                let mesh = fitted.mesh_in_words();
                let $model::$fitted { model, estimated_relative_error, met, .. } = fitted;
                Self { field: Box::new(model), mesh, estimated_relative_error, met }
            }
        })+
    };
}

made_from!(axisymmetric::FittedAxisymmetric axisymmetric::FittedOblique mass_spring::FittedLattice volumetric::FittedVolumetric);
