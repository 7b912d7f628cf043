//! The coarsest mesh for an oblique needle that meets a tolerance, with an error that is measured and not hoped for.
//!
//! As for a perpendicular needle the judge has two orders more in every strip, and here it is graded to the side as well and
//! has more stations along a drag. Nothing is trimmed: an oblique answer is solved once and kept, so that a re-solve is free.

use super::basis::MAX_ORDER;
use super::fit::{BETTER, first_level};
use super::{AxisymmetricError, MeshSpec, Oblique};
use crate::axial::Domain;
use crate::phrase;
use crate::phrase::Phrase;
use crate::tissue::relative_distance;
use crate::tissue::volumetric::Problem3;

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
    question.check()?;
    Domain::Positive.check("tolerance", tolerance, "")?;
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
