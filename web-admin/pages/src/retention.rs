//! How long the school keeps whoever does nothing any more, and whom its rule is about to take.

use askama::Template;
use askama_web::WebTemplate;
use model::Role;
use model::retention::RetentionAction;
use serde::Deserialize;
use time::OffsetDateTime;

use super::form::{FilledForm, read_ticked_box};
use super::{Shell, format};

/// The page.
#[derive(Debug, Template, WebTemplate)]
#[template(path = "retention.html")]
pub struct RetentionPage {
    /// Frame.
    pub shell: Shell,
    /// What is set, or was typed.
    pub form: FilledForm<RetentionForm>,
    /// The rule was just saved.
    pub saved: bool,
    /// Whom the rule is about to take.
    pub rows: Vec<IdleRow>,
    /// How many more there are.
    pub more: usize,
    /// Who is kept whatever the rule says: page and name.
    pub held: Vec<(String, String)>,
}

/// What is typed about the rule.
#[derive(Clone, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(default)]
pub struct RetentionForm {
    /// Months, empty for ever.
    pub months: String,
    /// Days.
    pub warn_days: String,
    /// Free texts go with whoever is erased by the rule.
    #[serde(deserialize_with = "read_ticked_box")]
    pub texts: bool,
    /// Recordings go with whoever is erased.
    #[serde(deserialize_with = "read_ticked_box")]
    pub recordings: bool,
}

/// Somebody whom the rule is about to take.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct IdleRow {
    /// Their page.
    pub href: String,
    /// Their name.
    pub name: String,
    /// Their role.
    pub role: Role,
    /// When they last did anything.
    pub active_at: OffsetDateTime,
    /// When their letter was out.
    pub told_at: Option<OffsetDateTime>,
    /// Why it was not.
    pub error: Option<String>,
    /// What comes next.
    pub step: RetentionAction,
}

impl IdleRow {
    fn next(&self) -> String {
        match self.step {
            RetentionAction::Warn => tr!("is warned").to_owned(),
            RetentionAction::Sending => tr!("was warned; the letter is not out yet").to_owned(),
            RetentionAction::Wait(days) => {
                trn!("is erased in {n} day at the earliest", "is erased in {n} days at the earliest", days)
            }
            RetentionAction::Erase => tr!("is erased").to_owned(),
            RetentionAction::CallOff => tr!("stays: the warning is called off").to_owned(),
        }
    }
}

impl RetentionPage {
    fn more_words(&self) -> String {
        trn!("And {n} more.", "And {n} more.", self.more)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::samples;

    #[test]
    fn whom_the_rule_takes_is_listed_with_why_and_when() {
        let steps = [
            RetentionAction::Warn,
            RetentionAction::Sending,
            RetentionAction::Wait(12),
            RetentionAction::Erase,
            RetentionAction::CallOff,
        ];
        let row = |step| IdleRow {
            href: "/people/1".to_owned(),
            name: "Ana <Ek>".to_owned(),
            role: Role::Trainee,
            active_at: samples::NOW,
            told_at: Some(samples::NOW),
            error: Some("the mail server refused it".to_owned()),
            step,
        };
        let typed = RetentionForm { months: "x".to_owned(), ..RetentionForm::default() };
        let mut page = RetentionPage {
            shell: samples::shell(Role::Administrator),
            form: FilledForm::refused(typed, "no".to_owned()),
            saved: true,
            rows: steps.map(row).to_vec(),
            more: 3,
            held: vec![("/people/2".to_owned(), "Bo".to_owned())],
        };
        let html = samples::keep_page("retention", &page);
        assert!(html.contains("12 days at the earliest") && html.contains("And 3 more"), "{html}");
        assert!(html.contains("/people/2") && html.contains("Ana &#60;Ek&#62;"), "{html}");
        (page.rows, page.more, page.held, page.saved) = (vec![], 0, vec![], false);
        assert!(samples::keep_page("retention-none", &page).contains("Nobody"), "an empty list says so");
    }
}
