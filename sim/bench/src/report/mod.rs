//! Reports of the command `stylet bench`: speed against error, as CSV, Markdown and SVG plots.

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

/// The subjects of reports, in the order in which they are measured.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Subject {
    /// The force law.
    Force,
    /// The deforming tissue.
    Field,
    /// Estimated and true error on random tissues.
    Estimates,
    /// The force law and the tissue at their different rates.
    Coupling,
    /// Recordings.
    Recording,
    /// The interactive servo, in real time.
    Servo,
    /// A device that falters or is lost in the tissue.
    Hiccup,
    /// Rendering.
    Render,
    /// The hard cases.
    HardCases,
    /// Random needle motion.
    Soak,
    /// The virtual hands.
    Operators,
    /// Fits of curves with known parameters.
    Calibrate,
    /// The metrics of scores, by virtual novices and experts.
    Metrics,
    /// Generated bodies compared with published data.
    Anatomy,
    /// Curved skins and inclusions.
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

    /// Returns the name on the command line, which is also that of the report.
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

    /// Measures the subject and writes its report; returns the files written.
    ///
    /// # Errors
    /// On an I/O or system error, and, after the report has been written, if a bound is exceeded.
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

/// Options of a report.
#[derive(Clone, Copy)]
pub struct ReportOrder<'a> {
    /// Folder for the files; older reports in it are replaced.
    pub folder: &'a Path,
    /// Whether to measure only about a hundredth, as a test of the report itself.
    pub quick: bool,
    /// Results of other solvers, shown together with the field's.
    pub peers: &'a [Peer],
    /// The program whose servo and rendering are measured.
    pub program: &'a dyn Program,
}

/// Functions that only the measured program provides: drawing an attempt, and running one with a
/// device.
pub trait Program {
    /// Prepares the constant part of the pictures of an exercise on a specimen.
    ///
    /// # Errors
    /// If the tissue cannot be drawn.
    fn stage(&self, bundle: &ExerciseBundle, specimen: &Specimen) -> Result<Stage, BenchError>;

    /// Returns the picture of an attempt that has not begun.
    fn still(&self, bundle: &ExerciseBundle) -> Frame;

    /// Begins an attempt with a device, recorded and drawn like any other.
    ///
    /// # Errors
    /// If the recording cannot be started, or if no thread can be created.
    fn begin(&self, attempt: DeviceAttempt, device: Box<dyn Device>) -> Result<Box<dyn OngoingAttempt>, BenchError>;
}

/// An attempt to run with a device.
pub struct DeviceAttempt {
    /// The exercise.
    pub bundle: ExerciseBundle,
    /// The specimen.
    pub specimen: Specimen,
    /// Metadata of the recording.
    pub session: Session,
    /// Path of the recording.
    pub path: PathBuf,
}

/// An attempt in progress.
pub trait OngoingAttempt {
    /// Returns the current picture, and the time of the attempt that it shows, in s.
    fn frame(&self) -> (Frame, f64);

    /// Returns the time of the servo's latest tick, in s, and the number of ticks.
    fn latest(&mut self) -> Option<(f64, u64)>;

    /// Returns whether the servo has ended.
    fn has_ended(&self) -> bool;

    /// Stops the attempt and finishes its recording.
    ///
    /// # Errors
    /// If the recording could not be saved, or if the servo panicked.
    fn stop(self: Box<Self>) -> Result<Report, BenchError>;
}

/// Returns a quantile of values; NaN without values.
fn quantile(values: &[f64], share: f64) -> f64 {
    assessment::statistics::quantile(values, share).unwrap_or(f64::NAN)
}

/// Returns the head of a Markdown report: command, versions and machine.
fn measured_on(what: Subject, quick: bool) -> String {
    head::measured_by(what, "", quick)
}
