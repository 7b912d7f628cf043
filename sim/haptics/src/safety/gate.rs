//! The gate: force comes in by a ramp, at the start and whenever it was away, wherever the needle then is.
//!
//! A trainee who takes the handle up with the needle in the tissue must not be kicked, and one whose device was silent for a
//! moment must not go on in silence. So the gate closes at the start, after the watchdog and after a device came back, and begins to
//! open at once: over [`GateParams::ramp_s`], anchored at the needle, which the mapping has kept where it was.
//!
//! A gain that rises while the handle moves could give more than was taken: pushed in at a tenth of the force and let out at the
//! whole of it, a spring would drive the hand. The observer of [`super::passivity`] keeps the account through the ramp, and after it
//! until it is settled; where it is overdrawn the gate closes and begins anew.

/// How the gate opens.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GateParams {
    /// How long it takes to open, in s.
    pub ramp_s: f64,
}

impl Default for GateParams {
    /// Our choice: the largest force of a Touch comes at 2 N/s, which a hand follows.
    fn default() -> Self {
        Self { ramp_s: 1.5 }
    }
}

/// A stall of the ticks opens the gate no further than this would, in s.
const LONGEST_STEP_S: f64 = 0.01;

/// Closed by default.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct GateState {
    /// How far it is open: from 0 to 1.
    open: f64,
    /// When it was looked at last, in s; `None` before that.
    last_s: Option<f64>,
    /// It was wholly open with a settled account: the account is the damper's affair now.
    trusted: bool,
}

/// How the account of energy stands.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Account {
    /// More was given than was ever taken.
    Overdrawn,
    /// What the tissue may still give back was not all paid for.
    Open,
    /// Whatever the tissue may give back was paid for.
    Settled,
}

/// How far the gate is open at a time in s: from 0 to 1.
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
    //! The gate would be useless if it waited for a low force, and a kick if it opened at once.

    use super::*;

    const PERIOD_S: f64 = 1e-3;

    /// How far it is open after each of some ticks with an account that stands as told.
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
