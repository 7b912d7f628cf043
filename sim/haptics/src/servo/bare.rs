//! Timing baseline of the machine: the servo's thread with empty ticks.

use std::{io, thread};

use super::grid::TickGrid;
use super::{StartError, Times, priority, run};

/// Measures the lateness of `ticks` empty ticks in a thread with the servo's priority and wait.
/// Lateness of a servo beyond this is caused by the servo itself.
///
/// # Errors
/// If `rate_hz` is not positive and finite, or the thread cannot be created.
pub fn bare(rate_hz: f64, ticks: u32) -> Result<Times, StartError> {
    let (mut grid, mut lateness) = (TickGrid::new(rate_hz)?, Times::new()?);
    let count = move || {
        priority::raise(priority::SERVO);
        let sleeper = run::sleeper();
        for _ in 0..ticks {
            let moment = run::wait(&grid, sleeper);
            grid.stamp(moment.now_s);
            lateness.add(moment.late_s);
        }
        lateness
    };
    let counting = thread::Builder::new().name("bare timer".to_owned()).spawn(count)?;
    counting.join().map_err(|_| StartError::Thread(io::Error::other("it was stopped by a defect")))
}

#[cfg(test)]
mod tests {
    //! A baseline that skipped ticks, or accepted an invalid rate, would make the servo look better
    //! or worse than it is.

    use super::*;

    #[test]
    fn every_tick_is_counted_and_a_rate_that_is_none_refused() {
        assert_eq!(bare(1000.0, 20).expect("a thread").count(), 20);
        for rate_hz in [0.0, -1.0, f64::NAN, f64::INFINITY] {
            assert!(matches!(bare(rate_hz, 1), Err(StartError::Rate(_))));
        }
    }
}
