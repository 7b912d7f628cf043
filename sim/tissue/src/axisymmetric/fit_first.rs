//! The choice of meshes before judges had a mesh of their own: recordings of that time are
//! re-simulated with it.
//!
//! Two orders more in every strip divide the error by about nine, so the distance between the two
//! solutions is the error of the lower one to about a tenth, except for what both miss. The first
//! mesh that its judge accepts is trimmed against the same judge.

use super::basis::MAX_ORDER;
use super::fit::{AIM, BETTER, FittedAxisymmetric, first_level};
use super::trim::{AnswerView, Rung, Trimming};
use super::{AxisymmetricError, MeshSpec};
use crate::{Problem, relative_distance};

/// Error of a mesh, in tolerances, up to which its judge is trusted: the judge's error is then a
/// sixth of the tolerance.
const DOUBT: f64 = 1.5;

/// Fraction of the tolerance that grading to the side may change. If it changes more, or more than
/// the orders of the judge do, every mesh is graded to it.
const SIDE: f64 = 0.5;

/// Finds a mesh whose distance from its judge meets a tolerance, for a checked problem.
pub(super) fn fit(problem: &Problem, tolerance: f64) -> Result<FittedAxisymmetric, AxisymmetricError> {
    let level = first_level(tolerance);
    let mesh = MeshSpec::graded(problem, level as f64);
    let mut climb = Climb { problem, tolerance, mesh, to_side: false, error: f64::INFINITY };
    for orders in 0..=MAX_ORDER - BETTER - level {
        if let Some((enough, judge)) = climb.judged(orders)? {
            let trimming = Trimming { problem, view: AnswerView::Axial, truth: &judge.answer, aim: AIM * tolerance };
            return Ok(fitted(trimming.trim(enough)?, &judge, tolerance));
        }
    }
    let finest = if climb.to_side { climb.mesh } else { climb.mesh.graded_to_side() }.raised(MAX_ORDER);
    let judge = Rung::new(problem, finest.clone().halved(), AnswerView::Axial)?;
    Ok(fitted(Rung::new(problem, finest, AnswerView::Axial)?, &judge, tolerance))
}

/// Relative distance of a rung from a better one.
fn error(rung: &Rung, better: &Rung) -> f64 {
    relative_distance(&rung.answer, &better.answer)
}

fn fitted(rung: Rung, better: &Rung, tolerance: f64) -> FittedAxisymmetric {
    let estimated_relative_error = error(&rung, better);
    let met = estimated_relative_error <= tolerance;
    FittedAxisymmetric { model: rung.model, mesh: rung.mesh, estimated_relative_error, met }
}

/// The search for a mesh that is good enough, and for its judge.
struct Climb<'a> {
    problem: &'a Problem,
    tolerance: f64,
    /// The initial mesh.
    mesh: MeshSpec,
    /// Whether it is graded to the side.
    to_side: bool,
    /// Error of the last rung.
    error: f64,
}

impl Climb<'_> {
    /// The mesh with its orders raised.
    fn rung(&self, orders: usize) -> Result<Rung, AxisymmetricError> {
        Rung::new(self.problem, self.mesh.clone().raised(orders), AnswerView::Axial)
    }

    /// A rung and its judge, if the judge can be trusted. The side is checked when it can, and when
    /// another order has not halved the error, as it would without the corner there.
    fn pair(&mut self, orders: usize) -> Result<Option<(Rung, Rung)>, AxisymmetricError> {
        let (low, judge) = (self.rung(orders)?, self.rung(orders + BETTER)?);
        let wrong = error(&low, &judge);
        let trusted = wrong <= DOUBT * self.tolerance;
        let stalled = wrong > 0.5 * std::mem::replace(&mut self.error, wrong);
        if !self.to_side && (trusted || stalled) {
            let sided = Rung::new(self.problem, low.mesh.clone().graded_to_side(), AnswerView::Axial)?;
            if error(&low, &sided) > if trusted { SIDE * self.tolerance } else { wrong } {
                self.to_side = true;
                self.mesh = self.mesh.clone().graded_to_side();
                return self.pair(orders);
            }
        }
        Ok(trusted.then_some((low, judge)))
    }

    /// A rung that meets the aim, with its judge: the rung with the given additional orders, or the
    /// next one.
    fn judged(&mut self, orders: usize) -> Result<Option<(Rung, Rung)>, AxisymmetricError> {
        let Some((mut rung, judge)) = self.pair(orders)? else { return Ok(None) };
        let meets = |rung: &Rung| error(rung, &judge) <= AIM * self.tolerance;
        if !meets(&rung) {
            rung = self.rung(orders + 1)?;
        }
        Ok(if meets(&rung) { Some((rung, judge)) } else { None })
    }
}
