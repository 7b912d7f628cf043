//! What was practised here before: the recordings beside which new ones are put, judged one after the other in a thread of its own.

use std::collections::BTreeMap;
use std::fs::{self, File};
use std::io::BufReader;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread;

use assessment::Assessment;
use recording::Recording;

/// Attempts that are looked at, the latest: a folder may hold years.
const MOST: usize = 200;

/// What became of somebody's attempts at an exercise.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Tally {
    /// Attempts that were judged.
    pub attempts: u32,
    /// Those that passed.
    pub passed: u32,
    /// The best score of 100.
    pub best: f64,
}

/// Tallies by the exercise's id, as far as they are known.
#[derive(Clone, Default)]
pub struct History {
    tallies: Arc<Mutex<BTreeMap<String, Tally>>>,
}

impl History {
    /// Begins to look through a folder for the attempts of a pseudonym.
    #[must_use]
    pub fn of_folder(folder: PathBuf, trainee: String) -> Self {
        let history = Self::default();
        let theirs = history.clone();
        // Without a thread nothing is known of before; that keeps nobody from practising.
        let _ = thread::Builder::new().name("history".to_owned()).spawn(move || theirs.look_through(&folder, &trainee));
        history
    }

    fn look_through(&self, folder: &Path, trainee: &str) {
        let listed = fs::read_dir(folder).into_iter().flatten().flatten().map(|entry| entry.path());
        let mut paths: Vec<PathBuf> =
            listed.filter(|path| path.extension().is_some_and(|extension| extension == "mcap")).collect();
        // Names begin with the time at which an attempt began.
        paths.sort();
        for path in paths.iter().rev().take(MOST) {
            let read = File::open(path).ok().and_then(|file| Recording::read(BufReader::new(file)).ok());
            let Some(recording) = read.filter(|recording| recording.session.trainee == trainee) else { continue };
            let judged = assessment::own_exercise(&recording).ok();
            if let Some(assessment) = judged.and_then(|bundle| assessment::assess(&recording, &bundle).ok()) {
                self.add(&recording.session.exercise_id, &assessment);
            }
        }
    }

    /// Adds an attempt.
    pub fn add(&self, exercise: &str, assessment: &Assessment) {
        let mut tallies = self.tallies.lock().unwrap_or_else(PoisonError::into_inner);
        let tally = tallies.entry(exercise.to_owned()).or_default();
        tally.attempts += 1;
        tally.passed += u32::from(assessment.passed);
        tally.best = tally.best.max(assessment.score);
    }

    /// What became of attempts at an exercise.
    #[must_use]
    pub fn tally(&self, exercise: &str) -> Tally {
        self.tallies.lock().unwrap_or_else(PoisonError::into_inner).get(exercise).copied().unwrap_or_default()
    }
}
