//! Retention: the rule that erases inactive people, and those whom it is about to affect.

use askama::Template;
use askama_web::WebTemplate;
use model::Role;
use model::privacy::retention::RetentionAction;
use serde::Deserialize;
use time::OffsetDateTime;

use crate::form::{FilledForm, read_ticked_box};
use crate::{Shell, format};

/// The page of the retention rule.
#[derive(Debug, Template, WebTemplate)]
#[template(path = "privacy/retention.html")]
pub struct RetentionPage {
    /// Page frame.
    pub shell: Shell,
    /// The form with the current rule, or with refused input.
    pub form: FilledForm<RetentionForm>,
    /// Whether the rule has just been saved.
    pub saved: bool,
    /// People whom the rule is about to affect.
    pub rows: Vec<IdleRow>,
    /// Number of further people not listed.
    pub more: usize,
    /// People on legal hold: address of their page, and name.
    pub held: Vec<(String, String)>,
}

/// Input of the form of the retention rule.
#[derive(Clone, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(default)]
pub struct RetentionForm {
    /// Months of inactivity; empty to keep accounts for ever.
    pub months: String,
    /// Days between warning and erasure.
    pub warn_days: String,
    /// Whether free texts are erased with people whom the rule erases.
    #[serde(deserialize_with = "read_ticked_box")]
    pub texts: bool,
    /// Whether recordings are erased with every person who is erased, by the rule or by hand.
    #[serde(deserialize_with = "read_ticked_box")]
    pub recordings: bool,
}

/// A person whom the rule is about to affect.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct IdleRow {
    /// Address of the person's page.
    pub href: String,
    /// Name.
    pub name: String,
    /// Role.
    pub role: Role,
    /// Time of the latest activity.
    pub active_at: OffsetDateTime,
    /// When the warning was sent.
    pub told_at: Option<OffsetDateTime>,
    /// Why the warning could not be sent.
    pub error: Option<String>,
    /// Next step for this person.
    pub step: RetentionAction,
}

impl IdleRow {
    fn next(&self) -> String {
        match self.step {
            RetentionAction::Warn => tr!("will be warned").to_owned(),
            RetentionAction::Sending => tr!("was warned; the email has not been sent yet").to_owned(),
            RetentionAction::Wait(days) => {
                trn!("will be erased in {n} day at the earliest", "will be erased in {n} days at the earliest", days)
            }
            RetentionAction::Erase => tr!("will be erased").to_owned(),
            RetentionAction::CallOff => tr!("is kept: the warning is withdrawn").to_owned(),
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
            error: Some("the mail server rejected the email".to_owned()),
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
