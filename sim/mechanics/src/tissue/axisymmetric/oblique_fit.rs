//! The coarsest mesh for an oblique needle that meets a tolerance, with an error that is measured and not hoped for.
//!
//! As for a perpendicular needle the judge has a mesh of its own, and more stations along a drag. Nothing is trimmed: an oblique
//! answer is solved once and kept, so that a re-solve is free.

use super::basis::MAX_ORDER;
use super::fit::{BETTER, first_level};
use super::judge::Judge;
use super::{Axisymmetric, AxisymmetricError, MeshSpec, Oblique};
use crate::axial::Domain;
use crate::phrase;
use crate::phrase::Phrase;
use crate::tissue::volumetric::Problem3;
use crate::tissue::{Judging, relative_distance};

/// Stations of a drag in each strip, and of its judge.
const STATIONS: [usize; 2] = [3, 5];

/// A model with what is known of its error.
#[derive(Clone, Debug)]
pub struct FittedOblique {
    /// The model, solved for 1 N.
    pub model: Oblique,
    /// Its mesh.
    pub mesh: MeshSpec,
    /// Relative L2 error of the displacement along the needle, at the problem's depths and radii around the needle.
    pub estimated_relative_error: f64,
    /// Whether the estimate meets the tolerance. Where not, this is the most accurate mesh that was judged.
    pub met: bool,
}

impl FittedOblique {
    /// The mesh, for people.
    #[must_use]
    pub fn mesh_in_words(&self) -> Phrase {
        phrase!("{mesh} for each harmonic", mesh = self.mesh.in_words())
    }
}

/// Finds the coarsest mesh whose relative error around the needle meets a tolerance.
///
/// # Errors
/// The first number of the question that is out of range, or a tolerance that is not a positive number, or contrasts
/// beyond double precision.
pub fn fit_oblique(question: &Problem3, tolerance: f64) -> Result<FittedOblique, AxisymmetricError> {
    fit_oblique_by(Judging::Second, question, tolerance)
}

/// The same by a way of judging.
///
/// # Errors
/// As for [`fit_oblique`].
pub fn fit_oblique_by(
    judging: Judging,
    question: &Problem3,
    tolerance: f64,
) -> Result<FittedOblique, AxisymmetricError> {
    question.check()?;
    Domain::Positive.check("tolerance", tolerance, "")?;
    match judging {
        Judging::First => first(question, tolerance),
        Judging::Second => second(question, tolerance),
    }
}

/// What a question of flat layers comes to.
pub struct Along {
    /// Displacement along the needle at the question's depths, at its radii towards where the needle leans, in m/N.
    pub answer_m: Vec<f64>,
    /// What its relative error is taken to be.
    pub doubt: f64,
}

/// Answers a question by a mesh of its own, as fine as judging a tolerance needs.
///
/// # Errors
/// As for [`fit_oblique`].
pub fn along_needle(question: &Problem3, tolerance: f64) -> Result<Along, AxisymmetricError> {
    question.check()?;
    Domain::Positive.check("tolerance", tolerance, "")?;
    let [.., more] = STATIONS;
    let answer = |mesh: &MeshSpec| match question.tilt_rad {
        0.0 => Ok(question.all_along_needle_m(&Axisymmetric::new(&question.flat, mesh)?)),
        _ => Ok(question.all_along_needle_m(&Oblique::new(question, mesh, more)?)),
    };
    let Judge { answer: answer_m, doubt, .. } =
        Judge::new(&question.flat, tolerance, answer, |a, b| relative_distance(a, b))?;
    Ok(Along { answer_m, doubt })
}

fn second(question: &Problem3, tolerance: f64) -> Result<FittedOblique, AxisymmetricError> {
    let [few, more] = STATIONS;
    let answer = |mesh: &MeshSpec| Ok(answer_m(question, &Oblique::new(question, mesh, more)?));
    let judge = Judge::new(&question.flat, tolerance, answer, |a, b| relative_distance(a, b))?;
    let fitted = |model: Oblique, mesh: MeshSpec| {
        let estimated_relative_error = relative_distance(&answer_m(question, &model), &judge.answer) + judge.doubt;
        FittedOblique { model, mesh, estimated_relative_error, met: estimated_relative_error <= tolerance }
    };
    let level = first_level(tolerance);
    let (mut mesh, mut before) = (MeshSpec::graded(&question.flat, level as f64), f64::INFINITY);
    for orders in 0..=MAX_ORDER - level {
        let raised = mesh.clone().raised(orders);
        let fitted = fitted(Oblique::new(question, &raised, few)?, raised);
        let error = fitted.estimated_relative_error;
        if fitted.met {
            return Ok(fitted);
        }
        // Without a corner at the side in the way, an order halves the error.
        if error > 0.5 * std::mem::replace(&mut before, error) {
            mesh = mesh.graded_to_side();
        }
    }
    Ok(fitted(Oblique::new(question, &judge.coarser, more)?, judge.coarser.clone()))
}

/// By the same mesh with two orders more, graded to the side and with more stations: as recordings were made whose field names
/// no way of judging.
fn first(question: &Problem3, tolerance: f64) -> Result<FittedOblique, AxisymmetricError> {
    let level = first_level(tolerance);
    let mut first = MeshSpec::graded(&question.flat, level as f64);
    let mut before = f64::INFINITY;
    let mut orders = 0;
    loop {
        let fitted = judged(question, first.clone().raised(orders), tolerance)?;
        if fitted.met || level + orders + BETTER >= MAX_ORDER {
            return Ok(fitted);
        }
        // Without a corner at the side in the way, an order halves the error.
        let error = fitted.estimated_relative_error;
        if error > 0.5 * std::mem::replace(&mut before, error) {
            first = first.graded_to_side();
        }
        orders += 1;
    }
}

fn judged(question: &Problem3, mesh: MeshSpec, tolerance: f64) -> Result<FittedOblique, AxisymmetricError> {
    let [few, more] = STATIONS;
    let model = Oblique::new(question, &mesh, few)?;
    let better = Oblique::new(question, &mesh.clone().graded_to_side().raised(BETTER), more)?;
    let estimated_relative_error = relative_distance(&answer_m(question, &model), &answer_m(question, &better));
    let met = estimated_relative_error <= tolerance;
    Ok(FittedOblique { model, mesh, estimated_relative_error, met })
}

/// Displacement along the needle at the problem's depths, at its radii from the needle to both sides, in m.
fn answer_m(question: &Problem3, model: &Oblique) -> Vec<f64> {
    let at = |depth_m: f64, r_m: f64| question.along_needle_m(model, r_m, depth_m);
    let both =
        |depth_m: f64| question.flat.sample_r_m.iter().flat_map(move |&r_m| [at(depth_m, r_m), at(depth_m, -r_m)]);
    question.flat.sample_depth_m.iter().flat_map(|&depth_m| both(depth_m)).collect()
}
