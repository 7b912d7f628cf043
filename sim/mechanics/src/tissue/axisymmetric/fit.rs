//! The cheapest mesh that meets a tolerance, with an error that is measured and not hoped for.
//!
//! The climb begins near the mesh that the reference cases need. Two orders more in every strip divide the error by about
//! nine, so the distance between the two answers, at the points where an answer is wanted, is the error of the lower one
//! to about a tenth. (Two, because one alone may add nothing where a field is nearly even; in every strip, because a
//! strip that never changed would pass for one that is exact.) The first mesh that its judge finds good enough is
//! trimmed against the same judge: orders that the tolerance does not need go.

use super::basis::MAX_ORDER;
use super::grading::{LEAST_ORDER, LEVELS};
use super::{Axisymmetric, AxisymmetricError, MeshSpec};
use crate::axial::Domain;
use crate::phrase::Phrase;
use crate::tissue::{Problem, relative_distance};

/// A model with what is known of its error.
#[derive(Clone, Debug)]
pub struct Fitted {
    /// The model, solved for 1 N.
    pub model: Axisymmetric,
    /// Its mesh.
    pub mesh: MeshSpec,
    /// Relative L2 error of the axial displacement over the problem's sample points. Blind where they see less than a
    /// thousandth of what the load does where it acts.
    pub estimated_relative_error: f64,
    /// Whether the estimate meets the tolerance. Where not, this is the most accurate mesh there is.
    pub met: bool,
}

impl Fitted {
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
pub fn rung(problem: &Problem, at: usize) -> Option<Result<Axisymmetric, AxisymmetricError>> {
    let level = LEVELS.clone().nth(at)?;
    // What does not make sense must be refused before a mesh is made of it.
    let checked = problem.check().map_err(AxisymmetricError::from);
    Some(checked.and_then(|()| Axisymmetric::new(problem, &MeshSpec::graded(problem, level as f64))))
}

/// Attempts at lowering several strips together.
const TRIES: usize = 3;

/// Share of the tolerance that is aimed at. The rest is for the judge's own error and for what the sample points do not
/// see.
const AIM: f64 = 0.8;

/// What is judged may be wrong by this many tolerances: its judge is then wrong by a sixth of one.
const DOUBT: f64 = 1.5;

/// Share of the tolerance that grading to the side may change. Where it changes more, or more than the orders of the
/// judge do, every mesh is graded to it.
const SIDE: f64 = 0.5;

/// Orders between what is judged and the judge.
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
pub fn fit(problem: &Problem, tolerance: f64) -> Result<Fitted, AxisymmetricError> {
    problem.check()?;
    Domain::Positive.check("tolerance", tolerance, "")?;
    let level = first_level(tolerance);
    let mesh = MeshSpec::graded(problem, level as f64);
    let mut climb = Climb { problem, tolerance, mesh, to_side: false, error: f64::INFINITY };
    for orders in 0..=MAX_ORDER - BETTER - level {
        if let Some((enough, judge)) = climb.judged(orders)? {
            let rung = Trimming { problem, truth: &judge.answer, aim: AIM * tolerance }.trim(enough)?;
            return Ok(rung.fitted(&judge, tolerance));
        }
    }
    let finest = if climb.to_side { climb.mesh } else { climb.mesh.graded_to_side() }.raised(MAX_ORDER);
    let judge = Rung::new(problem, finest.clone().halved())?;
    let top = Rung::new(problem, finest)?;
    Ok(top.fitted(&judge, tolerance))
}

/// The level to begin at.
pub(super) fn first_level(tolerance: f64) -> usize {
    let decades = libm::log10(0.01 / tolerance);
    let level = LEVEL_AT_1_PERCENT + LEVELS_PER_DECADE * decades + 0.5;
    (level as usize).clamp(LEAST_ORDER, MAX_ORDER - BETTER)
}

/// The search for a mesh that is good enough, and for its judge.
struct Climb<'a> {
    problem: &'a Problem,
    tolerance: f64,
    /// The mesh to begin with.
    mesh: MeshSpec,
    /// Whether it is graded to the side.
    to_side: bool,
    /// Error of the last rung.
    error: f64,
}

impl Climb<'_> {
    /// The mesh with so many orders more.
    fn rung(&self, orders: usize) -> Result<Rung, AxisymmetricError> {
        Rung::new(self.problem, self.mesh.clone().raised(orders))
    }

    /// A rung and its judge, if that can be trusted. The side is looked at when it can, and when an order more has not
    /// halved the error, as it would but for the corner there.
    fn pair(&mut self, orders: usize) -> Result<Option<(Rung, Rung)>, AxisymmetricError> {
        let (low, judge) = (self.rung(orders)?, self.rung(orders + BETTER)?);
        let error = low.error(&judge);
        let trusted = error <= DOUBT * self.tolerance;
        let stalled = error > 0.5 * std::mem::replace(&mut self.error, error);
        if !self.to_side && (trusted || stalled) {
            let sided = Rung::new(self.problem, low.mesh.clone().graded_to_side())?;
            if low.error(&sided) > if trusted { SIDE * self.tolerance } else { error } {
                self.to_side = true;
                self.mesh = self.mesh.clone().graded_to_side();
                return self.pair(orders);
            }
        }
        Ok(trusted.then_some((low, judge)))
    }

    /// A rung that meets the aim and the judge that shows it: the rung of so many orders more, or the next.
    fn judged(&mut self, orders: usize) -> Result<Option<(Rung, Rung)>, AxisymmetricError> {
        let Some((mut rung, judge)) = self.pair(orders)? else { return Ok(None) };
        let meets = |rung: &Rung| rung.error(&judge) <= AIM * self.tolerance;
        if !meets(&rung) {
            rung = self.rung(orders + 1)?;
        }
        Ok(if meets(&rung) { Some((rung, judge)) } else { None })
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
        Ok(Self { answer: problem.axial_m(&model), mesh, model })
    }

    /// Relative distance to a better answer.
    fn error(&self, better: &Self) -> f64 {
        relative_distance(&self.answer, &better.answer)
    }

    fn fitted(self, better: &Self, tolerance: f64) -> Fitted {
        let estimated_relative_error = self.error(better);
        let met = estimated_relative_error <= tolerance;
        Fitted { model: self.model, mesh: self.mesh, estimated_relative_error, met }
    }
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
    /// One order less in as many strips as the tolerance allows. Small changes of the mesh add up, so what each does
    /// alone tells what several do together. That is measured; where it is too much, less is tried.
    fn trim(&self, rung: Rung) -> Result<Rung, AxisymmetricError> {
        let (spares, mut aim) = (self.spares(&rung)?, self.aim);
        for _ in 0..TRIES {
            let picked = self.pick(&rung, &spares, aim);
            if picked.is_empty() {
                break;
            }
            let trimmed = Rung::new(self.problem, lowered(&rung.mesh, &picked))?;
            let error = relative_distance(&trimmed.answer, self.truth);
            if error <= self.aim {
                return Ok(trimmed);
            }
            aim *= self.aim / error;
        }
        Ok(rung)
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
    fn pick(&self, rung: &Rung, spares: &[Spare], aim: f64) -> Vec<usize> {
        let mut spares: Vec<&Spare> = spares.iter().collect();
        let mut answer = rung.answer.clone();
        let mut picked = Vec::new();
        loop {
            let now = relative_distance(&answer, self.truth);
            let after = |spare: &Spare| relative_distance(&added(&answer, &spare.change), self.truth);
            let price = |spare: &Spare| (after(spare) * after(spare) - now * now) / spare.saved;
            let fits = (0..spares.len()).filter(|&at| after(spares[at]) <= aim);
            let Some(best) = fits.min_by(|&a, &b| price(spares[a]).total_cmp(&price(spares[b]))) else {
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
