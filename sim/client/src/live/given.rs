//! The part of the tissue's force that the hand receives, as text for the screen: it must not
//! announce a force that is absent.

use haptics::safety::{flags, passivity};
use haptics::servo::{Record, flags as servo_flags};
use nalgebra::Vector3;
use phrase::{Phrase, phrase};

/// Returns the force that the hand receives, in N.
pub fn given_n(record: &Record) -> f64 {
    norm_n(record.device_n)
}

/// Returns why the hand does not receive the tissue's force in a tick, for display in large
/// letters; `None` if it receives the intended force. `let_through` is the fraction of the force
/// that is sent.
pub fn withheld(record: &Record, let_through: f64) -> Option<Phrase> {
    let has = |flag: u32| record.flags & flag != 0;
    Some(if has(servo_flags::REFUSED) {
        phrase!("The device rejects the force: you feel nothing")
    } else if has(flags::WATCHDOG) {
        phrase!("The force is off: the computer or the device stalled")
    } else if has(flags::HELD) && let_through < 1.0 {
        phrase!("No data from the device: the force is off")
    } else if has(flags::GATED) && norm_n(record.force_n) > passivity::FELT_N {
        phrase!("The force is returning: {percent} %. Hold still", percent = Phrase::number(let_through * 100.0, 0))
    } else if has(servo_flags::DISAGREES) {
        phrase!("The device reports a different force from the one sent")
    } else {
        return None;
    })
}

fn norm_n(force_n: [f32; 3]) -> f64 {
    Vector3::from(force_n).cast::<f64>().norm()
}

#[cfg(test)]
mod tests {
    //! Fails if the text promises a force while the device is silent: the next pop would take the
    //! hand by surprise.

    use super::*;

    /// Returns the text for a tick with flags, the fraction of the force that is sent, and the
    /// law's force in N.
    fn said(flags: u32, let_through: f64, force_n: f32) -> Option<String> {
        let record = Record { flags, force_n: [0.0, 0.0, force_n], ..Record::default() };
        withheld(&record, let_through).map(|why| why.to_string())
    }

    #[test]
    fn every_way_in_which_force_is_kept_away_is_said() {
        assert_eq!(said(0, 1.0, 2.0), None);
        assert_eq!(said(flags::GATED, 0.4, 0.0), None, "nothing is kept away in the air");
        assert_eq!(said(flags::GATED, 0.43, 2.0).as_deref(), Some("The force is returning: 43 %. Hold still"));
        for flag in [flags::HELD, flags::WATCHDOG, servo_flags::REFUSED, servo_flags::DISAGREES] {
            assert!(said(flag, 0.0, 2.0).is_some());
        }
    }
}
