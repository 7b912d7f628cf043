//! The cheapest mesh that meets a tolerance, with a measured error.
//!
//! A ladder of meshes is climbed, and each rung is judged on the problem itself, at its sample
//! points, by the same mesh with elements of one order more. That has a fraction of the error, so
//! the distance between the two solutions is most of the error of the lower one. A finer rung of
//! the same order cannot serve as the judge: what a coarse mesh misses, the next one often misses
//! too.

use law::axial::Domain;
use nalgebra::{Point3, Vector3};
use phrase::{Phrase, phrase};

use super::{Grading, MeshSpec3, Problem3, Symmetry, Volumetric, VolumetricError};
use crate::{FieldModel, Judging, Sampled};

/// A model with its estimated error.
#[derive(Clone, Debug)]
pub struct FittedVolumetric {
    /// The model, solved for 1 N.
    pub model: Volumetric,
    /// Its mesh.
    pub mesh: MeshSpec3,
    /// Relative L2 error over the problem's sample points around the needle, the larger of those of
    /// the displacement along it and across it, both in and perpendicular to its plane.
    pub estimated_relative_error: f64,
    /// Whether the estimate meets the tolerance. If not, this is the most accurate mesh that was
    /// tried.
    pub met: bool,
}

impl FittedVolumetric {
    /// A description of the mesh for the user: "42 hexahedra of order 3 in a quarter of the
    /// tissue".
    #[must_use]
    pub fn mesh_in_words(&self) -> Phrase {
        let part = match self.mesh.symmetry {
            Symmetry::Quarter => phrase!("a quarter of the tissue"),
            Symmetry::Half => phrase!("half of the tissue"),
            Symmetry::Full => phrase!("the whole tissue"),
        };
        let elements = self.model.patch().body().elements();
        phrase!(
            "{elements} hexahedra of order {order} in {part}",
            elements = elements,
            order = self.mesh.order,
            part = part
        )
    }
}

/// Meshes from coarse to fine: the order; size at the load, in load radii, and growth, across and
/// along the needle. They are among the most efficient of some six hundred on a layered lower back.
const RUNGS: [(usize, [f64; 2], [f64; 2]); 7] = [
    (2, [1.5, 1.5], [0.4, 2.0]),
    (2, [0.8, 1.0], [0.7, 1.2]),
    (2, [1.0, 0.7], [0.7, 1.2]),
    (3, [0.8, 1.0], [0.7, 1.2]),
    (3, [1.0, 0.7], [0.7, 1.2]),
    (3, [0.8, 0.4], [0.7, 0.8]),
    (3, [0.6, 0.4], [0.4, 0.5]),
];

/// Judges with more unknowns take many seconds to factorise.
const MOST_UNKNOWNS: usize = 25_000;

/// Distance of the end of the patch from the load, in load radii. The clamp there changes less than
/// a thousandth of the largest displacement.
const REACH: f64 = 100.0;

/// Fraction of the error that the judge detects: it has some error itself.
const SEEN: f64 = 0.85;

/// The same if one material is more than [`CONTRAST`] times as stiff as another: the error where
/// the stiff one is clamped is partly shared by the same mesh of one order more.
const SEEN_AT_CONTRAST: f64 = 0.5;

/// Ratio of Young's moduli.
const CONTRAST: f64 = 3e3;

/// Fraction of the tolerance to aim at: an estimate may be slightly too small.
const AIM: f64 = 0.95;

/// Maximum number of rungs climbed at once: far above the tolerance an estimate is a poor predictor
/// of the rungs needed.
const STRIDE: f64 = 3.0;

impl MeshSpec3 {
    /// Meshes for a problem, from coarse to fine, of the smallest part that must be meshed.
    #[must_use]
    pub fn ladder(problem: &Problem3) -> [Self; RUNGS.len()] {
        let radius_m = problem.flat.load.radius_m;
        let grading = |[near, growth]: [f64; 2]| Grading { near_m: near * radius_m, growth };
        let rung = |(order, across, along)| Self {
            symmetry: problem.symmetry(),
            order,
            around: 1,
            across: grading(across),
            along: grading(along),
            reach_m: REACH * radius_m,
        };
        RUNGS.map(rung)
    }
}

/// The model on one mesh of the ladder, from coarse to fine, for a speed–error sweep; `None` past
/// the last.
///
/// # Errors
/// The first number of the problem that is out of range.
pub fn fit_rung(problem: &Problem3, at: usize) -> Option<Result<Volumetric, VolumetricError>> {
    MeshSpec3::ladder(problem).get(at).map(|mesh| Volumetric::new(problem, mesh))
}

/// Finds the cheapest mesh of the ladder whose relative error over the problem's sample points
/// meets a tolerance.
///
/// # Errors
/// The first number of the problem that is out of range, or a tolerance that is not a positive
/// number.
pub fn fit(problem: &Problem3, tolerance: f64) -> Result<FittedVolumetric, VolumetricError> {
    fit_by(Judging::Second, problem, tolerance)
}

/// Does the same with a given way of judging.
///
/// # Errors
/// Those of [`fit`].
pub fn fit_by(judging: Judging, problem: &Problem3, tolerance: f64) -> Result<FittedVolumetric, VolumetricError> {
    problem.check()?;
    Domain::Positive.check("tolerance", tolerance, "")?;
    if problem.symmetry() == Symmetry::Quarter {
        return Ok(climb(problem, judging, tolerance, 0)?.1);
    }
    // A tilt or an inclusion hardly changes the required mesh, and a quarter of flat layers is
    // solved quickly.
    let (start, _) = climb(&Problem3::flat(&problem.flat), judging, tolerance, 0)?;
    Ok(climb(problem, judging, tolerance, start)?.1)
}

/// Climbs the ladder from a rung to the first that is accurate enough, or to the last with an
/// affordable judge.
fn climb(
    problem: &Problem3,
    judging: Judging,
    tolerance: f64,
    start: usize,
) -> Result<(usize, FittedVolumetric), VolumetricError> {
    let ladder = MeshSpec3::ladder(problem);
    let mut last = 0;
    while last + 1 < ladder.len() && judge(ladder[last + 1]).unknowns(problem)? <= MOST_UNKNOWNS {
        last += 1;
    }
    let mut at = start.min(last);
    loop {
        let fitted = judged(problem, ladder[at], judging, tolerance)?;
        let excess = fitted.estimated_relative_error / (AIM * tolerance);
        if excess <= 1.0 || at == last {
            return Ok((at, fitted));
        }
        // Each rung approximately halves the error.
        let rungs = libm::log2(excess).round().clamp(1.0, STRIDE) as usize;
        at = (at + rungs).min(last);
    }
}

/// The mesh of the judge of a mesh.
fn judge(mesh: MeshSpec3) -> MeshSpec3 {
    MeshSpec3 { order: mesh.order + 1, ..mesh }
}

fn judged(
    problem: &Problem3,
    mesh: MeshSpec3,
    judging: Judging,
    tolerance: f64,
) -> Result<FittedVolumetric, VolumetricError> {
    let solved = |mesh: &MeshSpec3| {
        let mut model = Volumetric::new(problem, mesh)?;
        model.solve(1.0);
        Ok::<_, VolumetricError>(model)
    };
    let better = answer(problem, &solved(&judge(mesh))?);
    let model = solved(&mesh)?;
    let estimated_relative_error = answer(problem, &model).distance_by(judging, &better) / seen(problem);
    Ok(FittedVolumetric { model, mesh, estimated_relative_error, met: estimated_relative_error <= tolerance })
}

/// Fraction of a mesh's error that its judge detects.
fn seen(problem: &Problem3) -> f64 {
    let layers = problem.flat.slab.layers.iter().filter(|layer| layer.thickness_m > 0.0);
    let inclusions = problem.inclusions.iter().map(|inclusion| inclusion.material.youngs_modulus_pa);
    let (softest, stiffest) = layers
        .map(|layer| layer.youngs_modulus_pa)
        .chain(inclusions)
        .fold((f64::INFINITY, 0.0_f64), |(low, high), modulus| (low.min(modulus), high.max(modulus)));
    if stiffest > CONTRAST * softest { SEEN_AT_CONTRAST } else { SEEN }
}

/// Displacement at the sample points: out of the body along the needle, and across it in the
/// direction away from it, in m.
fn answer(problem: &Problem3, model: &Volumetric) -> Sampled {
    let (sine, cosine) = (libm::sin(problem.tilt_rad), libm::cos(problem.tilt_rad));
    let out = Vector3::new(-sine, 0.0, cosine);
    let mut answer = Sampled::default();
    for (point, away) in samples_m(problem) {
        let across = Vector3::new(away.x * cosine, away.y, away.x * sine);
        let moved = model.displacement_at(&point);
        answer.axial_m.push(moved.dot(&out));
        answer.radial_m.push(moved.dot(&across));
    }
    answer
}

/// The sample points, in m, and the direction along the skin away from the needle there: at the
/// problem's radii around the point where the needle meets its load, on both sides in its plane and
/// perpendicular to it.
fn samples_m(problem: &Problem3) -> Vec<(Point3<f64>, Vector3<f64>)> {
    let [_, to_m] = problem.flat.load.ends_m();
    let centre_m = problem.on_flat_needle(to_m);
    let mut points = Vec::new();
    for &depth_m in &problem.flat.sample_depth_m {
        for &r_m in &problem.flat.sample_r_m {
            let around = [Vector3::x(), -Vector3::x(), Vector3::y()];
            points.extend(around.map(|away| {
                let flat = Point3::new(centre_m.x, centre_m.y, -depth_m) + r_m * away;
                (problem.skin.bend(&flat), away)
            }));
        }
    }
    points
}
