//! The answer to a case: displacements, the model that found them, and what it cost.

use std::io::{self, Write};

use bench::timing::{self, TimingEffort, answer_s};
use documents::field_case::FieldCase;
use serde::Serialize;
use tissue::planner::{self, PlanError, PlanRequest};
use tissue::volumetric::Problem3;
use tissue::{FieldModel, Problem};

use crate::progress::Progress;

/// Columns of the table of `stylet field --csv`.
const TABLE_HEADER: &str = "load_depth_m,depth_m,r_m,u_axial_m,u_radial_m";

/// What `stylet field` prints.
#[derive(Serialize)]
pub struct FieldAnswer {
    /// The model that was used.
    model: &'static str,
    /// Why.
    reason: String,
    /// Unknowns of the largest load's model.
    unknowns: usize,
    /// Bytes of all loads' models.
    bytes: usize,
    /// Time to choose, mesh and factorise, over all loads, in s.
    setup_s: f64,
    /// Median time of a re-solve, or of a step, of the slowest load, in s.
    solve_s: f64,
    /// Median time of what a tick of the simulator pays for all samples, in s.
    answer_s: f64,
    /// Estimated relative error of the worst load, of the axial or of the radial displacement, whichever is larger.
    estimated_relative_error: f64,
    /// The tolerance that was asked for.
    tolerance: f64,
    /// The estimate meets it.
    met: bool,
    /// What is not as it was asked for.
    pub warning: Option<String>,
    /// One for each load depth.
    solutions: Vec<Solution>,
}

/// Displacements under the load at one depth: a row for each sample depth, a column for each sample radius.
#[derive(Clone, Serialize)]
struct Solution {
    /// Depth of the load, in m.
    depth_m: f64,
    /// Along +z, out of the body, in m.
    u_axial_m: Vec<Vec<f64>>,
    /// Outward, in m.
    u_radial_m: Vec<Vec<f64>>,
}

impl FieldAnswer {
    /// Answers a case.
    ///
    /// # Errors
    /// When no model can be made of it.
    pub fn new(case: &FieldCase, wish: &PlanRequest) -> Result<Self, PlanError> {
        let progress = Progress::new(case.problems.len() as u64, "solving");
        let mut answer: Option<Self> = None;
        for (at, (problem, &depth_m)) in case.problems.iter().zip(&case.load_depths_m).enumerate() {
            progress.advance(1);
            // A depth that is listed again is answered again, not planned again.
            let known = case.problems.iter().take(at).position(|known| known.load == problem.load);
            if let (Some(known), Some(answer)) = (known, &mut answer) {
                answer.solutions.push(Solution { depth_m, ..answer.solutions[known].clone() });
                continue;
            }
            let (planned, setup_s) = timing::once(|| planner::plan(&Problem3::flat(problem), wish));
            let planned = planned?;
            let mut field = planned.field;
            let solve_s = timing::median_s(TimingEffort::SLOW, || field.solve(case.force_n));
            let solution = Solution::new(field.as_ref(), problem, depth_m);
            let one = Self {
                model: field.model().name(),
                reason: planned.reason.to_string(),
                unknowns: field.unknowns(),
                bytes: field.bytes(),
                setup_s,
                solve_s,
                answer_s: answer_s(field.as_mut(), problem, case.force_n),
                estimated_relative_error: planned.estimated_relative_error,
                tolerance: wish.tolerance,
                met: planned.met,
                warning: None,
                solutions: vec![solution],
            };
            answer = Some(match answer {
                Some(before) => before.and(one),
                None => one,
            });
        }
        answer.map(Self::warned).ok_or(PlanError::NoLoad)
    }

    /// With what is not as it was asked for.
    fn warned(self) -> Self {
        let (tolerance, estimate) = (self.tolerance, self.estimated_relative_error);
        let why = || format!("the tolerance {tolerance} is not met: the estimated error is {estimate:.2e}");
        let warning = (!self.met).then(why);
        Self { warning, ..self }
    }

    /// Two loads' answers as one. The worse estimate brings its reason along.
    fn and(mut self, other: Self) -> Self {
        self.solutions.extend(other.solutions);
        let worse = other.estimated_relative_error > self.estimated_relative_error;
        Self {
            model: self.model,
            reason: if worse { other.reason } else { self.reason },
            unknowns: self.unknowns.max(other.unknowns),
            bytes: self.bytes + other.bytes,
            setup_s: self.setup_s + other.setup_s,
            solve_s: self.solve_s.max(other.solve_s),
            answer_s: self.answer_s.max(other.answer_s),
            estimated_relative_error: self.estimated_relative_error.max(other.estimated_relative_error),
            tolerance: self.tolerance,
            met: self.met && other.met,
            warning: None,
            solutions: self.solutions,
        }
    }

    /// For people.
    pub fn write(&self, case: &FieldCase, out: &mut dyn Write) -> io::Result<()> {
        writeln!(out, "{}: {}", self.model, self.reason)?;
        writeln!(
            out,
            "{} unknowns, {:.2} MB, estimated error {:.3} %",
            self.unknowns,
            self.bytes as f64 / 1e6,
            self.estimated_relative_error * 1e2
        )?;
        let (setup_ms, solve_us, answer_us) = (self.setup_s * 1e3, self.solve_s * 1e6, self.answer_s * 1e6);
        writeln!(out, "set-up {setup_ms:.2} ms, solve {solve_us:.2} µs, answer in a tick {answer_us:.2} µs")?;
        writeln!(
            out,
            "\n{:>14} {:>14} {:>14} {:>14} {:>14}",
            "load at mm", "depth mm", "r mm", "axial mm", "radial mm"
        )?;
        self.each_sample(case, |at_m| writeln!(out, "{}", at_m.map(|m| format!("{:>14.6}", m * 1e3)).join(" ")))
    }

    /// For programs: a table in m.
    pub fn write_table(&self, case: &FieldCase, out: &mut dyn Write) -> io::Result<()> {
        writeln!(out, "{TABLE_HEADER}")?;
        self.each_sample(case, |at_m| writeln!(out, "{}", at_m.map(|m| format!("{m:?}")).join(",")))
    }

    /// Depth of the load, depth, r, axial and radial displacement of every sample, in m, load after load and depth after depth.
    fn each_sample(&self, case: &FieldCase, mut write: impl FnMut([f64; 5]) -> io::Result<()>) -> io::Result<()> {
        let Some(first) = case.problems.first() else { return Ok(()) };
        for solution in &self.solutions {
            for (row, &depth_m) in first.sample_depth_m.iter().enumerate() {
                for (column, &r_m) in first.sample_r_m.iter().enumerate() {
                    let (axial_m, radial_m) = (solution.u_axial_m[row][column], solution.u_radial_m[row][column]);
                    write([solution.depth_m, depth_m, r_m, axial_m, radial_m])?;
                }
            }
        }
        Ok(())
    }
}

impl Solution {
    fn new(field: &dyn FieldModel, problem: &Problem, depth_m: f64) -> Self {
        let part = |component: usize| {
            let row = |&depth_m: &f64| {
                problem.sample_r_m.iter().map(|&r_m| field.displacement_m(r_m, depth_m)[component]).collect()
            };
            problem.sample_depth_m.iter().map(row).collect()
        };
        Self { depth_m, u_axial_m: part(0), u_radial_m: part(1) }
    }
}
