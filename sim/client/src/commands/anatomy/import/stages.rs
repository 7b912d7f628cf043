//! Progress of an import, shown if it takes longer than a second.

use std::time::{Duration, Instant};

use crate::clock;
use crate::progress::Progress;

/// Time before the progress bar appears.
const PATIENCE: Duration = Duration::from_secs(1);

/// Stages of an import.
pub struct Stages {
    began: Instant,
    bar: Option<Progress>,
    all: u64,
    done: u64,
}

impl Stages {
    /// An import with a number of stages.
    pub fn new(all: usize) -> Self {
        Self { began: clock::instant(), bar: None, all: all as u64, done: 0 }
    }

    /// Marks one more stage as completed.
    pub fn done(&mut self) {
        self.done += 1;
        if self.began.elapsed() > PATIENCE {
            self.bar.get_or_insert_with(|| Progress::new(self.all, "importing")).set(self.done);
        }
    }
}
