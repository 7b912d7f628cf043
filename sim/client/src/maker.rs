//! Creates the session and the recording of an attempt with this program.

use std::io::{BufWriter, Write};
use std::path::Path;

use assessment::staging;
use documents::ExerciseBundle;
use recording::{Session, Writer};

use crate::clock;
use crate::exit::Failure;

/// The set-up of an attempt.
pub struct Maker<'a> {
    /// The device's name.
    pub device: &'a str,
    /// The device's largest force, in N; infinite for a virtual operator in a simulation.
    pub device_max_force_n: f64,
    /// Seed of the patient and the operator's hand.
    pub seed: u64,
    /// Servo rate, in Hz.
    pub tick_hz: f64,
}

impl Maker<'_> {
    /// Creates a session that starts now, without a trainee.
    pub fn session(&self, bundle: &ExerciseBundle) -> Session {
        let maker = staging::AttemptMaker {
            device: self.device,
            device_max_force_n: self.device_max_force_n,
            seed: self.seed,
            tick_hz: self.tick_hz,
            version: env!("CARGO_PKG_VERSION"),
            git: env!("STYLET_GIT_REVISION"),
        };
        maker.session(bundle, clock::new_session_id(), clock::now())
    }
}

/// Starts the recording of an attempt, with metadata, documents and pictures first.
///
/// # Errors
/// If writing fails.
pub fn begin_recording<W: Write>(
    file: W,
    session: &Session,
    bundle: &ExerciseBundle,
    path: &Path,
) -> Result<Writer<BufWriter<W>>, Failure> {
    staging::begin_recording(file, session, bundle)
        .map_err(|error| Failure::work(format_args!("{}: {error}", path.display())))
}
