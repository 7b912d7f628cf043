//! A source of motion with a progress bar.

use attempt::simulate::{Clock, MotionSource};
use law::operator::{Felt, Motion};

use crate::progress::Progress;

/// Number of ticks between two updates of the progress bar.
const TICKS_PER_UPDATE: u64 = 1000;

/// A source of motion that moves a progress bar.
pub struct WatchedSource {
    source: Box<dyn MotionSource>,
    progress: Progress,
    ticks: u64,
}

impl WatchedSource {
    /// Wraps a source; the bar ends at the clock's time limit.
    pub fn new(source: Box<dyn MotionSource>, clock: &Clock) -> Self {
        let most = (clock.time_limit_s * clock.tick_hz) as u64;
        Self { source, progress: Progress::new(most, "simulating"), ticks: 0 }
    }
}

impl MotionSource for WatchedSource {
    fn step(&mut self, dt_s: f64, felt: &Felt) -> Motion {
        self.ticks += 1;
        if self.ticks.is_multiple_of(TICKS_PER_UPDATE) {
            self.progress.set(self.ticks);
        }
        self.source.step(dt_s, felt)
    }
}
