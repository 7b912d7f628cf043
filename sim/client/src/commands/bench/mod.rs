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
mod head;
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
use crate::{new_file, output};
use field::peers::{self, Peer};

/// Measure speed and error, and write CSV, Markdown and plots
///
/// force: error of the force law against tick rate and speed, time per tick, force against depth, what an encoder's steps make of
/// it. field: error of the tissue's displacement against unknowns, set-up and time per solve, for every model, with the planner's
/// choice marked, and other solvers in the same plots and tables with --peers. estimates: the error that a field claims against the error that it has, on a thousand
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
    /// With `field` or `all`: what other solvers reach, as tests/peers/run measures it, in the same plots and tables
    #[arg(long, value_name = "CSV")]
    peers: Option<PathBuf>,
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

/// The files written.
type Written = Result<Vec<PathBuf>, Failure>;

/// Measures into a folder, shortened or not.
#[derive(Clone, Copy)]
enum Measure {
    Alone(fn(&Path, bool) -> Written),
    /// Others are shown beside it.
    Beside(fn(&Path, bool, &[Peer]) -> Written),
}

/// What there is to measure, in the order of `all`.
const MEASURES: [(What, Measure); 13] = [
    (What::Force, Measure::Alone(force::measure)),
    (What::Field, Measure::Beside(field::measure)),
    (What::Estimates, Measure::Alone(estimates::measure)),
    (What::Coupling, Measure::Alone(coupling::measure)),
    (What::Recording, Measure::Alone(recording::measure)),
    (What::Servo, Measure::Alone(servo::measure)),
    (What::Hiccup, Measure::Alone(hiccup::measure)),
    (What::Render, Measure::Alone(render::measure)),
    (What::HardCases, Measure::Alone(hard_cases::measure)),
    (What::Soak, Measure::Alone(soak::measure)),
    (What::Operators, Measure::Alone(operators::measure)),
    (What::Calibrate, Measure::Alone(calibrate::measure)),
    (What::Metrics, Measure::Alone(metrics::measure)),
];

/// Runs the command.
pub fn run(args: &Args) -> Outcome {
    if args.peers.is_some() && !matches!(args.what, What::All | What::Field) {
        return Err(Failure::input("--peers: other solvers answer the cases of `field` alone"));
    }
    let peers = args.peers.as_deref().map_or(Ok(Vec::new()), peers::read)?;
    new_file::create_folder(&args.out)?;
    let mut written = Vec::new();
    for (what, measure) in MEASURES {
        if args.what == What::All || args.what == what {
            written.extend(match measure {
                Measure::Alone(measure) => measure(&args.out, args.quick)?,
                Measure::Beside(measure) => measure(&args.out, args.quick, &peers)?,
            });
        }
    }
    output::with(|out| written.iter().try_for_each(|path| writeln!(out, "{}", path.display())))
}

/// The value that a share of some values does not exceed; not a number where there is none.
fn quantile(values: &[f64], share: f64) -> f64 {
    assessment::statistics::quantile(values, share).unwrap_or(f64::NAN)
}

/// By which command and on what a result was measured, for the head of a Markdown file.
fn measured_on(what: What, quick: bool) -> String {
    head::measured_by(what, "", quick)
}
