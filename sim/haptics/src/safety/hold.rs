//! First link: replaces an implausible reading by the last good one, and then removes the force.
//!
//! Implausible are a missing reading, a number that is not finite, an orientation that is not a
//! rotation, a time that goes back and a jump. The last good reading is held for
//! [`HoldParams::hold_s`]; then the force ramps to zero in [`HoldParams::ramp_s`]. The same applies
//! to a device that repeats one reading, because a frozen device looks like that. Once the force is
//! zero, [`HoldParams::rejoin_readings`] readings in a row must agree with each other before the
//! device is trusted again, from its current position.

use crate::device::Reading;

/// Limits of plausible readings.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HoldParams {
    /// Time for which the last good reading is held at full force, in s.
    pub hold_s: f64,
    /// Time in which the force then ramps to zero, in s.
    pub ramp_s: f64,
    /// Fastest motion of a handle, in m/s.
    pub max_speed_m_per_s: f64,
    /// Position jump allowed in addition, in m.
    pub max_jump_m: f64,
    /// Tick period, in s.
    pub period_s: f64,
    /// Number of consecutive readings that must agree before a lost device is trusted again.
    pub rejoin_readings: u32,
}

/// Longest interval over which motion is judged, in s: 50 mm are a jump however long a tick took.
const LONGEST_MOTION_S: f64 = 0.008;

impl HoldParams {
    /// Our choice, for a tick period in s: 50 mm are a jump, a stab of 1 m/s is not.
    #[must_use]
    pub fn new(period_s: f64) -> Self {
        Self { hold_s: 0.02, ramp_s: 0.1, max_speed_m_per_s: 5.0, max_jump_m: 0.005, period_s, rejoin_readings: 50 }
    }

    /// Time without a good reading after which the force is zero, in s.
    #[must_use]
    pub fn gone_after_s(&self) -> f64 {
        self.hold_s + self.ramp_s
    }
}

/// State of the link.
#[derive(Clone, Copy, Debug, Default)]
pub struct HoldState {
    /// The last good reading, and its arrival in s of the servo's clock.
    good: Option<(Reading, f64)>,
    /// The force is zero: readings are checked, but not used.
    lost: bool,
    /// While lost: the last reading, and the number that have agreed.
    candidate: Option<(Reading, u32)>,
}

/// A reading as the rest of the servo sees it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Believed {
    /// The last good reading.
    pub reading: Reading,
    /// Fraction of the force to apply: 1, or less while ramping to zero.
    pub gain: f64,
    /// Whether the reading is held instead of the device's latest.
    pub held: bool,
    /// The device is trusted again, from its current position: previous positions are meaningless.
    pub rejoined: bool,
}

/// Judgement of a reading, compared with the previous one.
#[derive(Clone, Copy, PartialEq)]
enum Verdict {
    Good,
    Repeated,
    Bad,
}

/// Judges a reading at a time of the servo's clock, in s. Returns `None` until the first good one.
pub fn step(params: &HoldParams, state: &mut HoldState, now_s: f64, reading: Option<Reading>) -> Option<Believed> {
    let reading = reading.filter(is_sane);
    let Some((good, since_s)) = state.good else {
        let first = reading?;
        state.good = Some((first, now_s));
        return Some(Believed { reading: first, gain: 1.0, held: false, rejoined: false });
    };
    if state.lost {
        return Some(rejoin(params, state, now_s, reading).unwrap_or(Believed {
            reading: good,
            gain: 0.0,
            held: true,
            rejoined: false,
        }));
    }
    match (judge(params, &good, reading.as_ref()), reading) {
        (Verdict::Good, Some(reading)) => {
            state.good = Some((reading, now_s));
            Some(Believed { reading, gain: 1.0, held: false, rejoined: false })
        }
        (verdict, _) => {
            let over_s = now_s - since_s - params.hold_s;
            let gain = (1.0 - over_s / params.ramp_s).clamp(0.0, 1.0);
            state.lost = gain <= 0.0;
            Some(Believed { reading: good, gain, held: verdict == Verdict::Bad || over_s > 0.0, rejoined: false })
        }
    }
}

/// Checks the readings of a lost device; returns the reading from which it is trusted again.
fn rejoin(params: &HoldParams, state: &mut HoldState, now_s: f64, reading: Option<Reading>) -> Option<Believed> {
    let Some(reading) = reading else {
        state.candidate = None;
        return None;
    };
    let agreed = match state.candidate {
        Some((before, agreed)) => match judge(params, &before, Some(&reading)) {
            Verdict::Good => agreed + 1,
            Verdict::Repeated => agreed,
            Verdict::Bad => 0,
        },
        None => 0,
    };
    state.candidate = Some((reading, agreed));
    if agreed < params.rejoin_readings {
        return None;
    }
    *state = HoldState { good: Some((reading, now_s)), lost: false, candidate: None };
    Some(Believed { reading, gain: 1.0, held: false, rejoined: true })
}

/// Whether a reading is plausible by itself.
fn is_sane(reading: &Reading) -> bool {
    /// Allowed deviation of the square of an orientation's norm from 1.
    const UNIT_TOLERANCE: f64 = 1e-3;
    /// Greatest plausible distance of the handle from the middle of its workspace, in m.
    const FARTHEST_M: f64 = 10.0;
    reading.t_s.is_finite()
        && reading.position_m.iter().all(|part| part.abs() <= FARTHEST_M)
        && (reading.orientation.norm_squared() - 1.0).abs() <= UNIT_TOLERANCE
}

fn judge(params: &HoldParams, before: &Reading, reading: Option<&Reading>) -> Verdict {
    let Some(reading) = reading else { return Verdict::Bad };
    let passed_s = reading.t_s - before.t_s;
    if passed_s < 0.0 {
        return Verdict::Bad;
    }
    let way_m = (reading.position_m - before.position_m).norm();
    let allowed_m = params.max_jump_m + params.max_speed_m_per_s * passed_s.min(LONGEST_MOTION_S).max(params.period_s);
    if way_m > allowed_m {
        Verdict::Bad
    } else if passed_s > 0.0 {
        Verdict::Good
    } else {
        Verdict::Repeated
    }
}

#[cfg(test)]
#[expect(clippy::float_cmp, reason = "what is kept must be kept to the bit")]
mod tests {
    //! A reading is accepted, held or dropped exactly as the module documents. A link that accepts
    //! a jump pulls the needle through layers; one that holds for ever leaves the motors on.

    use nalgebra::{Quaternion, UnitQuaternion, Vector3};

    use super::*;

    const PERIOD_S: f64 = 1e-3;

    fn reading(t_s: f64, x_m: f64) -> Reading {
        Reading {
            t_s,
            position_m: Vector3::new(x_m, 0.0, 0.0),
            orientation: UnitQuaternion::identity(),
            buttons: 0,
            motor_heat: 0.0,
        }
    }

    /// Feeds 100 good readings at 1 kHz, then `ticks` readings of `bad` at the tick's time; returns
    /// the link's output for those.
    fn after_good(ticks: u32, bad: impl Fn(f64) -> Option<Reading>) -> Vec<Believed> {
        let params = HoldParams::new(PERIOD_S);
        let mut state = HoldState::default();
        let mut at =
            |tick: u32, reading| step(&params, &mut state, f64::from(tick) * PERIOD_S, reading).expect("begun");
        (0..100).for_each(|tick| assert!(!at(tick, Some(reading(f64::from(tick) * PERIOD_S, 0.0))).held));
        (100..100 + ticks).map(|tick| at(tick, bad(f64::from(tick) * PERIOD_S))).collect()
    }

    #[test]
    fn bad_reading_is_held_then_ramped_to_zero_and_stays_there() {
        let last_s = 99.0 * PERIOD_S;
        let not_unit = UnitQuaternion::new_unchecked(Quaternion::new(0.0, 0.0, 0.0, 0.0));
        type Case = (&'static str, Box<dyn Fn(f64) -> Option<Reading>>);
        let cases: [Case; 7] = [
            ("missing", Box::new(|_| None)),
            ("frozen", Box::new(move |_| Some(reading(last_s, 0.0)))),
            ("NaN", Box::new(|t| Some(reading(t, f64::NAN)))),
            ("infinite time", Box::new(|_| Some(reading(f64::INFINITY, 0.0)))),
            ("no rotation", Box::new(move |t| Some(Reading { orientation: not_unit, ..reading(t, 0.0) }))),
            ("backwards", Box::new(move |t| Some(reading(2.0 * last_s - t, 0.0)))),
            // Alternating, so that the new position is never accepted.
            (
                "jumps",
                Box::new(|t| {
                    Some(reading(t, 0.05 * if ((t / PERIOD_S) as u32).is_multiple_of(2) { 1.0 } else { 2.0 }))
                }),
            ),
        ];
        for (name, bad) in cases {
            let believed = after_good(400, bad);
            assert!(believed.iter().all(|b| b.reading == reading(last_s, 0.0)), "{name}: the last good one is held");
            assert!(believed[..19].iter().all(|b| b.gain == 1.0), "{name}: whole force at first");
            assert!(believed.windows(2).all(|b| b[1].gain <= b[0].gain), "{name}: the ramp only falls");
            assert!(believed[30].gain > 0.5 && believed[30].held, "{name}: a ramp, not a drop");
            assert!(believed[121..].iter().all(|b| b.gain == 0.0 && b.held), "{name}: gone after 120 ms");
        }
    }

    #[test]
    fn a_stab_is_motion_and_50_mm_in_a_tick_are_not() {
        let stab = after_good(50, |t| Some(reading(t, t - 0.099)));
        assert!(stab.iter().all(|b| !b.held && b.gain == 1.0), "1 m/s is believed");
        let jump = after_good(1, |t| Some(reading(t, 0.05)));
        assert!(jump[0].held);
    }

    #[test]
    fn one_bad_reading_among_good_ones_changes_nothing_else() {
        let believed = after_good(3, |t| Some(reading(t, if t < 0.1005 { f64::NAN } else { 0.0 })));
        assert!(believed[0].held && !believed[1].held && believed.iter().all(|b| b.gain == 1.0 && !b.rejoined));
    }

    #[test]
    fn returning_device_rejoins_at_its_position_once_readings_agree() {
        let believed = after_good(400, |t| Some(reading(t, 0.07)));
        let rejoined = believed.iter().position(|b| b.rejoined).expect("it comes back");
        assert!(rejoined >= 120 + 50, "at tick {rejoined}");
        assert!(believed[rejoined..].iter().all(|b| b.reading.position_m.x == 0.07 && b.gain == 1.0 && !b.held));
        assert_eq!(believed.iter().filter(|b| b.rejoined).count(), 1);
    }
}
