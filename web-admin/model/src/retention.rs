//! When whoever does nothing any more is warned, and when they are erased.

use crate::Moment;

/// A day, in s.
const DAY_S: i64 = 86_400;
/// A twelfth of a year, in s.
const MONTH_S: i64 = 2_629_746;

/// The rule of a school.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct RetentionRule {
    /// Months without anything done, of 30.44 days each, after which somebody is erased.
    pub months: u32,
    /// Days before that they are warned.
    pub warn_days: u32,
}

/// Somebody was warned.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Warned {
    /// When their letter was out or given up, by the clock, and by the time that the service has run, in s.
    pub told: Option<(Moment, i64)>,
}

/// Now: by the clock, which may be wrong, and by the time that the service has run, in s.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Now {
    /// By the clock.
    pub at: Moment,
    /// By the time that the service has run, in s.
    pub observed_s: i64,
}

/// What is to be done about somebody.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum RetentionAction {
    /// They are warned.
    Warn,
    /// They were warned, and their letter is not out yet.
    Sending,
    /// They were warned; so many whole days are left at least.
    Wait(i64),
    /// They are erased.
    Erase,
    /// They were warned, and are not to be erased: they have done something, or are on hold, or the rule is another one.
    CallOff,
}

impl RetentionRule {
    /// Since when somebody must have done something to be left alone: the warning comes before the end of their time.
    #[must_use]
    pub const fn warned_since(&self, now: Moment) -> Moment {
        now.plus_s(self.warn_days as i64 * DAY_S - self.months as i64 * MONTH_S)
    }
}

/// What is to be done about somebody who last did anything at `active_at`, if anything. Whoever is erased was told before, for the days of
/// the rule, by the clock and by the time that the service has run: no clock that is set brings that day nearer.
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
    //! A clock that is set ahead must not erase anybody who was not warned for as long as was promised.

    use super::*;

    const RULE: RetentionRule = RetentionRule { months: 12, warn_days: 30 };

    fn now(days: i64, run_days: i64) -> Now {
        Now { at: Moment::from_micros(0).plus_s(days * DAY_S), observed_s: run_days * DAY_S }
    }

    /// What is done about somebody who did something on day 0 only.
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
