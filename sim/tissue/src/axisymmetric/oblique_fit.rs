//! The coarsest mesh for an oblique needle that meets a tolerance, with a measured error.
//!
//! As for a perpendicular needle, the judge has a mesh of its own, and more stations along a drag.
//! No orders are trimmed: an oblique solution is computed once and stored, so that solving again
//! costs nothing.

use law::axial::Domain;
use phrase::{Phrase, phrase};

use super::basis::MAX_ORDER;
use super::fit::{BETTER, first_level};
use super::judge::{FINE, Judge, WHOLE};
use super::oblique::SharedMesh;
use super::pushes::Pushes;
use super::{Axisymmetric, AxisymmetricError, MeshSpec, Oblique};
use crate::volumetric::Problem3;
use crate::{FieldModel, Judging, Load, LoadKind, Problem, Sampled, relative_distance};

/// Stations of a drag in each strip, and those of its judge.
const STATIONS: [usize; 2] = [3, 5];

/// A model with its estimated error.
#[derive(Clone, Debug)]
pub struct FittedOblique {
    /// The model, solved for 1 N.
    pub model: Oblique,
    /// Its mesh.
    pub mesh: MeshSpec,
    /// Relative L2 error at the problem's depths and at its radii on both sides of the needle, the
    /// larger of those of the displacement along it and across it in its plane.
    pub estimated_relative_error: f64,
    /// Whether the estimate meets the tolerance. If not, this is the most accurate mesh that was
    /// judged.
    pub met: bool,
}

impl FittedOblique {
    /// A description of the mesh for the user.
    #[must_use]
    pub fn mesh_in_words(&self) -> Phrase {
        phrase!("{mesh} for each harmonic", mesh = self.mesh.in_words())
    }
}

/// Finds the coarsest mesh whose relative error around the needle meets a tolerance.
///
/// # Errors
/// The first number of the question that is out of range, or a tolerance that is not a positive
/// number, or contrasts beyond double precision.
pub fn fit_oblique(question: &Problem3, tolerance: f64) -> Result<FittedOblique, AxisymmetricError> {
    fit_oblique_by(Judging::Second, question, tolerance)
}

/// Does the same with a given way of judging.
///
/// # Errors
/// Those of [`fit_oblique`].
pub fn fit_oblique_by(
    judging: Judging,
    question: &Problem3,
    tolerance: f64,
) -> Result<FittedOblique, AxisymmetricError> {
    question.check()?;
    Domain::Positive.check("tolerance", tolerance, "")?;
    match judging {
        Judging::First => first(question, tolerance),
        Judging::Second | Judging::Third | Judging::Fourth => second(question, tolerance),
    }
}

/// Solutions for the loads of an attempt.
pub struct Along {
    /// For each load the displacement along the needle at the question's depths, at its radii in
    /// the direction of the needle's inclination, in m/N.
    pub answers_m: Vec<Vec<f64>>,
    /// Estimated relative error of each.
    pub doubts: Vec<f64>,
}

/// Solves a question for several loads of one needle on a mesh of its own, as fine as judging a
/// tolerance requires. The question's own load is a drag over all of them, for which the mesh is
/// made.
///
/// # Errors
/// Those of [`fit_oblique`].
pub fn along_needle(question: &Problem3, loads: &[Load], tolerance: f64) -> Result<Along, AxisymmetricError> {
    question.check()?;
    Domain::Positive.check("tolerance", tolerance, "")?;
    let [_, more] = STATIONS;
    let answer = |mesh: &MeshSpec| each_along_needle_m(question, loads, mesh, more);
    let worst = |a: &Vec<Vec<f64>>, b: &Vec<Vec<f64>>| {
        a.iter().zip(b).map(|(a, b)| relative_distance(a, b)).fold(0.0, f64::max)
    };
    let judge = Judge::new(&question.flat, &FINE, tolerance, answer, worst)?;
    let doubts = (0..loads.len()).map(|at| judge.doubt_of(|a, b| relative_distance(&a[at], &b[at]))).collect();
    Ok(Along { answers_m: judge.answer, doubts })
}

/// Solutions for the loads of an attempt under a needle at each of some angles.
pub struct AlongAngles {
    /// As in [`Along`], ordered by angle.
    pub answers_m: Vec<Vec<f64>>,
    /// Estimated relative error of each, at the angle where it is largest.
    pub doubts: Vec<f64>,
    /// A description of the mesh for the user.
    pub mesh: Phrase,
    /// Unknowns of both harmonics.
    pub unknowns: usize,
    /// Maximum memory held at a time, in bytes.
    pub bytes: usize,
}

/// Solves a question on the needle for a needle at each of some angles to the normal, in rad, under
/// several loads, on the coarsest meshes that agree well enough for a tolerance. The question's own
/// load is a drag over all of them.
///
/// The tissue is solved once for all angles, under a push at each sample depth: the displacement of
/// a point under a load equals that along the load under a push at the point (Betti), since flat
/// layers are homogeneous along the skin. The clamped side, about a vertical through the push,
/// breaks this; two pushes, each sampled at the other's position, measure how much that matters.
///
/// # Errors
/// Those of [`fit_oblique`].
pub fn along_needle_at(
    question: &Problem3,
    loads: &[Load],
    tilts_rad: &[f64],
    tolerance: f64,
) -> Result<AlongAngles, AxisymmetricError> {
    let leaning = |tilt_rad: &f64| Problem3 { tilt_rad: *tilt_rad, ..question.clone() };
    tilts_rad.iter().map(leaning).try_for_each(|question| question.check())?;
    Domain::Positive.check("tolerance", tolerance, "")?;
    let depths_m = &question.flat.sample_depth_m;
    let (mut words, mut unknowns, mut bytes) = (Phrase::Data(String::new()), 0, 0);
    let answer = |mesh: &MeshSpec| {
        let pushes = Pushes::new(&under_no_samples(question, loads, mesh)?, mesh, depths_m)?;
        (words, unknowns, bytes) = (mesh.in_words(), pushes.unknowns(), pushes.bytes());
        Ok(pushes.answer(tilts_rad, loads))
    };
    let off = |a: &Vec<f64>, b: &Vec<f64>| {
        let of_angle = |(a, b)| relative_distance(a, b);
        a.chunks(depths_m.len()).zip(b.chunks(depths_m.len())).map(of_angle).fold(0.0, f64::max)
    };
    let worst = |a: &Vec<Vec<f64>>, b: &Vec<Vec<f64>>| a.iter().zip(b).map(|(a, b)| off(a, b)).fold(0.0, f64::max);
    let judge = Judge::new(&question.flat, &WHOLE, tolerance, answer, worst)?;
    let sides = doubts_of_side(depths_m, loads, &judge.answer);
    let doubt = |(at, side): (usize, &f64)| judge.change_of(|a, b| off(&a[at], &b[at])) + side;
    let doubts = sides.iter().enumerate().map(doubt).collect();
    Ok(AlongAngles { answers_m: judge.answer, doubts, mesh: words, unknowns, bytes })
}

/// Influence of the side on each load, relative to its displacement: the largest difference, at any
/// angle, between the displacement at the other depths under a push at an end of the load, and that
/// at this end under pushes there.
fn doubts_of_side(depths_m: &[f64], loads: &[Load], answers_m: &[Vec<f64>]) -> Vec<f64> {
    let pushes = depths_m.iter().enumerate().filter_map(|(sample, &depth_m)| {
        let load = loads.iter().position(|load| load.kind == LoadKind::Contactor { depth_m })?;
        Some((sample, load))
    });
    let pushes: Vec<(usize, usize)> = pushes.collect();
    let doubt = |(load, answer_m): (&Load, &Vec<f64>)| {
        let ends = pushes.iter().filter(|(sample, _)| load.ends_m().contains(&depths_m[*sample]));
        let at_end = |&(own, end): &(usize, usize)| {
            let angles = answer_m.chunks(depths_m.len()).enumerate();
            let off = |(angle, of_angle_m): (usize, &[f64])| {
                let first = angle * depths_m.len();
                let there_and_here =
                    pushes.iter().map(|&(sample, push)| answers_m[end][first + sample] - answers_m[push][first + own]);
                there_and_here.map(|off_m| off_m * off_m).sum::<f64>().sqrt()
                    / of_angle_m.iter().map(|m| m * m).sum::<f64>().sqrt()
            };
            angles.map(off).fold(0.0, f64::max)
        };
        ends.map(at_end).fold(0.0, f64::max)
    };
    loads.iter().zip(answers_m).map(doubt).collect()
}

/// The question without samples, with a mesh checked for every load.
fn under_no_samples(question: &Problem3, loads: &[Load], mesh: &MeshSpec) -> Result<Problem3, AxisymmetricError> {
    let mut asked_nowhere = question.clone();
    asked_nowhere.flat.sample_r_m.clear();
    asked_nowhere.flat.sample_depth_m.clear();
    for load in loads {
        mesh.check(&Problem { load: *load, ..asked_nowhere.flat.clone() })?;
    }
    Ok(asked_nowhere)
}

/// Displacement along the needle under each load, in m, on one mesh; an oblique drag with
/// `each_strip` stations in each strip. Zero where a sample lies outside the tissue.
pub(crate) fn each_along_needle_m(
    question: &Problem3,
    loads: &[Load],
    mesh: &MeshSpec,
    each_strip: usize,
) -> Result<Vec<Vec<f64>>, AxisymmetricError> {
    let asked_nowhere = under_no_samples(question, loads, mesh)?;
    if question.tilt_rad == 0.0 {
        let mut model = Axisymmetric::new(&asked_nowhere.flat, mesh)?;
        let answer = |load: &Load| {
            model.take(load);
            question.all_along_needle_m(&model)
        };
        return Ok(loads.iter().map(answer).collect());
    }
    let shared = SharedMesh::new(&asked_nowhere, mesh, each_strip)?;
    Ok(loads.iter().map(|load| question.all_along_needle_m(&shared.under(load))).collect())
}

fn second(question: &Problem3, tolerance: f64) -> Result<FittedOblique, AxisymmetricError> {
    let [few, more] = STATIONS;
    let answer = |mesh: &MeshSpec| Ok(sampled(question, &Oblique::new(question, mesh, more)?));
    let judge = Judge::new(&question.flat, &FINE, tolerance, answer, Sampled::distance)?;
    let fitted = |model: Oblique, mesh: MeshSpec| {
        let estimated_relative_error = sampled(question, &model).distance(&judge.answer) + judge.doubt;
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
        // An order halves the error, unless a corner at the side limits it.
        if error > 0.5 * std::mem::replace(&mut before, error) {
            mesh = mesh.graded_to_side();
        }
    }
    Ok(fitted(Oblique::new(question, &judge.coarser, more)?, judge.coarser.clone()))
}

/// Judges with the same mesh at two orders more, graded to the side and with more stations: the
/// method for recordings whose field names no way of judging.
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
        // An order halves the error, unless a corner at the side limits it.
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
    let [found, better] = [&model, &better].map(|model| sampled(question, model));
    let estimated_relative_error = found.distance_by(Judging::First, &better);
    let met = estimated_relative_error <= tolerance;
    Ok(FittedOblique { model, mesh, estimated_relative_error, met })
}

/// Displacement out of the body along the needle, and across it in its plane away from it, at the
/// problem's depths and at its radii from the needle on both sides.
fn sampled(question: &Problem3, model: &Oblique) -> Sampled {
    let (sine, cosine) = (libm::sin(question.tilt_rad), libm::cos(question.tilt_rad));
    let mut found = Sampled::default();
    for &depth_m in &question.flat.sample_depth_m {
        for x_m in question.flat.sample_r_m.iter().flat_map(|&r_m| [r_m, -r_m]) {
            let [out_m, along_m] = model.displacement_m(x_m + depth_m * libm::tan(question.tilt_rad), depth_m);
            let away = if x_m.is_sign_negative() { -1.0 } else { 1.0 };
            found.axial_m.push(cosine * out_m - sine * along_m);
            found.radial_m.push(away * (cosine * along_m + sine * out_m));
        }
    }
    found
}
