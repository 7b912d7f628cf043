//! `stylet field`: the tissue model without a simulation.

mod answer;

use std::path::PathBuf;

use answer::FieldAnswer;
use clap::ValueEnum;
use documents::field_case::FieldCase;
use tissue::planner::PlanRequest;
use tissue::{Judging, Model};

use crate::exit::{Failure, Outcome};
use crate::{output, sources};

/// Compute how layered tissue deforms under a needle
///
/// Reads layers, a load at several depths and sample points from CASE.json (SI units), lets the
/// planner choose a model and a mesh for the tolerance, and prints the displacement at every sample
/// with the estimated error, the size of the model and the computing time. Displacements are along
/// +z, out of the body: a push is negative. Exits with status 1 and a warning if no available model
/// meets the tolerance.
#[derive(clap::Args)]
#[command(after_help = "Example:\n  stylet field lower_back.json --tolerance 0.001 --json")]
pub struct FieldArgs {
    /// The case, in SI units
    #[arg(value_name = "CASE.json")]
    case: PathBuf,
    /// Model of the tissue; auto lets the planner choose
    #[arg(long, default_value = "auto")]
    model: ModelChoice,
    /// Tolerated relative error over all samples, of the axial and of the radial displacement, 1e-6
    /// to 1
    #[arg(long, value_name = "E", default_value_t = 0.01)]
    tolerance: f64,
    /// Print the result as JSON
    #[arg(long)]
    json: bool,
    /// Print only the displacements, as a CSV table in m; the numbers are exact in double precision
    #[arg(long, conflicts_with = "json")]
    csv: bool,
}

/// The models that can be selected.
#[derive(Clone, Copy, ValueEnum)]
enum ModelChoice {
    Auto,
    Axisymmetric,
    MassSpring,
    Volumetric,
}

impl ModelChoice {
    fn model(self) -> Option<Model> {
        match self {
            Self::Auto => None,
            Self::Axisymmetric => Some(Model::Axisymmetric),
            Self::MassSpring => Some(Model::MassSpring),
            Self::Volumetric => Some(Model::Volumetric),
        }
    }
}

/// Runs the command.
pub fn run(args: &FieldArgs) -> Outcome {
    if !(1e-6..=1.0).contains(&args.tolerance) {
        return Err(Failure::input(format_args!("--tolerance: {}; allowed: 1e-6 to 1", args.tolerance)));
    }
    let json = sources::read_text(&args.case)?;
    let case: FieldCase = documents::field_case::parse(&args.case.display().to_string(), &json)?;
    let wish = PlanRequest { model: args.model.model(), tolerance: args.tolerance, judging: Judging::default() };
    let answer = FieldAnswer::new(&case, &wish).map_err(|error| Failure::refused(&args.case, error))?;
    match (args.json, args.csv) {
        (true, _) => output::print_json(&answer)?,
        (false, true) => output::print_buffered(|out| answer.write_table(&case, out))?,
        (false, false) => output::print_buffered(|out| answer.write(&case, out))?,
    }
    let Some(warning) = &answer.warning else { return Ok(()) };
    output::print_warning(warning);
    Err(Failure::Found)
}
