//! The watchdog: missed deadlines, and a device that rejects forces, cut the force.
//!
//! A stall longer than [`WatchdogParams::longest_late_periods`] cuts at once; frequent late ticks
//! do too, counted by a leaky bucket that loses one for every tick on time. The force is released
//! again when the bucket is empty.

/// Trigger limits.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WatchdogParams {
    /// A tick later than this, in periods, cuts the force at once.
    pub longest_late_periods: f64,
    /// Increase of the bucket for a late tick.
    pub late_weight: u32,
    /// Size of the bucket.
    pub bucket: u32,
}

impl Default for WatchdogParams {
    /// Our choice: 20 periods, or one tick in ten late over some time.
    fn default() -> Self {
        Self { longest_late_periods: 20.0, late_weight: 10, bucket: 200 }
    }
}

/// State of the watchdog.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct WatchdogState {
    level: u32,
    barking: bool,
}

/// Returns whether the force is cut in this tick, given its lateness in periods and whether the
/// device accepted the last force.
pub fn step(params: &WatchdogParams, state: &mut WatchdogState, late_periods: f64, connected: bool) -> bool {
    let late = late_periods > 1.0 || late_periods.is_nan();
    state.level =
        if late { (state.level + params.late_weight).min(params.bucket) } else { state.level.saturating_sub(1) };
    let worst = !connected || late_periods > params.longest_late_periods || late_periods.is_nan();
    if worst {
        state.level = params.bucket;
    }
    state.barking = state.level >= params.bucket || (state.barking && state.level > 0);
    state.barking
}

#[cfg(test)]
mod tests {
    //! It must trigger on dangerous timing, ignore the jitter of any virtual machine, and release
    //! again.

    use super::*;

    #[test]
    fn long_stall_or_lost_device_cuts_force_for_200_good_ticks() {
        for (late_periods, connected) in [(21.0, true), (0.0, false), (f64::NAN, true)] {
            let (params, mut state) = (WatchdogParams::default(), WatchdogState::default());
            assert!(step(&params, &mut state, late_periods, connected));
            let quiet = (1..1000).find(|_| !step(&params, &mut state, 0.0, true));
            assert_eq!(quiet, Some(200));
        }
    }

    #[test]
    fn single_stalls_are_not_cut_and_frequent_ones_are() {
        let bark = |every: u32| {
            let (params, mut state) = (WatchdogParams::default(), WatchdogState::default());
            let late = |tick: u32| if tick.is_multiple_of(every) { 8.0 } else { 0.0 };
            (0..10_000).any(|tick| step(&params, &mut state, late(tick), true))
        };
        assert!(!bark(20), "one in twenty");
        assert!(bark(5), "one in five");
    }
}
