//! `stylet bench`: speed against error, as CSV, Markdown and SVG plots.

mod calibrate;
mod chart;
mod coupling;
mod curve;
mod encoder;
mod estimates;
mod field;
mod force;
mod hard_cases;
mod hiccup;
mod metrics;
mod motion;
mod operators;
mod pace;
mod recording;
mod render;
mod servo;
mod sheet;
mod soak;
mod specimen;

use std::path::{Path, PathBuf};

use clap::ValueEnum;

use crate::exit::{Failure, Outcome};
use crate::machine::{self, Machine};
use crate::{new_file, output};

/// Measure speed and error, and write CSV, Markdown and plots
///
/// force: error of the force law against tick rate and speed, time per tick, force against depth, what an encoder's steps make of
/// it. field: error of the tissue's displacement against unknowns, set-up and time per solve, for every model, with the planner's
/// choice marked and other solvers beside it. estimates: the error that a field claims against the error that it has, on a thousand
/// random tissues; exit 1 when a bound is exceeded. coupling: error of the force that the field carries against its rate. recording:
/// size, time to write a tick, speed of simulating, time and memory to read and score. servo: a minute at 1 kHz on the clock, how
/// late ticks begin and what they take. hiccup: what the hand is given when its device falters or is lost in the tissue. render:
/// time of a frame, for every view and step of quality. hard-cases: every hard case with its bound and what was measured. soak: ten
/// minutes of random needle motion on every shipped scene. operators: forces and overshoots of the virtual hands at every shipped
/// exercise. calibrate: how often the 95 % intervals of fitted curves hold what the curves were made from, and whether wrong minima
/// are said. metrics: whether the metrics of scores tell virtual experts from novices and agree with themselves, and what tremor
/// and rate do to them. Use a release build for figures to report.
#[derive(clap::Args)]
#[command(after_help = "Example:\n  stylet bench --out bench")]
pub struct Args {
    /// What to measure
    #[arg(default_value = "all")]
    what: What,
    /// Folder for the results; created if need be, older results in it are replaced
    #[arg(long, value_name = "DIR")]
    out: PathBuf,
    /// Measure a hundredth of it, to see that it works
    #[arg(long)]
    quick: bool,
}

/// What can be measured.
#[derive(Clone, Copy, PartialEq, ValueEnum)]
enum What {
    /// Everything
    All,
    /// The force law
    Force,
    /// The deforming tissue
    Field,
    /// Claimed against true error on random tissues; exit 1 when a bound is exceeded
    Estimates,
    /// The force law and the tissue at their two rates
    Coupling,
    /// Recordings
    Recording,
    /// The interactive servo, on the clock
    Servo,
    /// A device that falters or is lost in the tissue
    Hiccup,
    /// The picture
    Render,
    /// The hard cases; exit 1 when one exceeds its bound
    HardCases,
    /// Random needle motion; exit 1 when a bound is exceeded
    Soak,
    /// The virtual hands; exit 1 when one goes in beyond the hub
    Operators,
    /// Fits of curves whose truth is known; exit 1 when intervals hold it too seldom or a wrong minimum is not said
    Calibrate,
    /// The metrics of scores, by virtual novices and experts
    Metrics,
}

/// Measures into a folder, shortened or not, and returns the files written.
type Measure = fn(&Path, bool) -> Result<Vec<PathBuf>, Failure>;

/// What there is to measure, in the order of `all`.
const MEASURES: [(What, Measure); 13] = [
    (What::Force, force::measure),
    (What::Field, field::measure),
    (What::Estimates, estimates::measure),
    (What::Coupling, coupling::measure),
    (What::Recording, recording::measure),
    (What::Servo, servo::measure),
    (What::Hiccup, hiccup::measure),
    (What::Render, render::measure),
    (What::HardCases, hard_cases::measure),
    (What::Soak, soak::measure),
    (What::Operators, operators::measure),
    (What::Calibrate, calibrate::measure),
    (What::Metrics, metrics::measure),
];

/// Runs the command.
pub fn run(args: &Args) -> Outcome {
    new_file::create_folder(&args.out)?;
    let mut written = Vec::new();
    for (what, measure) in MEASURES {
        if args.what == What::All || args.what == what {
            written.extend(measure(&args.out, args.quick)?);
        }
    }
    output::with(|out| written.iter().try_for_each(|path| writeln!(out, "{}", path.display())))
}

/// The value that a share of some values does not exceed; not a number where there is none.
fn quantile(values: &[f64], share: f64) -> f64 {
    assessment::statistics::quantile(values, share).unwrap_or(f64::NAN)
}

/// On what a result was measured, for the head of a Markdown file.
fn measured_on(quick: bool) -> String {
    let Machine { cpu, threads, system } = Machine::this();
    let program = machine::program();
    let shortened = if quick { " **Shortened to a hundredth: not to be reported.**" } else { "" };
    format!("Measured with {program} on {cpu}, {threads} threads, {system}.{shortened}")
}
