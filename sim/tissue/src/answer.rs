//! Answers a case: one problem for each load depth, each planned and solved once, combined into one
//! answer.

use serde::Serialize;

use super::planner::{self, PlanError, PlanRequest, Planned};
use super::volumetric::Problem3;
use super::{FieldModel, Model, Problem};

/// A case: problems on one slab that differ in the depth of their load.
#[derive(Clone, Copy, Debug)]
pub struct CaseQuestion<'a> {
    /// The problems.
    pub problems: &'a [Problem],
    /// Depth of each load as given in the case, in m.
    pub load_depths_m: &'a [f64],
    /// Magnitude of the load, in N; positive pushes into the body.
    pub force_n: f64,
    /// Model and tolerance.
    pub wish: PlanRequest,
}

/// Displacements under the load at one depth: one row per sample depth, one column per sample
/// radius.
#[derive(Clone, Debug, Serialize)]
pub struct FieldSolution {
    /// Depth of the load, in m.
    pub depth_m: f64,
    /// Along +z, out of the body, in m.
    pub u_axial_m: Vec<Vec<f64>>,
    /// Outward, in m.
    pub u_radial_m: Vec<Vec<f64>>,
}

/// The answer to a case.
#[derive(Clone, Debug)]
pub struct CaseAnswer {
    /// The model that was used.
    pub model: Model,
    /// Reason for the model, of the load with the worst estimate.
    pub reason: String,
    /// Unknowns of the largest model of all loads.
    pub unknowns: usize,
    /// Memory of the models of all loads, in bytes.
    pub bytes: usize,
    /// Estimated relative error of the worst load, the larger of the axial and the radial
    /// displacement.
    pub estimated_relative_error: f64,
    /// The requested tolerance.
    pub tolerance: f64,
    /// Whether the estimate meets the tolerance.
    pub met: bool,
    /// One solution for each load depth.
    pub solutions: Vec<FieldSolution>,
}

impl CaseAnswer {
    /// Answers a case. `plan` makes the model of a problem, as [`plan_flat`] does; it may also
    /// measure time.
    ///
    /// # Errors
    /// If there is no problem, or no model can be made of one.
    pub fn find(
        question: &CaseQuestion<'_>,
        mut plan: impl FnMut(&Problem) -> Result<Planned, PlanError>,
    ) -> Result<Self, PlanError> {
        let problems = question.problems;
        let mut answer: Option<Self> = None;
        for (at, (problem, &depth_m)) in problems.iter().zip(question.load_depths_m).enumerate() {
            // A repeated depth reuses its answer; it is not planned again.
            let known = problems.iter().take(at).position(|known| known.load == problem.load);
            if let (Some(known), Some(answer)) = (known, &mut answer) {
                answer.solutions.push(FieldSolution { depth_m, ..answer.solutions[known].clone() });
                continue;
            }
            let mut planned = plan(problem)?;
            planned.field.solve(question.force_n);
            let one = Self {
                model: planned.field.model(),
                reason: planned.reason.to_string(),
                unknowns: planned.field.unknowns(),
                bytes: planned.field.bytes(),
                estimated_relative_error: planned.estimated_relative_error,
                tolerance: question.wish.tolerance,
                met: planned.met,
                solutions: vec![FieldSolution::read(planned.field.as_ref(), problem, depth_m)],
            };
            answer = Some(match answer {
                Some(before) => before.and(one),
                None => one,
            });
        }
        answer.ok_or(PlanError::NoLoad)
    }

    /// A warning if the tolerance is not met.
    #[must_use]
    pub fn warning(&self) -> Option<String> {
        let Self { tolerance, estimated_relative_error: estimate, met, .. } = self;
        (!met).then(|| format!("the tolerance {tolerance} is not met: the estimated error is {estimate:.2e}"))
    }

    /// Combines the answers of two loads. The worse estimate determines the reason.
    fn and(mut self, other: Self) -> Self {
        self.solutions.extend(other.solutions);
        let worse = other.estimated_relative_error > self.estimated_relative_error;
        Self {
            reason: if worse { other.reason } else { self.reason },
            unknowns: self.unknowns.max(other.unknowns),
            bytes: self.bytes + other.bytes,
            estimated_relative_error: self.estimated_relative_error.max(other.estimated_relative_error),
            met: self.met && other.met,
            ..self
        }
    }
}

impl FieldSolution {
    fn read(field: &dyn FieldModel, problem: &Problem, depth_m: f64) -> Self {
        let part = |component: usize| {
            let row = |&depth_m: &f64| {
                problem.sample_r_m.iter().map(|&r_m| field.displacement_m(r_m, depth_m)[component]).collect()
            };
            problem.sample_depth_m.iter().map(row).collect()
        };
        Self { depth_m, u_axial_m: part(0), u_radial_m: part(1) }
    }
}

/// Plans the model of a flat problem.
///
/// # Errors
/// If no model can be made of it.
pub fn plan_flat(problem: &Problem, wish: &PlanRequest) -> Result<Planned, PlanError> {
    planner::plan(&Problem3::flat(problem), wish)
}
