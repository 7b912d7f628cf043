//! Meshes with their solutions, and the removal of orders that a tolerance does not need.

use super::{Axisymmetric, AxisymmetricError, MeshSpec};
use crate::{Problem, Sampled, relative_distance};

/// The components of a solution that are compared, and their weights.
#[derive(Clone, Copy, Debug)]
pub(super) enum AnswerView {
    /// The axial displacement, unweighted.
    Axial,
    /// Axial and radial displacement, each divided by its own norm, in m.
    Both {
        /// Norm of the axial displacement.
        axial_m: f64,
        /// Norm of the radial displacement; if 0, the component is ignored.
        radial_m: f64,
    },
}

impl AnswerView {
    /// Both components, divided by their norms in a solution.
    pub fn both(answer: &Sampled) -> Self {
        let size = |values: &[f64]| values.iter().map(|value| value * value).sum::<f64>().sqrt();
        Self::Both { axial_m: size(&answer.axial_m), radial_m: size(&answer.radial_m) }
    }

    /// The compared values of a solution.
    pub fn counted(self, answer: &Sampled) -> Vec<f64> {
        let share = |values: &[f64], size: f64| -> Vec<f64> {
            values.iter().filter(|_| size > 0.0).map(|value| value / size).collect()
        };
        match self {
            Self::Axial => answer.axial_m.clone(),
            Self::Both { axial_m, radial_m } => {
                [share(&answer.axial_m, axial_m), share(&answer.radial_m, radial_m)].concat()
            }
        }
    }
}

/// A mesh, its model and the compared values of its solution.
pub(super) struct Rung {
    pub mesh: MeshSpec,
    pub model: Axisymmetric,
    pub answer: Vec<f64>,
}

impl Rung {
    pub fn new(problem: &Problem, mesh: MeshSpec, view: AnswerView) -> Result<Self, AxisymmetricError> {
        let model = Axisymmetric::new(problem, &mesh)?;
        Ok(Self { answer: view.counted(&problem.sampled(&model)), mesh, model })
    }
}

/// Attempts to lower several strips together.
const TRIES: usize = 3;

/// The removal of orders that a tolerance does not need.
pub(super) struct Trimming<'a> {
    pub problem: &'a Problem,
    pub view: AnswerView,
    /// The compared values of a better solution.
    pub truth: &'a [f64],
    /// The relative distance from it to reach.
    pub aim: f64,
}

/// The effect of one order less in one strip.
struct Spare {
    strip: usize,
    /// Decrease of the factor's nonzeros.
    saved: f64,
    /// Change of the compared values.
    change: Vec<f64>,
}

impl Trimming<'_> {
    /// Relative distance of a rung from the better solution.
    pub fn error(&self, rung: &Rung) -> f64 {
        relative_distance(&rung.answer, self.truth)
    }

    /// Removes one order in as many strips as the tolerance allows. Small changes of the mesh are
    /// additive, so the effects of single strips predict that of several. The result is measured;
    /// if the error is too large, fewer strips are tried.
    pub fn trim(&self, rung: Rung) -> Result<Rung, AxisymmetricError> {
        let (spares, mut aim) = (self.spares(&rung)?, self.aim);
        for _ in 0..TRIES {
            let picked = self.pick(&rung, &spares, aim);
            if picked.is_empty() {
                break;
            }
            let trimmed = Rung::new(self.problem, lowered(&rung.mesh, &picked), self.view)?;
            let error = self.error(&trimmed);
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
            let lower = Rung::new(self.problem, lowered(&rung.mesh, &[strip]), self.view)?;
            let saved = rung.model.nonzeros() as f64 - lower.model.nonzeros() as f64;
            let change = lower.answer.iter().zip(&rung.answer).map(|(a, b)| a - b).collect();
            Ok(Spare { strip, saved, change })
        };
        strips.filter(|(_, strip)| strip.order > 1).map(spare).collect()
    }

    /// The strips to lower, ordered by the loss of accuracy per saving.
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
