//! The start gate: force is let in only while it is low, and then over a second.
//!
//! A trainee who takes the handle up with the needle in the tissue must not be kicked. The gate is closed at the start, after
//! the watchdog and after a device came back; it opens at the first tick whose force is low.

/// When the gate opens.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Params {
    /// Largest force at which it begins to open, in N.
    pub engage_n: f64,
    /// How long it takes to open, in s.
    pub ramp_s: f64,
}

impl Params {
    /// Our choice for a device of a largest force, in N: a tenth of it, and no more than 0.3 N.
    #[must_use]
    pub fn new(max_force_n: f64) -> Self {
        Self { engage_n: (0.1 * max_force_n).min(0.3), ramp_s: 1.0 }
    }
}

/// Closed by default.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct State {
    /// When it began to open, in s; `None` while closed.
    since_s: Option<f64>,
}

/// How far the gate is open at a time in s with a force in N wanted: from 0 to 1.
pub fn step(params: &Params, state: &mut State, now_s: f64, wanted_n: f64) -> f64 {
    if state.since_s.is_none() && wanted_n <= params.engage_n {
        state.since_s = Some(now_s);
    }
    state.since_s.map_or(0.0, |since_s| ((now_s - since_s) / params.ramp_s).clamp(0.0, 1.0))
}

#[cfg(test)]
#[expect(clippy::float_cmp, reason = "what is kept must be kept to the bit")]
mod tests {
    //! The gate would be useless if it opened on a high force, and a kick if it opened at once.

    use super::*;

    #[test]
    fn it_stays_shut_on_a_high_force_and_opens_over_a_second_once_low() {
        let params = Params::new(3.3);
        let mut state = State::default();
        let mut at = |now_s, wanted_n| step(&params, &mut state, now_s, wanted_n);
        assert_eq!(at(0.0, 2.0), 0.0);
        assert_eq!(at(5.0, 0.31), 0.0);
        assert_eq!(at(6.0, 0.3), 0.0, "it begins");
        assert!((at(6.25, 2.0) - 0.25).abs() < 1e-12, "and goes on although the force is high now");
        assert_eq!(at(7.0, 2.0), 1.0);
        assert_eq!(at(9.0, 2.0), 1.0);
    }

    #[test]
    fn a_weak_device_needs_a_lower_force() {
        assert!((Params::new(0.9).engage_n - 0.09).abs() < 1e-12);
    }
}
