//! The coarsest lattice that meets a tolerance, with a measured error.
//!
//! A lattice has two errors. Its springs have a Poisson ratio of 1/4 in every layer:
//! that is its **floor**, which no lattice can reduce. And its cells have a finite size, and its
//! rim and base are nearer than the tissue's. Both are measured on the problem's own samples
//! against finite elements in (r, z): the floor as the distance between their solutions with 1/4
//! and with the true ratios, the rest as the distance of the lattice from the first of these. The
//! error is at most the sum. It may be smaller if the two cancel, but would not on another sample.

use std::iter;

use law::axial::Domain;
use phrase::{Phrase, phrase};

use super::grid::{nearest_spacing_m, thinnest_m};
use super::{LatticeError, LatticePatch, LatticeSymmetry, MassSpring};
use crate::{Judging, LoadKind, Problem, Sampled, axisymmetric};

/// A model with its estimated error.
#[derive(Clone, Debug)]
pub struct FittedLattice {
    /// The model, solved for 1 N.
    pub model: MassSpring,
    /// Extent and spacing of the lattice.
    pub patch: LatticePatch,
    /// The part of the error caused by the Poisson ratio of 1/4: no lattice has less.
    pub floor: f64,
    /// Bound of the relative L2 error over the problem's sample points, the larger of those of the
    /// axial and the radial displacement.
    pub estimated_relative_error: f64,
    /// Whether the estimate meets the tolerance.
    pub met: bool,
}

impl FittedLattice {
    /// A description of the lattice for the user: "a lattice of 0.56 mm cells within 16 mm; central
    /// forces have ν = 1/4 built in, 11.3 % on this problem".
    #[must_use]
    pub fn mesh_in_words(&self) -> Phrase {
        phrase!(
            "a lattice of {cell_mm} mm cells within {reach_mm} mm; central forces have ν = 1/4 built in, {floor} % on this \
             problem",
            cell_mm = Phrase::number(self.patch.spacing_m * 1e3, 2),
            reach_mm = Phrase::number(self.patch.radius_m * 1e3, 0),
            floor = Phrase::number(self.floor * 100.0, 1),
        )
    }
}

/// Lattices from coarse to fine: the spacing relative to the smallest of the load's radius and the
/// layers' thicknesses, and the allowed effect of the rim and the base, which are nearer than the
/// tissue's. The cells of a layer must be near cubes, so that the thinnest layer determines the
/// spacing of all.
const RUNGS: [[f64; 2]; 6] = [[1.4, 0.2], [1.4, 0.06], [0.7, 0.06], [0.7, 0.03], [0.5, 0.03], [0.35, 0.02]];

/// Distances from the load to the held boundary that are tried, in load radii.
const REACHES: [f64; 7] = [8.0, 12.0, 16.0, 24.0, 32.0, 48.0, 64.0];

/// Lattices with more unknowns take tens of seconds to relax.
const MOST_UNKNOWNS: f64 = 3e5;

/// Tolerance of the reference finite elements, far below the error of any lattice.
const JUDGED_TO: f64 = 1e-3;

/// If the floor exceeds the tolerance, the rest of the error need not be below this fraction of the
/// floor.
const SHARE_OF_FLOOR: f64 = 0.6;

/// The model on one lattice of the ladder, from coarse to fine, for a speed–error sweep; `None`
/// past the last.
#[must_use]
pub fn fit_rung(problem: &Problem, at: usize) -> Option<Result<MassSpring, LatticeError>> {
    match LatticeJudge::new(problem, Judging::Second).and_then(|judge| judge.ladder()) {
        Ok((coarsest, finer)) => {
            iter::once(coarsest).chain(finer).nth(at).map(|patch| MassSpring::new(problem, &patch))
        }
        Err(why) => (at == 0).then_some(Err(why)),
    }
}

/// Finds the coarsest lattice of the ladder whose relative error over the problem's sample points
/// meets a tolerance. If the floor alone exceeds it, no lattice does: then returns one whose own
/// error is small compared with the floor.
///
/// # Errors
/// The first number of the problem that is out of range, a tolerance that is not a positive number,
/// or a layer so thin that even the coarsest lattice cannot be computed.
pub fn fit(problem: &Problem, tolerance: f64) -> Result<FittedLattice, LatticeError> {
    fit_by(Judging::Second, problem, tolerance)
}

/// Does the same with a given way of judging.
///
/// # Errors
/// Those of [`fit`].
pub fn fit_by(judging: Judging, problem: &Problem, tolerance: f64) -> Result<FittedLattice, LatticeError> {
    Domain::Positive.check("tolerance", tolerance, "")?;
    let judge = LatticeJudge::new(problem, judging)?;
    let enough = if judge.floor < tolerance { tolerance } else { (1.0 + SHARE_OF_FLOOR) * judge.floor };
    let (coarsest, finer) = judge.ladder()?;
    let mut fitted = judge.fitted(coarsest, tolerance)?;
    for patch in finer {
        if fitted.estimated_relative_error <= enough {
            break;
        }
        fitted = judge.fitted(patch, tolerance)?;
    }
    Ok(fitted)
}

/// The reference solutions for judging lattices.
struct LatticeJudge<'a> {
    problem: &'a Problem,
    judging: Judging,
    /// The problem with Poisson ratios of 1/4.
    quarter: Problem,
    /// Its solution at the samples: the limit of a lattice.
    limit: Sampled,
    /// The true solution.
    truth: Sampled,
    floor: f64,
}

impl<'a> LatticeJudge<'a> {
    fn new(problem: &'a Problem, judging: Judging) -> Result<Self, LatticeError> {
        problem.check()?;
        let solid = Problem { slab: problem.slab.solid(), ..problem.clone() };
        let mut quarter = solid.clone();
        quarter.slab.layers.iter_mut().for_each(|layer| layer.poisson_ratio = 0.25);
        let exact = |of: &Problem| Ok::<_, LatticeError>(axisymmetric::fit_by(judging, of, JUDGED_TO)?.model);
        let (truth, limit) = (problem.sampled(&exact(&solid)?), problem.sampled(&exact(&quarter)?));
        let judge = Self { problem, judging, quarter, limit, truth, floor: 0.0 };
        Ok(Self { floor: judge.distance(&judge.truth), ..judge })
    }

    /// Distance to the limit of lattices, relative to the true solution, of the displacement
    /// component with the larger distance.
    fn distance(&self, answer: &Sampled) -> f64 {
        let axial = distance(&answer.axial_m, &self.limit.axial_m, &self.truth.axial_m);
        match self.judging {
            Judging::First => axial,
            Judging::Second | Judging::Third | Judging::Fourth => {
                axial.max(distance(&answer.radial_m, &self.limit.radial_m, &self.truth.radial_m))
            }
        }
    }

    /// The coarsest patch, and finer ones that relax within seconds.
    fn ladder(&self) -> Result<(LatticePatch, Vec<LatticePatch>), LatticeError> {
        let mut reaches = REACHES.iter().map(|reach| self.patch(reach * self.problem.load.radius_m));
        let mut patch = self.patch(REACHES[0] * self.problem.load.radius_m);
        let mut rungs = Vec::with_capacity(RUNGS.len());
        for [cells, allowed] in RUNGS {
            while self.truncation(&patch)? > allowed
                && let Some(wider) = reaches.next()
            {
                patch = wider;
            }
            rungs.push(self.spaced(patch, cells));
        }
        let coarsest = rungs.remove(0);
        rungs.retain(|rung| rung.unknowns(&self.problem.slab) <= MOST_UNKNOWNS);
        Ok((coarsest, rungs))
    }

    /// The patch with cells of approximately this size, relative to the smallest of the load's
    /// radius and the layers' thicknesses.
    fn spaced(&self, patch: LatticePatch, cells: f64) -> LatticePatch {
        let (slab, load) = (&self.problem.slab, &self.problem.load);
        let spacing_m = cells * thinnest_m(slab, patch.depth_m).min(load.radius_m);
        LatticePatch { spacing_m: nearest_spacing_m(slab, &LatticePatch { spacing_m, ..patch }), ..patch }
    }

    /// The patch that ends at this distance from the load, in m, without a spacing yet.
    fn patch(&self, reach_m: f64) -> LatticePatch {
        let (slab, load) = (&self.problem.slab, &self.problem.load);
        let (LoadKind::Contactor { depth_m } | LoadKind::Drag { to_m: depth_m, .. }) = load.kind;
        let whole_m = slab.boundaries_m()[slab.layers.len()];
        let [radius_m, depth_m] = [reach_m.min(slab.radius_m), (depth_m + reach_m).min(whole_m)];
        LatticePatch { spacing_m: 0.0, radius_m, depth_m, symmetry: LatticeSymmetry::Quarter }
    }

    /// Effect of holding the rim and the base of a patch on the solution.
    fn truncation(&self, patch: &LatticePatch) -> Result<f64, LatticeError> {
        let mut cut = self.quarter.clone();
        cut.slab.radius_m = patch.radius_m;
        let mut left_m = patch.depth_m;
        cut.slab.layers.retain_mut(|layer| {
            layer.thickness_m = layer.thickness_m.min(left_m);
            left_m -= layer.thickness_m;
            layer.thickness_m > 1e-9 * patch.depth_m
        });
        cut.sample_r_m.retain(|&r_m| r_m < patch.radius_m);
        cut.sample_depth_m.retain(|&depth_m| depth_m < patch.depth_m);
        Ok(self.distance(&self.problem.sampled(&axisymmetric::fit_by(self.judging, &cut, JUDGED_TO)?.model)))
    }

    fn fitted(&self, patch: LatticePatch, tolerance: f64) -> Result<FittedLattice, LatticeError> {
        let model = MassSpring::new(self.problem, &patch)?;
        let floor = self.floor;
        let estimated_relative_error = floor + self.distance(&self.problem.sampled(&model));
        Ok(FittedLattice { model, patch, floor, estimated_relative_error, met: estimated_relative_error <= tolerance })
    }
}

/// ‖a − b‖/‖c‖; 0 if a and b are equal, even if all are zero.
fn distance(a: &[f64], b: &[f64], c: &[f64]) -> f64 {
    let wrong = norm(a.iter().zip(b).map(|(a, b)| a - b));
    if wrong == 0.0 { 0.0 } else { wrong / norm(c.iter().copied()) }
}

fn norm(values: impl Iterator<Item = f64>) -> f64 {
    values.map(|value| value * value).sum::<f64>().sqrt()
}
