//! `stylet force`: the force law alone.

use std::io::{self, Write};
use std::path::PathBuf;

use law::axial::{self, AxialInput, AxialOutput, AxialParams, AxialScratch, AxialState, Rupture};
use law::soundness;

use crate::exit::{Failure, Outcome};
use crate::progress::Progress;
use crate::trajectory::{self, AxialSample};
use crate::{output, sources};

/// Columns of the table on standard output; those of the reference tables, in their order.
const HEADER: &str = "t_s,x_m,v_m_per_s,F_n,F_tip_n,F_rim_n,F_viscous_n,F_friction_n,F_cutting_n,depth_m,events";

/// How many rows pass between two looks at the progress bar.
const ROWS_PER_UPDATE: usize = 4096;

/// Compute the force of a needle along a given trajectory
///
/// Reads layers and needle from SCENE.json (SI units) and a trajectory with the columns t_s and x_m, and prints a CSV
/// table of the force and its parts. Numbers read back to the same bits. An unsound scene is warned of and computed.
#[derive(clap::Args)]
#[command(after_help = "Example:\n  stylet force trocar.json --trajectory slow.csv > forces.csv")]
pub struct ForceArgs {
    /// Layers and needle at their effective values, in SI
    #[arg(value_name = "SCENE.json")]
    scene: PathBuf,
    /// Samples of the tip's displacement: a header with t_s (s) and x_m (m); other columns are ignored
    #[arg(long, value_name = "T.csv")]
    trajectory: PathBuf,
}

/// Runs the command.
pub fn run(args: &ForceArgs) -> Outcome {
    let json = sources::read_text(&args.scene)?;
    let case = documents::force_case::parse(&args.scene.display().to_string(), &json)?;
    let params = AxialParams::new(case.spec).map_err(|error| Failure::refused(&args.scene, error))?;
    let trajectory = trajectory::read_axial(&args.trajectory)?;
    for unsound in soundness::find_unsound_ruptures(params.spec()) {
        output::print_warning(format_args!("{}: unsound scene: {unsound}", args.scene.display()));
    }
    let path_factor = 1.0 / libm::cos(case.angle_rad);
    output::print_buffered(|out| table(&params, path_factor, &trajectory, out))
}

/// Runs the law over the trajectory and writes a row per sample.
fn table(params: &AxialParams, path_factor: f64, trajectory: &[AxialSample], out: &mut dyn Write) -> io::Result<()> {
    let progress = Progress::new(trajectory.len() as u64, "computing");
    let (mut state, mut scratch) = (AxialState::new(params), AxialScratch::new(params));
    writeln!(out, "{HEADER}")?;
    for (index, sample) in trajectory.iter().enumerate() {
        let input = AxialInput { t_s: sample.t_s, x_m: sample.x_m, path_factor };
        let output = axial::step(params, &mut state, &mut scratch, &input);
        row(sample, &output, &scratch.ruptures, out)?;
        if index % ROWS_PER_UPDATE == 0 {
            progress.set(index as u64);
        }
    }
    Ok(())
}

/// Writes one row. `{:?}` is the shortest form of a number that reads back to the same f64.
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
