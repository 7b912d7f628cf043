//! The gate: the force is ramped in at the start and after every interruption, for any
//! position of the needle.
//!
//! A trainee who picks up the handle with the needle in the tissue must not be kicked, and one
//! whose device was silent for a moment must not continue without force. So the gate closes at the
//! start, after the watchdog has cut the force and after a device has come back, and immediately
//! begins to open over [`GateParams::ramp_s`], anchored at the needle, whose position the mapping
//! has kept.
//!
//! A gain that increases while the handle moves could return more energy than was put in: pushed in
//! at a tenth of the force and released at the full force, a spring would drive the hand. The
//! observer of [`super::passivity`] keeps the energy account during the ramp, and after it until
//! the account is settled; if it is overdrawn, the gate closes and starts again.

/// Parameters of the gate.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GateParams {
    /// Opening time, in s.
    pub ramp_s: f64,
}

impl Default for GateParams {
    /// Our choice: the maximum force of a Touch rises at 2 N/s, which a hand can follow.
    fn default() -> Self {
        Self { ramp_s: 1.5 }
    }
}

/// Longest tick that the ramp counts, in s: a stall opens the gate no further.
const LONGEST_STEP_S: f64 = 0.01;

/// State of the gate. Closed by default.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct GateState {
    /// Opening, from 0 to 1.
    open: f64,
    /// Time of the last step, in s; `None` before the first.
    last_s: Option<f64>,
    /// The gate was fully open with a settled account: from now on the damper alone keeps the
    /// account.
    trusted: bool,
}

/// State of the energy account.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Account {
    /// The hand was given more energy than it put in.
    Overdrawn,
    /// The energy that the tissue may still return is not fully covered.
    Open,
    /// All energy that the tissue may return is covered.
    Settled,
}

/// Returns the opening of the gate at a time in s, from 0 to 1.
pub fn step(params: &GateParams, state: &mut GateState, now_s: f64, account: Account) -> f64 {
    let passed_s = state.last_s.map_or(0.0, |last_s| (now_s - last_s).clamp(0.0, LONGEST_STEP_S));
    state.last_s = Some(now_s);
    if !state.trusted {
        let opened = (state.open + passed_s / params.ramp_s).min(1.0);
        state.open = if account == Account::Overdrawn { 0.0 } else { opened };
        state.trusted = state.open >= 1.0 && account == Account::Settled;
    }
    state.open
}

#[cfg(test)]
#[expect(clippy::float_cmp, reason = "what is kept must be kept to the bit")]
mod tests {
    //! The gate would be useless if it waited for a low force, and would kick if it opened at once.

    use super::*;

    const PERIOD_S: f64 = 1e-3;

    /// Opening after each of `ticks` ticks, with the account given per tick.
    fn opened(ticks: u32, account: impl Fn(u32) -> Account) -> Vec<f64> {
        let (params, mut state) = (GateParams::default(), GateState::default());
        (0..ticks).map(|tick| step(&params, &mut state, f64::from(tick) * PERIOD_S, account(tick))).collect()
    }

    #[test]
    fn it_opens_evenly_in_a_second_and_a_half() {
        let open = opened(2000, |_| Account::Open);
        assert_eq!(open[0], 0.0);
        assert!((open[750] - 0.5).abs() < 1e-9 && open[1400] < 1.0 && open[1501] == 1.0);
        assert!(open.windows(2).all(|pair| (0.0..7e-4).contains(&(pair[1] - pair[0]))));
    }

    #[test]
    fn overdrawn_it_begins_anew_until_all_was_paid_for() {
        let open = opened(8000, |tick| match tick {
            700 | 3000 | 6000.. => Account::Overdrawn,
            5000 => Account::Settled,
            _ => Account::Open,
        });
        assert_eq!((open[700], open[2300], open[3000]), (0.0, 1.0, 0.0));
        assert!((open[1450] - 0.5).abs() < 1e-9);
        assert!(open[4600..].iter().all(|&share| share == 1.0), "the damper does the rest");
    }

    #[test]
    fn a_stall_is_no_leap() {
        let (params, mut state) = (GateParams::default(), GateState::default());
        step(&params, &mut state, 0.0, Account::Settled);
        assert!(step(&params, &mut state, 5.0, Account::Settled) < 0.01);
    }
}
