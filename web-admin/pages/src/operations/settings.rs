//! Settings of a school.

use std::borrow::Borrow;

use askama::Template;
use askama_web::WebTemplate;
use model::{FactorRule, Needed};
use serde::Deserialize;
use words::Language;

use crate::form::{FilledForm, read_ticked_box, read_trimmed_text};
use crate::letters::MailWay;
use crate::training::trainee::needed_in_words;
use crate::{Shell, format};

/// The settings page.
#[derive(Debug, Template, WebTemplate)]
#[template(path = "operations/settings.html")]
pub struct SettingsPage {
    /// Page frame.
    pub shell: Shell,
    /// The form with the current settings, or with refused input.
    pub form: FilledForm<SettingsForm>,
    /// Confirmation of the change that was just made.
    pub done: Option<String>,
    /// Time zones to choose from, by name.
    pub zones: Vec<String>,
    /// Delivery method of emails.
    pub mail_way: MailWay,
    /// Recipient of a test email.
    pub own_email: String,
    /// Evidence required of attempts that count for certificates.
    pub needed: Needed,
    /// Users of whom a second factor is required.
    pub factor_rule: FactorRule,
}

/// Input of the settings form.
#[derive(Clone, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(default)]
pub struct SettingsForm {
    /// Name.
    #[serde(deserialize_with = "read_trimmed_text")]
    pub name: String,
    /// Time zone, a name in the IANA database.
    #[serde(deserialize_with = "read_trimmed_text")]
    pub time_zone: String,
    /// Code of the language for emails.
    pub letter_language: String,
    /// Whether reminders are sent by email.
    #[serde(deserialize_with = "read_ticked_box")]
    pub mails_reminders: bool,
    /// Whether news is sent by email.
    #[serde(deserialize_with = "read_ticked_box")]
    pub mails_news: bool,
    /// Whether trainees see statistics of the others in their cohort.
    #[serde(deserialize_with = "read_ticked_box")]
    pub shows_others: bool,
    /// Days in which attempts on a replaced revision still count.
    #[serde(default = "usual_grace_days", deserialize_with = "read_trimmed_text")]
    pub replaced_grace_days: String,
    /// Who answers for what people tell the school, where to ask, and how long it is kept.
    #[serde(deserialize_with = "read_trimmed_text")]
    pub data_notice: String,
    /// Name of the person who signs certificates on paper.
    #[serde(deserialize_with = "read_trimmed_text")]
    pub signatory_name: String,
    /// Function of that person.
    #[serde(deserialize_with = "read_trimmed_text")]
    pub signatory_function: String,
}

/// Returns the default for schools that have not set it.
fn usual_grace_days() -> String {
    "7".to_owned()
}

impl SettingsPage {
    fn keeps(&self, zone: &str) -> bool {
        self.form.typed.time_zone == zone
    }

    fn writes(&self, language: impl Borrow<Language>) -> bool {
        self.form.typed.letter_language == language.borrow().code()
    }

    fn mail_way_words(&self) -> String {
        match self.mail_way {
            MailWay::Server => {
                tr!("Emails are sent through the mail server. A test email goes to {email}.", email = self.own_email)
            }
            MailWay::Folder => tr!(
                "No mail server is set up: emails are saved as files on the server, and nobody receives them. A test email to {email} is saved there, too.",
                email = self.own_email
            ),
        }
    }

    /// Returns the options for required evidence: value, label, and whether it is the current one.
    fn choices(&self) -> Vec<(&'static str, &'static str, bool)> {
        Needed::ALL.into_iter().map(|one| (one.word(), needed_in_words(one), one == self.needed)).collect()
    }

    /// Returns the options for requiring a second factor: value, label, and whether it is the
    /// current one.
    fn factor_choices(&self) -> Vec<(&'static str, &'static str, bool)> {
        FactorRule::ALL
            .into_iter()
            .map(|rule| (rule.word(), factor_rule_words(rule), rule == self.factor_rule))
            .collect()
    }
}

/// Names the people who need a second factor.
pub(crate) fn factor_rule_words(rule: FactorRule) -> &'static str {
    match rule {
        FactorRule::Nobody => tr!("nobody; everybody may set one up"),
        FactorRule::Teachers => tr!("instructors and administrators"),
        FactorRule::Everybody => tr!("everybody, including trainees"),
    }
}

#[cfg(test)]
mod tests {
    use model::Role;

    use super::*;
    use crate::samples;

    #[test]
    fn what_is_settled_is_shown_and_what_was_typed_wrongly_stays() {
        let typed = SettingsForm {
            name: "Nord <Schule>".to_owned(),
            time_zone: "Europe/Berlin".to_owned(),
            letter_language: "de".to_owned(),
            mails_reminders: true,
            mails_news: false,
            replaced_grace_days: "7".to_owned(),
            shows_others: true,
            data_notice: "Nord <Schule>, Weg 1".to_owned(),
            signatory_name: "Ada <Okafor>".to_owned(),
            signatory_function: "Dean".to_owned(),
        };
        let mut page = SettingsPage {
            shell: samples::shell(Role::Administrator),
            form: FilledForm::new(typed.clone()),
            done: Some("Changed.".to_owned()),
            zones: vec!["Europe/Berlin".to_owned(), "UTC".to_owned()],
            mail_way: MailWay::Folder,
            own_email: "head@example.org".to_owned(),
            needed: Needed::SignedOrSupervised,
            factor_rule: FactorRule::Teachers,
        };
        let html = samples::keep_page("settings", &page);
        assert!(html.contains("Nord &#60;Schule&#62;") && html.contains("nobody receives them"), "{html}");
        assert_eq!(html.matches(" selected").count(), 2, "a zone and a language");
        assert_eq!(
            html.matches(" checked").count(),
            4,
            "reminders, figures of others, and a rule each for certificates and second factors"
        );
        (page.form, page.done) = (FilledForm::refused(typed, "no".to_owned()), None);
        page.mail_way = MailWay::Server;
        assert!(samples::keep_page("settings-refused", &page).contains("through the mail server"));
    }
}
