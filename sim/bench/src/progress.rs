//! A progress bar on standard error, shown only on a terminal.

use indicatif::{ProgressBar, ProgressStyle};

/// Progress of a measurement; the bar disappears when dropped.
pub struct MeasurementProgress(ProgressBar);

impl MeasurementProgress {
    /// Creates a bar of `total` steps, with a label.
    pub fn new(total: u64, doing: &'static str) -> Self {
        let style = ProgressStyle::with_template("{msg:12} [{bar:40}] {percent:>3} %  {eta} left");
        let bar = ProgressBar::new(total).with_message(doing);
        // The template is a constant; if a later version of indicatif refuses it, the default style
        // still works.
        Self(match style {
            Ok(style) => bar.with_style(style.progress_chars("=> ")),
            Err(_) => bar,
        })
    }

    /// Sets the bar to `done` steps.
    pub fn set(&self, done: u64) {
        self.0.set_position(done);
    }

    /// Advances the bar by `steps`.
    pub fn advance(&self, steps: u64) {
        self.0.inc(steps);
    }
}

impl Drop for MeasurementProgress {
    fn drop(&mut self) {
        self.0.finish_and_clear();
    }
}
