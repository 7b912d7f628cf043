//! From a question and a tolerance to the cheapest mesh that answers it, with the reason in words.
//!
//! The error of a choice is not looked up but estimated on the very question, by comparison with a clearly better mesh.

use super::axisymmetric::{self, AxisymmetricError};
use super::{FieldModel, Model, Problem};

/// What is asked of the planner.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Wish {
    /// The model that is asked for by name; the planner chooses without one.
    pub model: Option<Model>,
    /// Tolerated relative L2 error of the axial displacement over the samples.
    pub tolerance: f64,
}

/// A model made for a question.
pub struct Planned {
    /// The model, solved for 1 N.
    pub field: Box<dyn FieldModel>,
    /// Why this model and this mesh.
    pub reason: String,
    /// Estimated relative error.
    pub estimated_relative_error: f64,
    /// The estimate meets the tolerance.
    pub met: bool,
}

/// Why there is no model.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum PlanError {
    /// The axisymmetric model refuses.
    #[error(transparent)]
    Axisymmetric(#[from] AxisymmetricError),
    /// There is nothing to answer.
    #[error("load_depths_m: none; at least one load is needed")]
    NoLoad,
}

/// Chooses and makes the model.
///
/// # Errors
/// The first number of the problem or the wish that is out of range.
pub fn plan(problem: &Problem, wish: &Wish) -> Result<Planned, PlanError> {
    let fitted = axisymmetric::fit(problem, wish.tolerance)?;
    let why = match wish.model {
        Some(model) => format!("{} was asked for", model.name()),
        None => "flat layers under a perpendicular needle have an axis, so (r, z) is exact".to_owned(),
    };
    let (across, down) = (fitted.mesh.radial.len(), fitted.mesh.axial.len());
    let order = fitted.mesh.radial.iter().chain(&fitted.mesh.axial).map(|strip| strip.order).max().unwrap_or(0);
    let mesh = format!("{across} × {down} elements of order up to {order}");
    let reason = if fitted.met {
        format!("{why}; {mesh} are the cheapest found that meet {}", wish.tolerance)
    } else {
        format!("{why}; {mesh} are the finest there are, and do not meet {}", wish.tolerance)
    };
    let estimated_relative_error = fitted.estimated_relative_error;
    Ok(Planned { field: Box::new(fitted.model), reason, estimated_relative_error, met: fitted.met })
}
