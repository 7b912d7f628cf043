//! Reports: speed against error, as CSV, Markdown and SVG plots. What the command `stylet bench` makes.

mod anatomy;
mod calibrate;
mod calibrate_fits;
mod calibrate_timed;
mod chart;
mod coupling;
mod curve;
mod encoder;
mod estimates;
mod fibres;
mod field;
mod force;
mod hard_cases;
mod head;
mod hiccup;
mod lumps;
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
mod threads;

use std::path::{Path, PathBuf};

use ::recording::Session;
use ::render::frame::{Frame, Stage};
use documents::ExerciseBundle;
pub use field::peers::{Peer, read as read_peers};
use haptics::device::Device;
use haptics::servo::Report;
use tissue::Specimen;

use crate::error::BenchError;

/// What there is to report on, in the order in which all of it is measured.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Subject {
    /// The force law.
    Force,
    /// The deforming tissue.
    Field,
    /// Claimed against true error on random tissues.
    Estimates,
    /// The force law and the tissue at their two rates.
    Coupling,
    /// Recordings.
    Recording,
    /// The interactive servo, on the clock.
    Servo,
    /// A device that falters or is lost in the tissue.
    Hiccup,
    /// The picture.
    Render,
    /// The hard cases.
    HardCases,
    /// Random needle motion.
    Soak,
    /// The virtual hands.
    Operators,
    /// Fits of curves whose truth is known.
    Calibrate,
    /// The metrics of scores, by virtual novices and experts.
    Metrics,
    /// Bodies from numbers beside published ones.
    Anatomy,
    /// Skins that bend and lumps in the layers.
    Lumps,
}

impl Subject {
    /// Every subject.
    pub const ALL: [Self; 15] = [
        Self::Force,
        Self::Field,
        Self::Estimates,
        Self::Coupling,
        Self::Recording,
        Self::Servo,
        Self::Hiccup,
        Self::Render,
        Self::HardCases,
        Self::Soak,
        Self::Operators,
        Self::Calibrate,
        Self::Metrics,
        Self::Anatomy,
        Self::Lumps,
    ];

    /// Its name on the command line and of its report.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Force => "force",
            Self::Field => "field",
            Self::Estimates => "estimates",
            Self::Coupling => "coupling",
            Self::Recording => "recording",
            Self::Servo => "servo",
            Self::Hiccup => "hiccup",
            Self::Render => "render",
            Self::HardCases => "hard-cases",
            Self::Soak => "soak",
            Self::Operators => "operators",
            Self::Calibrate => "calibrate",
            Self::Metrics => "metrics",
            Self::Anatomy => "anatomy",
            Self::Lumps => "lumps",
        }
    }

    /// Measures it, and writes its report; returns the files written.
    ///
    /// # Errors
    /// When the disk or the system refuses, and, once the report is written, when a bound is exceeded.
    pub fn report(self, order: &ReportOrder<'_>) -> Result<Vec<PathBuf>, BenchError> {
        let ReportOrder { folder, quick, peers, program } = *order;
        match self {
            Self::Force => force::measure(folder, quick),
            Self::Field => field::measure(folder, quick, peers),
            Self::Estimates => estimates::measure(folder, quick),
            Self::Coupling => coupling::measure(folder, quick),
            Self::Recording => recording::measure(folder, quick),
            Self::Servo => servo::measure(folder, quick, program),
            Self::Hiccup => hiccup::measure(folder, quick),
            Self::Render => render::measure(folder, quick, program),
            Self::HardCases => hard_cases::measure(folder, quick),
            Self::Soak => soak::measure(folder, quick),
            Self::Operators => operators::measure(folder, quick),
            Self::Calibrate => calibrate::measure(folder, quick),
            Self::Metrics => metrics::measure(folder, quick),
            Self::Anatomy => anatomy::measure(folder, quick),
            Self::Lumps => lumps::measure(folder, quick),
        }
    }
}

/// Where and how a report is made.
#[derive(Clone, Copy)]
pub struct ReportOrder<'a> {
    /// Folder for the files; older reports in it are replaced.
    pub folder: &'a Path,
    /// A hundredth is measured, to see that it works.
    pub quick: bool,
    /// What other solvers reach, shown beside the field.
    pub peers: &'a [Peer],
    /// The program whose servo and picture are measured.
    pub program: &'a dyn Program,
}

/// The program that is measured, in what it alone can do: draw an attempt, and let a device make one.
pub trait Program {
    /// What is constant in the pictures of an exercise on a specimen.
    ///
    /// # Errors
    /// When the tissue refuses.
    fn stage(&self, bundle: &ExerciseBundle, specimen: &Specimen) -> Result<Stage, BenchError>;

    /// The picture of an attempt that has not begun.
    fn still(&self, bundle: &ExerciseBundle) -> Frame;

    /// Begins an attempt with a device: recorded, and drawn as any is.
    ///
    /// # Errors
    /// When the recording cannot be begun, or the system gives no thread.
    fn begin(&self, attempt: DeviceAttempt, device: Box<dyn Device>) -> Result<Box<dyn OngoingAttempt>, BenchError>;
}

/// An attempt that a device is to make.
pub struct DeviceAttempt {
    /// The exercise.
    pub bundle: ExerciseBundle,
    /// What is punctured.
    pub specimen: Specimen,
    /// Who, on what, and when.
    pub session: Session,
    /// Where the recording will be.
    pub path: PathBuf,
}

/// An attempt in progress.
pub trait OngoingAttempt {
    /// The picture of now, and which time of the attempt it shows, in s.
    fn frame(&self) -> (Frame, f64);

    /// The servo's latest tick: its time, in s, and how many there were.
    fn latest(&mut self) -> Option<(f64, u64)>;

    /// Whether the servo has ended.
    fn has_ended(&self) -> bool;

    /// Stops it and finishes its recording.
    ///
    /// # Errors
    /// When the recording could not be kept, or the servo was stopped by a defect.
    fn stop(self: Box<Self>) -> Result<Report, BenchError>;
}

/// The value that a share of some values does not exceed; not a number where there is none.
fn quantile(values: &[f64], share: f64) -> f64 {
    assessment::statistics::quantile(values, share).unwrap_or(f64::NAN)
}

/// By which command and on what a result was measured, for the head of a Markdown file.
fn measured_on(what: Subject, quick: bool) -> String {
    head::measured_by(what, "", quick)
}
