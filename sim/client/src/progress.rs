//! A progress bar on standard error, shown only on a terminal.

use std::io::Read;

use indicatif::{ProgressBar, ProgressStyle};

/// A bar that disappears when dropped.
pub struct Progress(ProgressBar);

impl Progress {
    /// A bar of `total` steps, labelled with the current work.
    pub fn new(total: u64, doing: &'static str) -> Self {
        let style = ProgressStyle::with_template("{msg:12} [{bar:40}] {percent:>3} %  {eta} left");
        let bar = ProgressBar::new(total).with_message(doing);
        // The template is a constant; if a later indicatif rejects it, its default style still
        // shows progress.
        Self(match style {
            Ok(style) => bar.with_style(style.progress_chars("=> ")),
            Err(_) => bar,
        })
    }

    /// A spinner that counts steps whose total is unknown.
    pub fn busy(doing: &'static str) -> Self {
        let bar = ProgressBar::new_spinner().with_message(doing);
        Self(match ProgressStyle::with_template("{spinner} {msg}, {pos} steps, {elapsed}") {
            Ok(style) => bar.with_style(style),
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

    /// Wraps a source, so that reading from it moves the bar.
    pub fn watch<'s, R: Read + 's>(&self, source: R) -> impl Read + use<'s, R> {
        self.0.wrap_read(source)
    }
}

impl Drop for Progress {
    fn drop(&mut self) {
        self.0.finish_and_clear();
    }
}
