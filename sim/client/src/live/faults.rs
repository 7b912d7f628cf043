//! What a trainee and an instructor should know of a servo's troubles: each is said when it begins.

use haptics::safety::flags;
use haptics::servo::{Record, flags as servo_flags};

/// The same trouble is not said again before so many seconds have passed without it.
const QUIET_S: f64 = 10.0;

const TROUBLES: [(u32, &str); 6] = [
    (flags::HELD, "the device's reading was bad or missing: the last good one was held"),
    (flags::NOT_FINITE, "the force law gave no number: nothing was sent"),
    (flags::THERMAL, "the force was reduced to keep the device's motors cool"),
    (flags::WATCHDOG, "the watchdog cut the force"),
    (servo_flags::STALLED, "the computer stalled: a tick came more than a period late"),
    (servo_flags::REFUSED, "the device refused the force"),
];

/// Watches the flags of ticks.
#[derive(Clone, Copy, Debug)]
pub struct Faults {
    /// When each trouble was last seen, in s.
    last_s: [f64; TROUBLES.len()],
}

impl Default for Faults {
    fn default() -> Self {
        Self { last_s: [f64::NEG_INFINITY; TROUBLES.len()] }
    }
}

impl Faults {
    /// Watches a tick, and says what begins in it.
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
        begun
    }
}
