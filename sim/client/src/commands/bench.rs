//! `stylet bench`: measures speed and error, as CSV, Markdown and SVG plots. The measurements are
//! defined in the bench crate; this file provides the command line, and the servo and renderer for
//! two of the reports.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use ::bench::error::BenchError;
use ::bench::report::{DeviceAttempt, OngoingAttempt, Program, ReportOrder, Subject, read_peers};
use ::render::frame::{Frame, Stage};
use clap::ValueEnum;
use documents::ExerciseBundle;
use haptics::device::Device;
use haptics::mapping::Mapping;
use haptics::servo::{Driven, Report};
use tissue::Specimen;

use crate::exit::{Failure, Outcome};
use crate::live::{Finished, Live, LiveTrial};
use crate::picture::{Look, Moment};
use crate::{new_file, output, picture};

/// Measure speed and error, and write CSV, Markdown and plots
///
/// force: error of the force law as a function of tick rate and speed, time per tick, force as a
/// function of depth, effect of an encoder's steps, a fascia under different angles of a bevel.
/// field: error of the tissue's displacement as a function of unknowns, set-up time and time per
/// solve, for every model, with the planner's choice marked, and other solvers in the same plots
/// and tables with --peers. estimates: estimated and true error of a field, on a thousand random
/// tissues; exit 1 if a bound is exceeded. coupling: error of the force that the field carries as a
/// function of its rate. recording: size, time to write a tick, speed of simulation, time and
/// memory to read and score. servo: a minute at 1 kHz in real time, lateness and compute time of
/// the ticks. hiccup: force on the hand when its device falters or is lost in the tissue. render:
/// time of a frame, for every view and quality. hard-cases: every hard case with its bound and the
/// measured value. soak: ten minutes of random needle motion in every shipped scene. operators:
/// forces and overshoots of the virtual operators in every shipped exercise. calibrate: how often
/// the 95 % intervals of fitted curves contain the true values, and whether wrong minima are
/// reported. metrics: whether the metrics of scores distinguish virtual experts from novices and
/// are reliable, and how tremor and rate affect them. anatomy: dimensions of a thousand seeded
/// bodies compared with published ones, and in how many a straight path between the spinous
/// processes reaches the flavum. lumps: errors, claims and the planner's choices for skins that
/// bend and inclusions in the layers. Use a release build for figures to report.
#[derive(clap::Args)]
#[command(after_help = "Example:\n  stylet bench --out bench")]
pub struct BenchArgs {
    /// What to measure
    #[arg(default_value = "all")]
    what: What,
    /// Folder for the results; created if it does not exist; existing results in it are replaced
    #[arg(long, value_name = "DIR")]
    out: PathBuf,
    /// Measure a hundredth of the cases, as a test
    #[arg(long)]
    quick: bool,
    /// With `field` or `all`: results of other solvers, measured by tests/peers/run, for the same
    /// plots and tables
    #[arg(long, value_name = "CSV")]
    peers: Option<PathBuf>,
}

/// The measurements.
#[derive(Clone, Copy, PartialEq, ValueEnum)]
enum What {
    /// Everything
    All,
    /// The force law
    Force,
    /// The deforming tissue
    Field,
    /// Estimated and true error on random tissues; exit 1 if a bound is exceeded
    Estimates,
    /// The force law and the tissue at their two rates
    Coupling,
    /// Recordings
    Recording,
    /// The interactive servo, in real time
    Servo,
    /// A device that falters or is lost in the tissue
    Hiccup,
    /// The renderer
    Render,
    /// The hard cases; exit 1 if one exceeds its bound
    HardCases,
    /// Random needle motion; exit 1 if a bound is exceeded
    Soak,
    /// The virtual operators; exit 1 if one inserts the needle beyond the hub
    Operators,
    /// Fits of curves with known parameters; exit 1 if intervals contain them too rarely or a wrong
    /// minimum is not reported
    Calibrate,
    /// The metrics of scores, by virtual novices and experts
    Metrics,
    /// Bodies from parameters compared with published dimensions
    Anatomy,
    /// Curved skins and inclusions in the layers: errors, claims and the planner's choices
    Lumps,
}

impl What {
    /// The subjects of the report, in order.
    fn subjects(self) -> Vec<Subject> {
        let one = |subject: &Subject| self.to_possible_value().is_some_and(|value| value.get_name() == subject.name());
        Subject::ALL.into_iter().filter(|subject| self == Self::All || one(subject)).collect()
    }
}

/// Runs the command.
pub fn run(args: &BenchArgs) -> Outcome {
    if args.peers.is_some() && !matches!(args.what, What::All | What::Field) {
        return Err(Failure::input("--peers: only `field` and `all` compare other solvers"));
    }
    let peers = args.peers.as_deref().map_or(Ok(Vec::new()), read_peers)?;
    new_file::create_folder(&args.out)?;
    let order = ReportOrder { folder: &args.out, quick: args.quick, peers: &peers, program: &ThisProgram };
    let mut written = Vec::new();
    for subject in args.what.subjects() {
        written.extend(subject.report(&order)?);
    }
    output::print_buffered(|out| written.iter().try_for_each(|path| writeln!(out, "{}", path.display())))
}

impl From<BenchError> for Failure {
    fn from(error: BenchError) -> Self {
        match error {
            BenchError::Input(lines) => Self::Input(lines),
            BenchError::Work(lines) => Self::Work(lines),
        }
    }
}

impl From<Failure> for BenchError {
    fn from(failure: Failure) -> Self {
        match failure {
            Failure::Input(lines) => Self::Input(lines),
            Failure::Work(lines) => Self::Work(lines),
            other @ (Failure::Found | Failure::ReaderGone) => Self::work(other),
        }
    }
}

/// The servo and the renderer of `stylet play`.
struct ThisProgram;

impl Program for ThisProgram {
    fn stage(&self, bundle: &ExerciseBundle, specimen: &Specimen) -> Result<Stage, BenchError> {
        Ok(picture::build_stage(Path::new("shipped scene"), bundle, specimen)?)
    }

    fn still(&self, bundle: &ExerciseBundle) -> Frame {
        Moment::before(bundle, &[]).frame(&Look::at(&bundle.scene, true), target_depth_m(bundle))
    }

    fn begin(&self, attempt: DeviceAttempt, device: Box<dyn Device>) -> Result<Box<dyn OngoingAttempt>, BenchError> {
        let DeviceAttempt { bundle, specimen, session, path } = attempt;
        let trial = LiveTrial { bundle, specimen: Arc::new(specimen), session, path, arm: None, key: None };
        Ok(Box::new(Live::start(trial, Mapping::in_patient_frame(), Driven::ByTimer(device))?))
    }
}

impl OngoingAttempt for Live {
    fn frame(&self) -> (Frame, f64) {
        let moment = self.shown().moment.clone();
        let bundle = &self.trial.bundle;
        (moment.frame(&Look::at(&bundle.scene, true), target_depth_m(bundle)), moment.sample.t_s)
    }

    fn latest(&mut self) -> Option<(f64, u64)> {
        Self::latest(self).map(|tick| (tick.record.t_s, tick.ticks))
    }

    fn has_ended(&self) -> bool {
        self.servo().ended().is_some()
    }

    fn stop(self: Box<Self>) -> Result<Report, BenchError> {
        let (_, Finished { report, kept }) = Self::stop(*self);
        kept.map_err(|unsaved| BenchError::work(&unsaved.why))?;
        report.ok_or_else(|| BenchError::work("the servo was stopped by a program error"))
    }
}

fn target_depth_m(bundle: &ExerciseBundle) -> f64 {
    bundle.exercise.target_depth_mm * 1e-3
}
