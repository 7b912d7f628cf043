//! The cheapest mesh that meets a tolerance, with an error that is measured and not hoped for.
//!
//! A ladder of meshes is climbed. Two rungs higher the error is about nine times smaller, so the distance between the
//! two answers, at the points where an answer is wanted, is the error of the lower one to about a tenth. The first rung
//! that meets the tolerance is then trimmed against the same higher rung: orders that the tolerance does not need go.

use super::grading::LEVELS;
use super::{Axisymmetric, AxisymmetricError, MeshSpec};
use crate::axial::Domain;
use crate::tissue::{FieldModel, Problem};

/// The level from which the side is suspected: below, everything is wrong.
const SUSPECT: usize = 7;

/// A model with what is known of its error.
#[derive(Clone, Debug)]
pub struct Fitted {
    /// The model, solved for 1 N.
    pub model: Axisymmetric,
    /// Its mesh.
    pub mesh: MeshSpec,
    /// Relative L2 error of the axial displacement over the problem's sample points.
    pub estimated_relative_error: f64,
    /// Whether the estimate meets the tolerance. Where not, this is the most accurate mesh there is.
    pub met: bool,
}

/// Passes over the strips in search of orders to spare: the third finds next to nothing.
const PASSES: usize = 2;

/// Share of the tolerance that is aimed at. The estimate is good to a few per cent, and the rest is for what the sample
/// points do not see.
const AIM: f64 = 0.8;

/// What the higher rung's own error may be, as a share of the tolerance, when the lower one is judged by it.
const DOUBT: f64 = 0.25;

/// Finds the cheapest mesh whose relative error over the problem's sample points meets a tolerance.
///
/// # Errors
/// The first number of the problem that is out of range, or a tolerance that is not a positive number, or contrasts
/// beyond double precision.
pub fn fit(problem: &Problem, tolerance: f64) -> Result<Fitted, AxisymmetricError> {
    problem.check()?;
    Domain::Positive.check("tolerance", tolerance, "")?;
    let aim = AIM * tolerance;
    let mut climb = Climb { problem, rungs: Vec::new(), to_side: false };
    let mut level = *LEVELS.start();
    while level <= *LEVELS.end() {
        climb.rungs.push(climb.rung(level, climb.to_side)?);
        if let Some((low, high)) = climb.met(aim) {
            let rung = Trimming { problem, truth: &high.answer, aim }.trim(low)?;
            return Ok(rung.fitted(&high, tolerance));
        }
        level = climb.next(level)?;
    }
    // Nothing judges the top of the ladder but the rung below, which is worse: the estimate is on the safe side.
    let top = climb.rungs.swap_remove(climb.rungs.len() - 1);
    let below = climb.rungs.swap_remove(climb.rungs.len() - 1);
    Ok(top.fitted(&below, tolerance))
}

/// The rungs climbed so far.
struct Climb<'a> {
    problem: &'a Problem,
    rungs: Vec<Rung>,
    /// Whether their meshes are graded to the side.
    to_side: bool,
}

impl Climb<'_> {
    fn rung(&self, level: usize, to_side: bool) -> Result<Rung, AxisymmetricError> {
        let mesh = MeshSpec::graded(self.problem, level as f64);
        Rung::new(self.problem, if to_side { mesh.graded_to_side() } else { mesh })
    }

    /// The rung that meets the aim and the one that shows it, if the highest rung does.
    fn met(&mut self, aim: f64) -> Option<(Rung, Rung)> {
        let [.., low, middle, high] = &self.rungs[..] else { return None };
        if low.error(high) > aim || middle.error(high) > DOUBT * aim {
            return None;
        }
        let (high, _, low) = (self.rungs.pop()?, self.rungs.pop(), self.rungs.pop()?);
        Some((low, high))
    }

    /// The level after this one. Where the side matters more than the order, the climb begins again two levels lower on
    /// meshes that are graded to it.
    fn next(&mut self, level: usize) -> Result<usize, AxisymmetricError> {
        if let [.., low, middle, _] = &self.rungs[..]
            && !self.to_side
            && level >= SUSPECT
        {
            let sided = self.rung(level - 2, true)?;
            if low.error(&sided) > low.error(middle) {
                self.to_side = true;
                self.rungs = vec![sided];
                return Ok(level - 1);
            }
        }
        Ok(level + 1)
    }
}

/// A mesh, its model and its axial displacement at the sample points, in m/N.
struct Rung {
    mesh: MeshSpec,
    model: Axisymmetric,
    answer: Vec<f64>,
}

impl Rung {
    fn new(problem: &Problem, mesh: MeshSpec) -> Result<Self, AxisymmetricError> {
        let model = Axisymmetric::new(problem, &mesh)?;
        let row = |&depth_m: &f64| problem.sample_r_m.iter().map(move |&r_m| (r_m, depth_m));
        let points = problem.sample_depth_m.iter().flat_map(row);
        let answer = points.map(|(r_m, depth_m)| model.displacement_m(r_m, depth_m)[0]).collect();
        Ok(Self { mesh, model, answer })
    }

    /// Relative distance to a better answer.
    fn error(&self, better: &Self) -> f64 {
        distance(&self.answer, &better.answer)
    }

    fn fitted(self, better: &Self, tolerance: f64) -> Fitted {
        let estimated_relative_error = self.error(better);
        let met = estimated_relative_error <= tolerance;
        Fitted { model: self.model, mesh: self.mesh, estimated_relative_error, met }
    }
}

/// Relative L2 distance of an answer to the truth. Where nothing moves there is nothing to be wrong about.
fn distance(answer: &[f64], truth: &[f64]) -> f64 {
    let wrong: f64 = answer.iter().zip(truth).map(|(a, t)| (a - t) * (a - t)).sum();
    let whole: f64 = truth.iter().map(|t| t * t).sum();
    if wrong == 0.0 { 0.0 } else { (wrong / whole).sqrt() }
}

/// The search for orders that a tolerance does not need.
struct Trimming<'a> {
    problem: &'a Problem,
    /// A better answer, in m/N.
    truth: &'a [f64],
    /// The error to end below.
    aim: f64,
}

/// What one order less in one strip does.
struct Spare {
    strip: usize,
    /// Numbers that the factor loses.
    saved: f64,
    /// Change of the answer, in m/N.
    change: Vec<f64>,
}

impl Trimming<'_> {
    fn trim(&self, mut rung: Rung) -> Result<Rung, AxisymmetricError> {
        for _ in 0..PASSES {
            match self.pass(&rung)? {
                Some(cheaper) => rung = cheaper,
                None => break,
            }
        }
        Ok(rung)
    }

    /// One order less in as many strips as the tolerance allows, if in any. Small changes of the mesh add up, so what
    /// each does alone tells what several do together; the result is measured all the same.
    fn pass(&self, rung: &Rung) -> Result<Option<Rung>, AxisymmetricError> {
        let mut picked = self.pick(rung, self.spares(rung)?);
        while !picked.is_empty() {
            let trimmed = Rung::new(self.problem, lowered(&rung.mesh, &picked))?;
            if distance(&trimmed.answer, self.truth) <= self.aim {
                return Ok(Some(trimmed));
            }
            picked.pop();
        }
        Ok(None)
    }

    fn spares(&self, rung: &Rung) -> Result<Vec<Spare>, AxisymmetricError> {
        let strips = rung.mesh.radial.iter().chain(&rung.mesh.axial).enumerate();
        let spare = |(strip, _): (usize, _)| {
            let lower = Rung::new(self.problem, lowered(&rung.mesh, &[strip]))?;
            let saved = rung.model.nonzeros() as f64 - lower.model.nonzeros() as f64;
            let change = lower.answer.iter().zip(&rung.answer).map(|(a, b)| a - b).collect();
            Ok(Spare { strip, saved, change })
        };
        strips.filter(|(_, strip)| strip.order > 1).map(spare).collect()
    }

    /// The strips to lower, those first that cost the least accuracy for what they save.
    fn pick(&self, rung: &Rung, mut spares: Vec<Spare>) -> Vec<usize> {
        let mut answer = rung.answer.clone();
        let mut picked = Vec::new();
        loop {
            let now = distance(&answer, self.truth);
            let after = |spare: &Spare| distance(&added(&answer, &spare.change), self.truth);
            let price = |spare: &Spare| (after(spare) * after(spare) - now * now) / spare.saved;
            let fits = (0..spares.len()).filter(|&at| after(&spares[at]) <= self.aim);
            let Some(best) = fits.min_by(|&a, &b| price(&spares[a]).total_cmp(&price(&spares[b]))) else {
                return picked;
            };
            let spare = spares.swap_remove(best);
            answer = added(&answer, &spare.change);
            picked.push(spare.strip);
        }
    }
}

fn added(answer: &[f64], change: &[f64]) -> Vec<f64> {
    answer.iter().zip(change).map(|(a, c)| a + c).collect()
}

/// A mesh with one order less in some strips, radial ones counted first.
fn lowered(mesh: &MeshSpec, strips: &[usize]) -> MeshSpec {
    let mut mesh = mesh.clone();
    for (at, strip) in mesh.radial.iter_mut().chain(&mut mesh.axial).enumerate() {
        strip.order -= usize::from(strips.contains(&at));
    }
    mesh
}
