//! `stylet force`: the force law without a simulation.

use std::io::{self, Write};
use std::path::PathBuf;

use attempt::LoneNeedle;
use attempt::trajectory::{self, AxialSample};
use law::axial::{AxialOutput, Rupture};

use crate::exit::{Failure, Outcome};
use crate::progress::Progress;
use crate::{output, sources};

/// Columns of the table on standard output, in the order of the reference tables.
const HEADER: &str = "t_s,x_m,v_m_per_s,F_n,F_tip_n,F_rim_n,F_viscous_n,F_friction_n,F_cutting_n,depth_m,events";

/// Number of rows between two updates of the progress bar.
const ROWS_PER_UPDATE: u64 = 4096;

/// Compute the force of a needle along a given trajectory
///
/// Reads layers and needle from SCENE.json (SI units) and a trajectory with the columns t_s and
/// x_m, and prints a CSV table of the force and its components. The numbers are exact in double
/// precision. An unsound scene causes a warning and is still computed.
#[derive(clap::Args)]
#[command(after_help = "Example:\n  stylet force trocar.json --trajectory slow.csv > forces.csv")]
pub struct ForceArgs {
    /// Layers and needle with their effective values, in SI units
    #[arg(value_name = "SCENE.json")]
    scene: PathBuf,
    /// Samples of the tip's displacement: a header with t_s (s) and x_m (m); other columns are
    /// ignored
    #[arg(long, value_name = "T.csv")]
    trajectory: PathBuf,
}

/// Runs the command.
pub fn run(args: &ForceArgs) -> Outcome {
    let json = sources::read_text(&args.scene)?;
    let case = documents::force_case::parse(&args.scene.display().to_string(), &json)?;
    let needle = LoneNeedle::new(case).map_err(|error| Failure::refused(&args.scene, error))?;
    let trajectory = trajectory::read_axial(&args.trajectory)?;
    for unsound in needle.find_unsound_ruptures() {
        output::print_warning(format_args!("{}: unsound scene: {unsound}", args.scene.display()));
    }
    output::print_buffered(|out| table(&needle, &trajectory, out))
}

/// Runs the law over the trajectory and writes a row per sample.
fn table(needle: &LoneNeedle, trajectory: &[AxialSample], out: &mut dyn Write) -> io::Result<()> {
    let progress = Progress::new(trajectory.len() as u64, "computing");
    let mut rows = 0_u64;
    writeln!(out, "{HEADER}")?;
    needle.push_along(trajectory.iter().copied(), |sample, output, ruptures| {
        if rows.is_multiple_of(ROWS_PER_UPDATE) {
            progress.set(rows);
        }
        rows += 1;
        row(sample, output, ruptures, out)
    })
}

/// Writes one row. `{:?}` prints the shortest digits that parse to the same f64.
fn row(sample: &AxialSample, output: &AxialOutput, ruptures: &[Rupture], out: &mut dyn Write) -> io::Result<()> {
    let numbers = [
        sample.t_s,
        sample.x_m,
        output.v_m_per_s,
        output.total_n(),
        output.tip_n,
        output.rim_n,
        output.viscous_n,
        output.friction_n,
        output.cutting_n,
        output.depth_m,
    ];
    for number in numbers {
        write!(out, "{number:?},")?;
    }
    for (index, rupture) in ruptures.iter().enumerate() {
        let joint = if index == 0 { "" } else { "+" };
        write!(out, "{joint}{}:{}", rupture.contactor.name(), rupture.boundary)?;
    }
    writeln!(out)
}
