//! An expert's consent: the current declaration, the history, and the form that records one.

use askama::Template;
use askama_web::WebTemplate;
use model::ids::PersonId;
use serde::Deserialize;
use time::OffsetDateTime;

use crate::form::FilledForm;
use crate::{Shell, StatusWord, format};

/// The page with the consent of a staff member.
#[derive(Debug, Template, WebTemplate)]
#[template(path = "privacy/consent.html")]
pub struct ConsentOfExpertPage {
    /// Page frame.
    pub shell: Shell,
    /// Id of the expert.
    pub person: PersonId,
    /// Name of the expert.
    pub name: String,
    /// Recorded declarations, latest first.
    pub recorded: Vec<Recorded>,
    /// The form for a new declaration.
    pub form: FilledForm<DeclarationForm>,
}

/// Input of the form that records a consent.
#[derive(Clone, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(default)]
pub struct DeclarationForm {
    /// Wording of the consent.
    pub wording: String,
    /// How consent was given.
    pub how: String,
    /// Date on which it was given.
    pub given: String,
}

/// A recorded consent.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Recorded {
    /// Wording of the consent.
    pub wording: String,
    /// How consent was given.
    pub how: String,
    /// Time at which it was given.
    pub given_at: OffsetDateTime,
    /// Name of the user who recorded it.
    pub recorded_by: String,
    /// Time of the withdrawal, and name of the user who recorded it.
    pub withdrawn: Option<(OffsetDateTime, String)>,
}

impl ConsentOfExpertPage {
    fn stands(&self) -> Option<&Recorded> {
        self.recorded.iter().find(|recorded| recorded.withdrawn.is_none())
    }
}

#[cfg(test)]
mod tests {
    //! The wording must be visible, and a consent in force must be revocable.

    use model::Role;

    use super::*;
    use crate::samples;

    #[test]
    fn consent_page_offers_withdrawal_only_of_a_current_consent() {
        let recorded = |withdrawn| Recorded {
            wording: "My attempts may be <shown>.".to_owned(),
            how: "on paper".to_owned(),
            given_at: samples::NOW,
            recorded_by: "Head".to_owned(),
            withdrawn,
        };
        let page = ConsentOfExpertPage {
            shell: samples::shell(Role::Administrator),
            person: PersonId::nil(),
            name: "Dr Osei".to_owned(),
            recorded: vec![recorded(None), recorded(Some((samples::NOW, "Head".to_owned())))],
            form: FilledForm::default(),
        };
        let html = samples::keep_page("expert-consent", &page);
        assert!(html.contains("&#60;shown&#62;") && html.contains("/consent/withdraw"), "{html}");
        let typed = DeclarationForm { wording: "a \"b\"".to_owned(), ..DeclarationForm::default() };
        let page = ConsentOfExpertPage {
            recorded: vec![],
            form: FilledForm::refused(typed, "wording: 0 characters".to_owned()),
            ..page
        };
        let html = samples::keep_page("expert-consent-refused", &page);
        assert!(
            html.contains("a &#34;b&#34;") && html.contains("role=\"alert\"") && !html.contains("/withdraw"),
            "{html}"
        );
    }
}
