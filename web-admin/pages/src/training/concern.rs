//! Reasons why a trainee may need help, as text.

use model::training::progress::{Concern, DECLINE_RUN};

use crate::format;

/// Returns the kind of a concern, as a short label, and the reason.
#[must_use]
pub fn say_concern(concern: &Concern) -> (&'static str, String) {
    (name_concern(concern), say_concern_reason(concern))
}

fn name_concern(concern: &Concern) -> &'static str {
    match concern {
        Concern::Stuck { .. } => tr!("Stuck"),
        Concern::Declining { .. } => tr!("Declining"),
        Concern::Regressing { .. } => tr!("Regressing"),
        Concern::Inactive { .. } => tr!("Inactive"),
        Concern::NotStarted { .. } => tr!("Not started"),
    }
}

fn say_concern_reason(concern: &Concern) -> String {
    match concern {
        Concern::Stuck { title, fails, last_score } => tr!(
            "{fails} failed attempts in a row at “{title}”, the last with {score} points",
            fails = fails,
            title = title,
            score = format::format_fixed(last_score, 0)
        ),
        Concern::Declining { title, from, to } => tr!(
            "the mean of the last {run} attempts at “{title}” is {to}; the {run} attempts before had {from}",
            title = title,
            run = DECLINE_RUN,
            to = format::format_fixed(to, 0),
            from = format::format_fixed(from, 0)
        ),
        Concern::Regressing { title, since } => tr!(
            "mastery of “{title}” was lost again with the attempt of {date}",
            title = title,
            date = format::format_date(since)
        ),
        Concern::Inactive { days } => trn!("no attempt for {n} day", "no attempt for {n} days", *days),
        Concern::NotStarted { title } => tr!("“{title}” is due, and there is no attempt yet", title = title),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_concern_names_the_exercise_and_its_figures() {
        let stuck = Concern::Stuck { title: "B".to_owned(), fails: 3, last_score: 41.0 };
        let (kind, reason) = say_concern(&stuck);
        assert_eq!((kind, reason.as_str()), ("Stuck", "3 failed attempts in a row at “B”, the last with 41 points"));
    }
}
