//! The cheapest mesh that meets a tolerance, with an error that is measured and not hoped for.
//!
//! The judge comes first. It is the answer of a mesh that shares nothing with those it judges, [`MeshSpec::even`]: a graded mesh
//! has low orders and long elements where the field fades, and misses what happens there, and the same mesh with higher orders
//! misses it too. Judges are climbed until two of them agree; what they still differ by is added to every error that the finer
//! of them measures.
//!
//! Then graded meshes are climbed, from near the one that the reference cases need, and the first that the judge finds good enough
//! is trimmed: orders that the tolerance does not need go.

use law::axial::Domain;
use phrase::Phrase;

use super::basis::MAX_ORDER;
use super::grading::{LEAST_ORDER, LEVELS};
use super::judge::{FINE, Judge};
use super::trim::{AnswerView, Rung, Trimming};
use super::{Axisymmetric, AxisymmetricError, MeshSpec, fit_first};
use crate::{Judging, Problem, Sampled};

/// A model with what is known of its error.
#[derive(Clone, Debug)]
pub struct FittedAxisymmetric {
    /// The model, solved for 1 N.
    pub model: Axisymmetric,
    /// Its mesh.
    pub mesh: MeshSpec,
    /// Relative L2 error over the problem's sample points, the larger of that of the axial and of the radial displacement.
    pub estimated_relative_error: f64,
    /// Whether the estimate meets the tolerance. Where not, this is the most accurate mesh there is.
    pub met: bool,
}

impl FittedAxisymmetric {
    /// The mesh, for people.
    #[must_use]
    pub fn mesh_in_words(&self) -> Phrase {
        self.mesh.in_words()
    }
}

/// The model on a mesh of the ladder from coarse to fine; none past the last.
///
/// # Errors
/// The first number of the problem that is out of range, or contrasts beyond double precision.
pub fn fit_rung(problem: &Problem, at: usize) -> Option<Result<Axisymmetric, AxisymmetricError>> {
    let level = LEVELS.clone().nth(at)?;
    // What does not make sense must be refused before a mesh is made of it.
    let checked = problem.check().map_err(AxisymmetricError::from);
    Some(checked.and_then(|()| Axisymmetric::new(problem, &MeshSpec::graded(problem, level as f64))))
}

/// Share of the tolerance that is aimed at. The rest is for the judge's own error.
pub(super) const AIM: f64 = 0.8;

/// Orders between what is judged and the judge, where they share a mesh.
pub(super) const BETTER: usize = 2;

/// The level that meets a tolerance of 1 %, or nearly, on the reference cases.
const LEVEL_AT_1_PERCENT: f64 = 5.0;

/// Levels that divide the error by ten.
const LEVELS_PER_DECADE: f64 = 2.0;

/// Finds the cheapest mesh whose relative error over the problem's sample points meets a tolerance.
///
/// # Errors
/// The first number of the problem that is out of range, or a tolerance that is not a positive number, or contrasts
/// beyond double precision.
pub fn fit(problem: &Problem, tolerance: f64) -> Result<FittedAxisymmetric, AxisymmetricError> {
    fit_by(Judging::Second, problem, tolerance)
}

/// The same by a way of judging.
///
/// # Errors
/// As for [`fit`].
pub fn fit_by(judging: Judging, problem: &Problem, tolerance: f64) -> Result<FittedAxisymmetric, AxisymmetricError> {
    problem.check()?;
    Domain::Positive.check("tolerance", tolerance, "")?;
    match judging {
        Judging::First => fit_first::fit(problem, tolerance),
        Judging::Second | Judging::Third | Judging::Fourth => judged(problem, tolerance),
    }
}

/// The level to begin at.
pub(super) fn first_level(tolerance: f64) -> usize {
    let decades = libm::log10(0.01 / tolerance);
    let level = LEVEL_AT_1_PERCENT + LEVELS_PER_DECADE * decades + 0.5;
    (level as usize).clamp(LEAST_ORDER, MAX_ORDER - BETTER)
}

fn judged(problem: &Problem, tolerance: f64) -> Result<FittedAxisymmetric, AxisymmetricError> {
    let solved = |mesh: &MeshSpec| Ok(problem.sampled(&Axisymmetric::new(problem, mesh)?));
    let judge = Judge::new(problem, &FINE, tolerance, solved, Sampled::distance)?;
    let fitted = |model: Axisymmetric, mesh: MeshSpec| {
        let estimated_relative_error = problem.sampled(&model).distance(&judge.answer) + judge.doubt;
        FittedAxisymmetric { model, mesh, estimated_relative_error, met: estimated_relative_error <= tolerance }
    };
    let view = AnswerView::both(&judge.answer);
    let truth = view.counted(&judge.answer);
    // Both components count as shares of themselves: what both are off by is more than what either is.
    let size = truth.iter().map(|value| value * value).sum::<f64>().sqrt();
    let trimming = Trimming { problem, view, truth: &truth, aim: AIM * tolerance / size };
    let level = first_level(tolerance);
    let mut mesh = MeshSpec::graded(problem, level as f64);
    let (mut before, mut to_side) = (f64::INFINITY, false);
    for orders in 0..=MAX_ORDER - level {
        let rung = Rung::new(problem, mesh.clone().raised(orders), view)?;
        let wrong = trimming.error(&rung);
        if wrong <= trimming.aim {
            let rung = trimming.trim(rung)?;
            return Ok(fitted(rung.model, rung.mesh));
        }
        // Without a corner at the side in the way, an order halves the error.
        if wrong > 0.5 * std::mem::replace(&mut before, wrong) && !to_side {
            (mesh, to_side) = (mesh.graded_to_side(), true);
        }
    }
    // What no graded mesh reaches, the judge before the last may.
    Ok(fitted(Axisymmetric::new(problem, &judge.coarser)?, judge.coarser.clone()))
}
