//! A progress bar on standard error, and only where that is a terminal.

use indicatif::{ProgressBar, ProgressStyle};

/// How far a measurement has come, as a bar that disappears when dropped.
pub struct MeasurementProgress(ProgressBar);

impl MeasurementProgress {
    /// A bar of `total` steps, with a word on what is being done.
    pub fn new(total: u64, doing: &'static str) -> Self {
        let style = ProgressStyle::with_template("{msg:12} [{bar:40}] {percent:>3} %  {eta} left");
        let bar = ProgressBar::new(total).with_message(doing);
        // The template is a constant; should a later indicatif refuse it, its own default still shows progress.
        Self(match style {
            Ok(style) => bar.with_style(style.progress_chars("=> ")),
            Err(_) => bar,
        })
    }

    /// Moves the bar to `done` steps.
    pub fn set(&self, done: u64) {
        self.0.set_position(done);
    }

    /// Moves the bar on by `steps`.
    pub fn advance(&self, steps: u64) {
        self.0.inc(steps);
    }
}

impl Drop for MeasurementProgress {
    fn drop(&mut self) {
        self.0.finish_and_clear();
    }
}
