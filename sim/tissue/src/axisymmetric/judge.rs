//! A reference solution on a mesh of its own, refined until two successive ones agree.

use super::{AxisymmetricError, MeshSpec};
use crate::Problem;

/// Judges from coarse to fine.
pub(super) struct Ladder {
    /// Orders and sizes, from coarse to fine. No two have element ends at the same positions, and
    /// each has a fraction of the error of the previous one.
    judges: &'static [(usize, f64)],
    /// Two judges agree if they differ by at most this fraction of the tolerance.
    agreed: f64,
}

const JUDGES: [(usize, f64); 8] = [(3, 1.3), (4, 1.2), (5, 1.1), (6, 0.95), (8, 0.85), (9, 0.7), (10, 0.5), (10, 0.35)];

/// For reference solutions. Two of these agree so well only if the finer's own error is a fraction
/// of their difference.
pub(super) const FINE: Ladder = Ladder { judges: JUDGES.split_at(2).1, agreed: 0.3 };

/// For solutions that are used directly, with the whole difference between the last two as their
/// error.
pub(super) const WHOLE: Ladder = Ladder { judges: &JUDGES, agreed: 0.6 };

/// Estimated error of the finer of the last two judges, as a fraction of their difference.
const OWN: f64 = 1.0 / 3.0;

/// A solution with its estimated error.
pub(super) struct Judge<A> {
    pub answer: A,
    /// The solution of the previous judge.
    before: Option<A>,
    /// Estimated relative error.
    pub doubt: f64,
    /// The mesh of the previous judge.
    pub coarser: MeshSpec,
}

impl<A> Judge<A> {
    /// Refines until two judges agree well enough for a tolerance, or to the last.
    pub fn new(
        problem: &Problem,
        ladder: &Ladder,
        tolerance: f64,
        mut answer: impl FnMut(&MeshSpec) -> Result<A, AxisymmetricError>,
        distance: impl Fn(&A, &A) -> f64,
    ) -> Result<Self, AxisymmetricError> {
        let judges = ladder.judges;
        let mut meshes = judges.iter().map(|&(order, size)| MeshSpec::even(problem, order, size)).peekable();
        let mut coarser = MeshSpec::even(problem, judges[0].0, judges[0].1);
        meshes.next();
        let (mut judge, mut before, mut doubt) = (answer(&coarser)?, None, f64::INFINITY);
        while let Some(mesh) = meshes.next() {
            let finer = answer(&mesh)?;
            let change = distance(&judge, &finer);
            (before, doubt) = (Some(std::mem::replace(&mut judge, finer)), OWN * change);
            if change <= ladder.agreed * tolerance || meshes.peek().is_none() {
                break;
            }
            coarser = mesh;
        }
        Ok(Self { answer: judge, before, doubt, coarser })
    }

    /// Estimated relative error of a part of the solution.
    pub fn doubt_of(&self, distance: impl Fn(&A, &A) -> f64) -> f64 {
        OWN * self.change_of(distance)
    }

    /// Distance of the previous judge from a part of the solution.
    pub fn change_of(&self, distance: impl Fn(&A, &A) -> f64) -> f64 {
        self.before.as_ref().map_or(f64::INFINITY, |before| distance(before, &self.answer))
    }
}
