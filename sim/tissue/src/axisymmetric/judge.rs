//! An answer to judge others by: that of a mesh of its own, climbed until two agree.

use super::{AxisymmetricError, MeshSpec};
use crate::Problem;

/// Judges to climb.
pub(super) struct Ladder {
    /// Orders and sizes, from coarse to fine. No two have their elements' ends at the same places, and each has a fraction of the
    /// error of the one before.
    judges: &'static [(usize, f64)],
    /// Two judges agree when they differ by no more than this share of the tolerance.
    agreed: f64,
}

const JUDGES: [(usize, f64); 8] = [(3, 1.3), (4, 1.2), (5, 1.1), (6, 0.95), (8, 0.85), (9, 0.7), (10, 0.5), (10, 0.35)];

/// For answers that others are judged by. Two of these agree so well only where the finer's own error is a part of their difference.
pub(super) const FINE: Ladder = Ladder { judges: JUDGES.split_at(2).1, agreed: 0.3 };

/// For answers that are kept as they are, with the whole difference of the last two for their error.
pub(super) const WHOLE: Ladder = Ladder { judges: &JUDGES, agreed: 0.6 };

/// Share of the difference between the last two judges that is taken for the error of the finer.
const OWN: f64 = 1.0 / 3.0;

/// What is known of an answer.
pub(super) struct Judge<A> {
    pub answer: A,
    /// The answer of the judge before it.
    before: Option<A>,
    /// What its relative error is taken to be.
    pub doubt: f64,
    /// The mesh of the judge before it.
    pub coarser: MeshSpec,
}

impl<A> Judge<A> {
    /// Climbs until two judges agree well enough for a tolerance, or to the last.
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

    /// What the relative error of a part of the answer is taken to be.
    pub fn doubt_of(&self, distance: impl Fn(&A, &A) -> f64) -> f64 {
        OWN * self.change_of(distance)
    }

    /// How far the judge before it is from a part of the answer.
    pub fn change_of(&self, distance: impl Fn(&A, &A) -> f64) -> f64 {
        self.before.as_ref().map_or(f64::INFINITY, |before| distance(before, &self.answer))
    }
}
