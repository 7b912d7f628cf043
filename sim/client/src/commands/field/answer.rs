//! The result of `stylet field`: displacements, the model that computed them, and its cost.

use std::io::{self, Write};

use bench::timing::{self, TimingEffort};
use documents::field_case::FieldCase;
use serde::Serialize;
use tissue::answer::{self, CaseAnswer, CaseQuestion, FieldSolution};
use tissue::planner::{PlanError, PlanRequest};

use crate::progress::Progress;

/// Columns of the table of `stylet field --csv`.
const TABLE_HEADER: &str = "load_depth_m,depth_m,r_m,u_axial_m,u_radial_m";

/// Output of `stylet field`.
#[derive(Serialize)]
pub struct FieldAnswer {
    /// The model that was used.
    model: &'static str,
    /// Reason for the choice of the model.
    reason: String,
    /// Unknowns of the largest model of all loads.
    unknowns: usize,
    /// Memory of the models of all loads, in bytes.
    bytes: usize,
    /// Time to choose, mesh and factorise, over all loads, in s.
    setup_s: f64,
    /// Median time of a further solve, or of a step, of the slowest load, in s.
    solve_s: f64,
    /// Median time per tick of the simulator for all samples, in s.
    answer_s: f64,
    /// Estimated relative error of the worst load, the larger of the axial and the radial
    /// displacement.
    estimated_relative_error: f64,
    /// The requested tolerance.
    tolerance: f64,
    /// Whether the estimate meets the tolerance.
    met: bool,
    /// A warning if the tolerance is not met.
    pub warning: Option<String>,
    /// One solution for each load depth.
    solutions: Vec<FieldSolution>,
}

impl FieldAnswer {
    /// Solves a case.
    ///
    /// # Errors
    /// If no model can be made of it.
    pub fn new(case: &FieldCase, wish: &PlanRequest) -> Result<Self, PlanError> {
        let progress = Progress::new(case.problems.len() as u64, "solving");
        let (mut setup_s, mut solve_s, mut answer_s) = (0.0, 0.0_f64, 0.0_f64);
        let (problems, load_depths_m) = (&case.problems[..], &case.load_depths_m[..]);
        let question = CaseQuestion { problems, load_depths_m, force_n: case.force_n, wish: *wish };
        let answer = CaseAnswer::find(&question, |problem| {
            progress.advance(1);
            let (planned, planned_in_s) = timing::once(|| answer::plan_flat(problem, wish));
            let mut planned = planned?;
            setup_s += planned_in_s;
            solve_s = solve_s.max(timing::median_s(TimingEffort::SLOW, || planned.field.solve(case.force_n)));
            answer_s = answer_s.max(timing::answer_s(planned.field.as_mut(), problem, case.force_n));
            Ok(planned)
        })?;
        Ok(Self {
            model: answer.model.name(),
            setup_s,
            solve_s,
            answer_s,
            warning: answer.warning(),
            reason: answer.reason,
            unknowns: answer.unknowns,
            bytes: answer.bytes,
            estimated_relative_error: answer.estimated_relative_error,
            tolerance: answer.tolerance,
            met: answer.met,
            solutions: answer.solutions,
        })
    }

    /// Writes the human-readable form.
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

    /// Writes the CSV table, in m.
    pub fn write_table(&self, case: &FieldCase, out: &mut dyn Write) -> io::Result<()> {
        writeln!(out, "{TABLE_HEADER}")?;
        self.each_sample(case, |at_m| writeln!(out, "{}", at_m.map(|m| format!("{m:?}")).join(",")))
    }

    /// Calls `write` with depth of the load, depth, r, axial and radial displacement of every
    /// sample, in m, ordered by load and depth.
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
