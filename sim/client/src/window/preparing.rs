//! An attempt in the making: force law, field and picture on a thread of their own, so that the window stays alive meanwhile.

use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::{AtomicU8, Ordering};
use std::thread::{self, JoinHandle};
use std::time::{Duration, Instant};

use documents::{ExerciseBundle, Patient};
use render::frame::Stage;
use tissue::Specimen;
use words::tr;

use crate::exit::Failure;
use crate::{clock, picture, sources};

/// A wait is worth a bar after so long.
const PATIENCE: Duration = Duration::from_millis(300);
/// What is made: the specimen, and its picture.
const PARTS: u8 = 2;

/// An attempt in the making.
pub struct Preparation {
    since: Instant,
    made: Arc<AtomicU8>,
    thread: JoinHandle<Result<PreparedAttempt, Failure>>,
}

/// What an attempt is made with.
pub struct PreparedAttempt {
    /// The exercise.
    pub bundle: ExerciseBundle,
    /// What the patient and the hand were drawn by.
    pub seed: u64,
    /// What is punctured.
    pub specimen: Arc<Specimen>,
    /// What is constant in its pictures.
    pub stage: Stage,
}

impl Preparation {
    /// Begins it.
    pub fn start(bundle: ExerciseBundle, seed: u64) -> Self {
        let made = Arc::new(AtomicU8::new(0));
        let progress = Arc::clone(&made);
        let thread = thread::spawn(move || {
            let file = PathBuf::from(&bundle.exercise.id);
            let patient = Patient::draw(&bundle.scene, seed);
            let specimen = Arc::new(sources::prepare_specimen(&file, &bundle, &patient)?);
            progress.store(1, Ordering::Relaxed);
            let stage = picture::build_stage(&file, &bundle, &specimen)?;
            progress.store(PARTS, Ordering::Relaxed);
            Ok(PreparedAttempt { bundle, seed, specimen, stage })
        });
        Self { since: clock::instant(), made, thread }
    }

    /// The share that is made, once that has taken so long that somebody might wonder.
    pub fn share(&self) -> Option<f32> {
        let made = self.made.load(Ordering::Relaxed);
        (self.since.elapsed() > PATIENCE).then(|| f32::from(made) / f32::from(PARTS))
    }

    /// Whether there is nothing left to wait for.
    pub fn is_over(&self) -> bool {
        self.thread.is_finished()
    }

    /// What was made; waits for it.
    ///
    /// # Errors
    /// When the law or the tissue refuse the scene.
    pub fn finish(self) -> Result<PreparedAttempt, Failure> {
        self.thread.join().unwrap_or_else(|_| Err(Failure::work(tr!("the patient could not be prepared"))))
    }
}
