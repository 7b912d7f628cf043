//! Schedule for warning and erasing inactive people.

use crate::Moment;

/// One day, in s.
const DAY_S: i64 = 86_400;
/// A twelfth of a year, in s.
const MONTH_S: i64 = 2_629_746;

/// Retention rule of a school.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct RetentionRule {
    /// Months of inactivity, of 30.44 days each, after which a person is erased.
    pub months: u32,
    /// Days between the warning and the erasure.
    pub warn_days: u32,
}

/// A warning of a person.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Warned {
    /// Time at which the letter was sent or given up, and the uptime of the service at that time,
    /// in s; `None` while it is being sent.
    pub told: Option<(Moment, i64)>,
}

/// The current time: by the clock, which may be wrong, and as uptime of the service.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Now {
    /// Clock time.
    pub at: Moment,
    /// Uptime of the service, in s.
    pub observed_s: i64,
}

/// Action for a person.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum RetentionAction {
    /// Warn the person.
    Warn,
    /// Warned; the letter has not been sent yet.
    Sending,
    /// Warned; at least this many whole days remain.
    Wait(i64),
    /// Erase the person.
    Erase,
    /// Withdraw the warning: the person was active again or is exempt, or the rule has changed.
    CallOff,
}

impl RetentionRule {
    /// Returns the time since which a person must have been active to need no warning. The warning
    /// comes `warn_days` before the end of the retention period.
    #[must_use]
    pub const fn warned_since(&self, now: Moment) -> Moment {
        now.plus_s(self.warn_days as i64 * DAY_S - self.months as i64 * MONTH_S)
    }
}

/// Returns the action for a person last active at `active_at`, if there is one. The warning must be
/// at least `warn_days` old both by the clock and by the uptime of the service, so that a clock
/// that is set ahead cannot bring the erasure forward.
#[must_use]
pub fn step(
    rule: Option<RetentionRule>,
    active_at: Moment,
    held: bool,
    warned: Option<Warned>,
    now: Now,
) -> Option<RetentionAction> {
    let Some(rule) = rule.filter(|rule| !held && active_at < rule.warned_since(now.at)) else {
        return warned.map(|_| RetentionAction::CallOff);
    };
    let Some(Warned { told }) = warned else { return Some(RetentionAction::Warn) };
    let Some((told_at, told_observed_s)) = told else { return Some(RetentionAction::Sending) };
    let days_s = i64::from(rule.warn_days) * DAY_S;
    let by_clock_s = (now.at.micros() - told_at.micros()) / 1_000_000;
    let by_service_s = now.observed_s - told_observed_s;
    let idle_s = (now.at.micros() - active_at.micros()) / 1_000_000 - i64::from(rule.months) * MONTH_S;
    let left_s = (days_s - by_clock_s).max(days_s - by_service_s).max(-idle_s);
    Some(if left_s <= 0 { RetentionAction::Erase } else { RetentionAction::Wait((left_s + DAY_S - 1) / DAY_S) })
}

#[cfg(test)]
mod tests {
    //! Checks that a clock set ahead erases no one before the announced time.

    use super::*;

    const RULE: RetentionRule = RetentionRule { months: 12, warn_days: 30 };

    fn now(days: i64, run_days: i64) -> Now {
        Now { at: Moment::from_micros(0).plus_s(days * DAY_S), observed_s: run_days * DAY_S }
    }

    /// Returns the action for a person who was active only on day 0.
    fn done(warned: Option<Warned>, now: Now) -> Option<RetentionAction> {
        step(Some(RULE), Moment::from_micros(0), false, warned, now)
    }

    fn told(day: i64, run_day: i64) -> Option<Warned> {
        Some(Warned { told: Some((Moment::from_micros(0).plus_s(day * DAY_S), run_day * DAY_S)) })
    }

    #[test]
    fn whoever_does_nothing_is_warned_then_erased() {
        assert_eq!(done(None, now(300, 300)), None);
        assert_eq!(done(None, now(336, 336)), Some(RetentionAction::Warn));
        assert_eq!(done(Some(Warned { told: None }), now(400, 400)), Some(RetentionAction::Sending));
        assert_eq!(done(told(336, 336), now(340, 340)), Some(RetentionAction::Wait(26)));
        assert_eq!(done(told(336, 336), now(366, 366)), Some(RetentionAction::Erase));
        assert_eq!(done(told(340, 340), now(366, 366)), Some(RetentionAction::Wait(4)), "never sooner than was said");
    }

    #[test]
    fn a_clock_that_is_set_erases_nobody() {
        for ahead in [0, 31, 365, 36_500] {
            assert_eq!(done(None, now(340 + ahead, 340)), Some(RetentionAction::Warn), "{ahead} days ahead");
            let step = done(told(336, 336), now(340 + ahead, 340));
            assert_eq!(
                step,
                Some(RetentionAction::Wait(26)),
                "{ahead} days ahead, the service has run for four days only"
            );
        }
        let back = done(told(336, 336), now(337, 400));
        assert_eq!(back, Some(RetentionAction::Wait(29)), "a clock that is set back keeps them longer");
        assert_eq!(
            done(told(336 + 365, 336), now(340, 340)),
            Some(RetentionAction::Wait(391)),
            "warned by a clock a year ahead"
        );
    }

    #[test]
    fn what_does_not_hold_any_more_is_called_off() {
        let late = now(400, 400);
        for (rule, active_day, held) in [(None, 0, false), (Some(RULE), 399, false), (Some(RULE), 0, true)] {
            let active_at = Moment::from_micros(0).plus_s(active_day * DAY_S);
            assert_eq!(step(rule, active_at, held, told(336, 336), late), Some(RetentionAction::CallOff));
            assert_eq!(step(rule, active_at, held, None, late), None);
        }
    }
}
