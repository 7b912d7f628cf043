//! What the machine gives at best: the servo's thread without a servo in it.

use std::{io, thread};

use super::grid::TickGrid;
use super::{StartError, Times, priority, run};

/// How late `ticks` ticks begin in a thread that has the servo's priority, waits as it does, and does nothing. What is
/// later than this in a servo is the servo's own.
///
/// # Errors
/// When the rate is none or the system gives no thread.
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
    //! A reference that skipped ticks, or took any rate for one, would flatter or condemn the servo.

    use super::*;

    #[test]
    fn every_tick_is_counted_and_a_rate_that_is_none_refused() {
        assert_eq!(bare(1000.0, 20).expect("a thread").count(), 20);
        for rate_hz in [0.0, -1.0, f64::NAN, f64::INFINITY] {
            assert!(matches!(bare(rate_hz, 1), Err(StartError::Rate(_))));
        }
    }
}
