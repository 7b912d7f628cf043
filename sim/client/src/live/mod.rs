//! An attempt in progress: the servo that feels, the recorder that writes, and what the window sees of both.

pub mod desk;
mod faults;
pub mod history;
pub mod open;
mod recorder;
mod shown;

use std::path::PathBuf;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use haptics::mapping::Mapping;
use haptics::scaling::Scaling;
use haptics::servo::{self, Driven, LatestReader, Report, Running, Setup};
use mechanics::puncture::PunctureParams;
use recording::Session;
use scene::{Channel, ExerciseBundle};

use crate::exit::Failure;

pub use recorder::{Kept, Unsaved, recover_left_behind};
pub use shown::{Phase, Said, Shown};

/// What an attempt is made of. Shared with the recorder's thread.
pub struct Trial {
    /// The exercise and its scene.
    pub bundle: ExerciseBundle,
    /// The force law of the session's patient.
    pub params: Arc<PunctureParams>,
    /// Who, on what, and when.
    pub session: Session,
    /// Where the recording will be.
    pub path: PathBuf,
}

/// An attempt in progress. Dropped, it stops with zero force on the device, and what was recorded is kept.
pub struct Live {
    /// What it is made of.
    pub trial: Arc<Trial>,
    /// What the device makes of the scene's forces.
    pub scaling: Scaling,
    running: Running,
    latest: LatestReader,
    recorder: recorder::Recorder,
}

/// What became of an attempt.
pub struct Finished {
    /// How the servo did; none if it was killed by a defect.
    pub report: Option<Report>,
    /// The recording, or what to save when the disk has refused.
    pub kept: Result<Kept, Box<Unsaved>>,
}

impl Live {
    /// Starts servo and recorder.
    ///
    /// # Errors
    /// When the recording cannot be begun, or the system gives no thread.
    pub fn start(trial: Trial, mapping: Mapping, driven: Driven) -> Result<Self, Failure> {
        let exercise = &trial.bundle.exercise;
        let reach = (exercise.target_depth_mm * 1e-3, trial.session.tick_hz);
        let mut setup = Setup::new(Arc::clone(&trial.params), mapping, driven.info(), reach);
        if !exercise.feedback.gives(Channel::Force) {
            setup.scaling.factor = 0.0;
        }
        let scaling = setup.scaling;
        let trial = Arc::new(trial);
        let draft = recorder::begin(&trial, &trial.path)?;
        let started = servo::start(setup, driven).map_err(|error| Failure::work(format_args!("servo: {error}")))?;
        let recorder = recorder::Recorder::start(Arc::clone(&trial), started.records, draft)?;
        Ok(Self { trial, scaling, running: started.running, latest: started.latest, recorder })
    }

    /// What there is to see of the attempt so far.
    pub fn shown(&self) -> MutexGuard<'_, Shown> {
        lock(self.recorder.shown())
    }

    /// The servo's latest tick.
    pub fn latest(&mut self) -> Option<&servo::Snapshot> {
        self.latest.read()
    }

    /// The servo.
    pub fn servo(&self) -> &Running {
        &self.running
    }

    /// Stops with zero force on the device and finishes the recording.
    pub fn stop(self) -> (Arc<Trial>, Finished) {
        let report = self.running.stop();
        let kept = self.recorder.finish(report.as_ref());
        (self.trial, Finished { report, kept })
    }
}

/// What a thread that panicked left in it is still true: every change is one whole tick.
fn lock(shown: &Mutex<Shown>) -> MutexGuard<'_, Shown> {
    shown.lock().unwrap_or_else(PoisonError::into_inner)
}
