//! Messages about servo faults for trainees and instructors: each fault is reported when it begins,
//! and missing force also when it is back.

use haptics::safety::flags;
use haptics::servo::{Record, flags as servo_flags};
use phrase::sentence;

/// Time without a fault, in s, after which its next occurrence is reported again.
const QUIET_S: f64 = 10.0;
/// Time for which force must be present to count as back, in s.
const BACK_S: f64 = 0.2;

/// Messages by flag. A recording stores them in English; the window translates them.
const TROUBLES: [(u32, &str); 8] = [
    (flags::HELD, sentence!("the device's reading was invalid or missing: the last valid one was used")),
    (flags::NOT_FINITE, sentence!("the force law returned no valid number: no force was sent")),
    (flags::THERMAL, sentence!("the force was reduced to keep the device's motors cool")),
    (flags::WATCHDOG, sentence!("the watchdog cut the force")),
    (flags::UNFELT, sentence!("the hand receives less than half of the force")),
    (servo_flags::STALLED, sentence!("the computer stalled: a tick was more than one period late")),
    (servo_flags::REFUSED, sentence!("the device rejected the force")),
    (servo_flags::DISAGREES, sentence!("the device reports a different force from the one sent")),
];
const BACK: &str = sentence!("the hand receives the force again");

/// Watches the flags of ticks.
#[derive(Clone, Copy, Debug)]
pub struct Faults {
    /// Time at which each fault was last seen, in s.
    last_s: [f64; TROUBLES.len()],
    /// Time at which force was last missing, in s; `None` after its return was reported.
    missed_s: Option<f64>,
}

impl Default for Faults {
    fn default() -> Self {
        // Minus infinity, so that the first occurrence of a fault is reported.
        Self { last_s: [f64::NEG_INFINITY; TROUBLES.len()], missed_s: None }
    }
}

impl Faults {
    /// Checks a tick, and returns the messages of the faults that begin in it.
    pub fn watch(&mut self, record: &Record) -> Vec<&'static str> {
        let mut begun = Vec::new();
        for (&(flag, words), last_s) in TROUBLES.iter().zip(&mut self.last_s) {
            if record.flags & flag != 0 {
                if record.t_s - *last_s > QUIET_S {
                    begun.push(words);
                }
                *last_s = record.t_s;
            }
        }
        if record.flags & flags::UNFELT != 0 {
            self.missed_s = Some(record.t_s);
        }
        if self.missed_s.is_some_and(|missed_s| record.t_s - missed_s > BACK_S) {
            self.missed_s = None;
            begun.push(BACK);
        }
        begun
    }
}

#[cfg(test)]
mod tests {
    //! Fails if a fault is not reported, or is reported at every tick.

    use super::*;

    #[test]
    fn force_that_is_away_is_said_once_and_so_is_its_return() {
        let mut faults = Faults::default();
        let said: Vec<(u32, &str)> = (0..4000_u32)
            .flat_map(|tick| {
                let flags = if (1000..2000).contains(&tick) { flags::UNFELT } else { 0 };
                let record = Record { t_s: f64::from(tick) * 1e-3, flags, ..Record::default() };
                faults.watch(&record).into_iter().map(move |words| (tick, words))
            })
            .collect();
        assert_eq!(said.len(), 2, "{said:?}");
        assert_eq!(said[0], (1000, "the hand receives less than half of the force"));
        assert!((2199..2202).contains(&said[1].0) && said[1].1 == BACK, "{said:?}");
    }

    #[test]
    fn the_recordings_bit_is_the_safety_chains() {
        assert_eq!(recording::sample::flags::UNFELT, flags::UNFELT);
    }
}
