//! Prepares an attempt in a background thread: force law, field and picture. The window stays
//! responsive meanwhile.

use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::{AtomicU8, Ordering};
use std::thread::{self, JoinHandle};
use std::time::{Duration, Instant};

use attempt::fluoroscopy::Fluoroscope;
use documents::{Channel, ExerciseBundle, Patient};
use render::frame::Stage;
use tissue::Specimen;
use words::tr;

use crate::exit::Failure;
use crate::{clock, picture, sources};

/// Time after which a progress bar is shown.
const PATIENCE: Duration = Duration::from_millis(300);
/// Number of parts to prepare: the specimen, its picture, and its body under X-rays.
const PARTS: u8 = 3;

/// An attempt that is being prepared.
pub struct Preparation {
    since: Instant,
    made: Arc<AtomicU8>,
    thread: JoinHandle<Result<PreparedAttempt, Failure>>,
}

/// A prepared attempt.
pub struct PreparedAttempt {
    /// The exercise.
    pub bundle: ExerciseBundle,
    /// Seed of the patient and the virtual operator's hand.
    pub seed: u64,
    /// The tissue to puncture.
    pub specimen: Arc<Specimen>,
    /// The constant part of its pictures.
    pub stage: Stage,
    /// The C-arm, if the trainee is given X-rays.
    pub fluoroscope: Option<Fluoroscope>,
}

impl Preparation {
    /// Starts the preparation.
    pub fn start(bundle: ExerciseBundle, seed: u64) -> Self {
        let made = Arc::new(AtomicU8::new(0));
        let progress = Arc::clone(&made);
        let thread = thread::spawn(move || {
            let file = PathBuf::from(&bundle.exercise.id);
            let patient = Patient::draw(&bundle.scene, seed);
            let specimen = Arc::new(sources::prepare_specimen(&file, &bundle, &patient)?);
            progress.store(1, Ordering::Relaxed);
            let stage = picture::build_stage(&file, &bundle, &specimen)?;
            progress.store(2, Ordering::Relaxed);
            let is_given = bundle.exercise.feedback.gives(Channel::Fluoroscopy);
            let fluoroscope = is_given.then(|| Fluoroscope::new(&bundle)).transpose();
            let fluoroscope = fluoroscope.map_err(|why| Failure::refused(&file, why))?.flatten();
            progress.store(PARTS, Ordering::Relaxed);
            Ok(PreparedAttempt { bundle, seed, specimen, stage, fluoroscope })
        });
        Self { since: clock::instant(), made, thread }
    }

    /// Returns the completed fraction, once the preparation takes so long that a progress bar is
    /// shown.
    pub fn share(&self) -> Option<f32> {
        let made = self.made.load(Ordering::Relaxed);
        (self.since.elapsed() > PATIENCE).then(|| f32::from(made) / f32::from(PARTS))
    }

    /// Whether the preparation has ended.
    pub fn is_over(&self) -> bool {
        self.thread.is_finished()
    }

    /// Waits for the preparation; returns its result.
    ///
    /// # Errors
    /// If the law or the tissue rejects the scene.
    pub fn finish(self) -> Result<PreparedAttempt, Failure> {
        self.thread.join().unwrap_or_else(|_| Err(Failure::work(tr!("the patient could not be prepared"))))
    }
}
