//! The cheapest mesh that meets a tolerance, with a measured error.
//!
//! The judge comes first: the solution on a mesh that shares nothing with those it judges,
//! [`MeshSpec::even`]. A graded mesh has low orders and long elements where the field fades, and
//! misses what happens there; the same mesh with higher orders misses it too. Judges are refined
//! until two of them agree; their remaining difference is added to every error that the finer of
//! them measures.
//!
//! Then graded meshes are refined, starting near the one that the reference cases need, and the
//! first that the judge accepts is trimmed: orders that the tolerance does not need are removed.

use law::axial::Domain;
use phrase::Phrase;

use super::basis::MAX_ORDER;
use super::grading::{LEAST_ORDER, LEVELS};
use super::judge::{FINE, Judge};
use super::trim::{AnswerView, Rung, Trimming};
use super::{Axisymmetric, AxisymmetricError, MeshSpec, fit_first};
use crate::{Judging, Problem, Sampled};

/// A model with its estimated error.
#[derive(Clone, Debug)]
pub struct FittedAxisymmetric {
    /// The model, solved for 1 N.
    pub model: Axisymmetric,
    /// Its mesh.
    pub mesh: MeshSpec,
    /// Relative L2 error over the problem's sample points, the larger of those of the axial and the
    /// radial displacement.
    pub estimated_relative_error: f64,
    /// Whether the estimate meets the tolerance. If not, this is the most accurate mesh.
    pub met: bool,
}

impl FittedAxisymmetric {
    /// A description of the mesh for the user.
    #[must_use]
    pub fn mesh_in_words(&self) -> Phrase {
        self.mesh.in_words()
    }
}

/// The model on a mesh of the ladder, from coarse to fine; `None` past the last.
///
/// # Errors
/// The first number of the problem that is out of range, or contrasts beyond double precision.
pub fn fit_rung(problem: &Problem, at: usize) -> Option<Result<Axisymmetric, AxisymmetricError>> {
    let level = LEVELS.clone().nth(at)?;
    // An invalid problem must be rejected before a mesh is made of it.
    let checked = problem.check().map_err(AxisymmetricError::from);
    Some(checked.and_then(|()| Axisymmetric::new(problem, &MeshSpec::graded(problem, level as f64))))
}

/// Fraction of the tolerance to aim at. The rest is reserved for the judge's own error.
pub(super) const AIM: f64 = 0.8;

/// Difference in order between a mesh and its judge, if they share a mesh.
pub(super) const BETTER: usize = 2;

/// The level that approximately meets a tolerance of 1 % on the reference cases.
const LEVEL_AT_1_PERCENT: f64 = 5.0;

/// Number of levels that divide the error by ten.
const LEVELS_PER_DECADE: f64 = 2.0;

/// Finds the cheapest mesh whose relative error over the problem's sample points meets a tolerance.
///
/// # Errors
/// The first number of the problem that is out of range, or a tolerance that is not a positive
/// number, or contrasts beyond double precision.
pub fn fit(problem: &Problem, tolerance: f64) -> Result<FittedAxisymmetric, AxisymmetricError> {
    fit_by(Judging::Second, problem, tolerance)
}

/// Does the same with a given way of judging.
///
/// # Errors
/// Those of [`fit`].
pub fn fit_by(judging: Judging, problem: &Problem, tolerance: f64) -> Result<FittedAxisymmetric, AxisymmetricError> {
    problem.check()?;
    Domain::Positive.check("tolerance", tolerance, "")?;
    match judging {
        Judging::First => fit_first::fit(problem, tolerance),
        Judging::Second | Judging::Third | Judging::Fourth => judged(problem, tolerance),
    }
}

/// The initial level.
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
    // Both components are divided by their own norms: their joint error exceeds that of either.
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
        // An order halves the error, unless a corner at the side limits it.
        if wrong > 0.5 * std::mem::replace(&mut before, wrong) && !to_side {
            (mesh, to_side) = (mesh.graded_to_side(), true);
        }
    }
    // The judge before the last may reach an accuracy that no graded mesh reaches.
    Ok(fitted(Axisymmetric::new(problem, &judge.coarser)?, judge.coarser.clone()))
}
