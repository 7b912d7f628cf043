//! Reasons why a trainee may need help, and the rules by which they are found, as text.

use model::training::risk::{Concern, RUN, RiskRule, RuleSetting};

use crate::format;

/// Returns the kind of a concern, as a short label, and the reason.
#[must_use]
pub fn say_concern(concern: &Concern) -> (&'static str, String) {
    (name_rule(concern.rule()), say_concern_reason(concern))
}

/// Returns the short label of a rule.
#[must_use]
pub fn name_rule(rule: RiskRule) -> &'static str {
    match rule {
        RiskRule::NotBegun => tr!("Not started"),
        RiskRule::Failing => tr!("Stuck"),
        RiskRule::Falling => tr!("Declining"),
        RiskRule::Inactive => tr!("Inactive"),
    }
}

/// Describes a rule with its number.
#[must_use]
pub fn say_rule(of: RuleSetting) -> String {
    let n = of.number;
    match of.rule {
        RiskRule::NotBegun => trn!(
            "no attempt at an assignment {n} day before its due date, or later",
            "no attempt at an assignment {n} days before its due date, or later",
            n
        ),
        RiskRule::Failing => {
            trn!("{n} failed attempt in a row at an exercise", "{n} failed attempts in a row at an exercise", n)
        }
        RiskRule::Falling => trn!(
            "the mean of the last {run} scores at an exercise is at least {n} point below that of the {run} before",
            "the mean of the last {run} scores at an exercise is at least {n} points below that of the {run} before",
            n,
            run = RUN
        ),
        RiskRule::Inactive => trn!(
            "no attempt for {n} week in a course that is not passed",
            "no attempt for {n} weeks in a course that is not passed",
            n
        ),
    }
}

fn say_concern_reason(concern: &Concern) -> String {
    match concern {
        Concern::NotBegun { title, due_at } => {
            tr!("no attempt at “{title}”, due {date}", title = title, date = format::format_date(due_at.to_utc()))
        }
        Concern::Failing { title, fails, last_score, .. } => tr!(
            "{fails} failed attempts in a row at “{title}”, the last with {score} points",
            fails = fails,
            title = title,
            score = format::format_fixed(last_score, 0)
        ),
        Concern::Falling { title, from, to, .. } => tr!(
            "the mean of the last {run} attempts at “{title}” is {to}; the {run} attempts before had {from}",
            title = title,
            run = RUN,
            to = format::format_fixed(to, 0),
            from = format::format_fixed(from, 0)
        ),
        Concern::Inactive { days } => trn!("no attempt for {n} day", "no attempt for {n} days", *days),
    }
}

#[cfg(test)]
mod tests {
    use model::Moment;

    use super::*;

    #[test]
    fn a_concern_names_the_exercise_and_its_figures() {
        let failing = Concern::Failing { exercise: "b".to_owned(), title: "B".to_owned(), fails: 3, last_score: 41.0 };
        let (kind, reason) = say_concern(&failing);
        assert_eq!((kind, reason.as_str()), ("Stuck", "3 failed attempts in a row at “B”, the last with 41 points"));
        let due_at = Moment::from_micros(1_796_342_400_000_000);
        let (_, reason) = say_concern(&Concern::NotBegun { title: "B".to_owned(), due_at });
        assert_eq!(reason, "no attempt at “B”, due 4 Dec 2026");
    }

    #[test]
    fn a_rule_says_its_number() {
        let rule = |rule, number| say_rule(RuleSetting { number, ..RiskRule::usual(rule) });
        assert_eq!(rule(RiskRule::Inactive, 1), "no attempt for 1 week in a course that is not passed");
        assert!(
            rule(RiskRule::Falling, 10).contains("the last 3 scores") && rule(RiskRule::Failing, 3).starts_with("3 ")
        );
    }
}
